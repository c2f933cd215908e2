"""Check that a problem meets the requirements of mgeo."""

import json
import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.algorithms.encoding import RealEncoding
from mgeo.algorithms.staged import MGEOStaged
from mgeo.algorithms.variables import KINDS, Variables, convert_numbers_to_designs
from mgeo.evaluation.dominance import find_nondominated
from mgeo.evaluation.individuals import convert_designs_to_numbers
from mgeo.plugins import protocol
from mgeo.plugins.protocol import ProblemMixin, call_optional, has_override
from mgeo.testing.check import convert_to_check_error, require, require_equal
from mgeo.testing.view import check_view

Values = Mapping[str, FloatArray]


def check_problem(problem: Problem, seed: int = 0, n_points: int = 8, rtol: float = 1e-12) -> None:
    """Check a problem and its optional methods, and raise CheckError for the first violated rule.

    The problem is evaluated at random points and at its lower and upper bounds. Optional methods of
    `mgeo.ProblemMixin` and the view are checked if the problem defines them.

    Parameters
    ----------
    problem : Problem
        Problem whose class can be constructed without arguments.
    seed : int
        Seed of the random points.
    n_points : int
        Number of random points, at least 2.
    rtol : float
        Relative tolerance between values of the same point in different batches, because vectorized
        sums may round differently. Repeated evaluations of a batch must agree exactly.

    Raises
    ------
    CheckError
        For the first rule that the problem violates.

    Examples
    --------
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo.testing import check_problem
    >>> check_problem(ZDT1(n_var=4))
    """
    require(isinstance(problem, Problem), f"{problem!r} is not a pymoo Problem")
    with convert_to_check_error("variables"):
        encoding = RealEncoding(Variables.from_problem(problem, KINDS))
    with convert_to_check_error("names"):
        protocol.get_column_names(problem)
        protocol.get_constraint_names(problem)
    points = encoding.draw([np.random.default_rng(seed)] * n_points)
    X = np.vstack([points, encoding.variables.xl, encoding.variables.xu])
    values = _check_evaluation(problem, X)
    _check_batches(problem, X, values, rtol)
    _check_copies(problem, X, values)
    _check_indicator_space(problem, values["F"])
    check_view(problem, X, values["F"])
    _check_initial_designs(problem, seed)
    _check_refinement(problem, X)
    _check_fidelities(problem, X, values)
    _check_options(problem, X, values)


def _evaluate(problem: Problem, X: FloatArray) -> Values:
    """Evaluate a problem, and check that the evaluation does not modify the designs."""
    designs = convert_numbers_to_designs(problem, X.copy())
    with convert_to_check_error("evaluate(X)"):
        out = problem.evaluate(designs, return_values_of=["F", "G", "H"], return_as_dictionary=True)
        X_after = convert_designs_to_numbers(problem, designs)
    require_equal(X_after, X, "evaluate(X) must not modify X")
    return {key: np.asarray(out[key]) for key in ("F", "G", "H")}


def _require_values(
    problem: Problem, X: FloatArray, expected: Values, rule: str, rtol: float = 0
) -> None:
    for key, value in _evaluate(problem, X).items():
        require_equal(value, expected[key], f"{key}, {rule}", rtol)


def _check_evaluation(problem: Problem, X: FloatArray) -> Values:
    values = _evaluate(problem, X)
    counts = {"F": problem.n_obj, "G": problem.n_ieq_constr, "H": problem.n_eq_constr}
    for key, count in counts.items():
        shape = values[key].shape
        require(shape == (len(X), count), f"{key} of shape {shape}: expected {(len(X), count)}")
        is_finite = np.isfinite(values[key]).all(axis=1)
        message = f"{key} of {np.count_nonzero(~is_finite)} of {len(X)} points is not finite"
        require(
            is_finite.all(), f"{message} (or was never set), such as at x = {X[~is_finite][:1]}"
        )
    _require_values(problem, X, values, "evaluated again")
    return values


def _check_batches(problem: Problem, X: FloatArray, values: Values, rtol: float) -> None:
    for i in range(len(X)):
        row_values = {key: value[i : i + 1] for key, value in values.items()}
        _require_values(problem, X[i : i + 1], row_values, f"row {i} evaluated alone", rtol)
    reversed_values = {key: value[::-1] for key, value in values.items()}
    rule = "rows evaluated in reverse order"
    _require_values(problem, X[::-1].copy(), reversed_values, rule, rtol)


def _check_copies(problem: Problem, X: FloatArray, values: Values) -> None:
    with convert_to_check_error("pickle the problem"):
        unpickled = pickle.loads(pickle.dumps(problem))
    _require_values(unpickled, X, values, "evaluated by a pickled copy")
    with convert_to_check_error(
        f"{type(problem).__name__}() must be constructible without arguments"
    ):
        type(problem)()


def _check_indicator_space(problem: Problem, F: FloatArray) -> None:
    argument = F.copy()
    with convert_to_check_error("map_to_indicator_space(F)"):
        mapped = call_optional(problem, ProblemMixin.map_to_indicator_space, argument)
    require_equal(argument, F, "map_to_indicator_space(F) must not modify F")
    if mapped is not None:
        space = np.asarray(mapped)
        require(
            space.shape == F.shape,
            f"map_to_indicator_space(F) of shape {space.shape}: expected {F.shape}",
        )
        require(
            np.array_equal(find_nondominated(space), find_nondominated(F)),
            "map_to_indicator_space(F) must preserve dominance between points",
        )


def _check_initial_designs(problem: Problem, seed: int) -> None:
    with convert_to_check_error("suggest_initial_designs(n, random_state)"):
        designs, repeated = (
            call_optional(
                problem, ProblemMixin.suggest_initial_designs, 3, np.random.default_rng(seed)
            )
            for _ in range(2)
        )
    if designs is None or repeated is None:
        return
    shape, expected = np.shape(designs), (3, problem.n_var)
    require(
        shape == expected,
        f"suggest_initial_designs(n, random_state) of shape {shape}: expected {expected}",
    )
    require_equal(
        repeated,
        designs,
        "suggest_initial_designs(n, random_state), called again with the same seed",
    )
    _evaluate(problem, np.asarray(designs, dtype=float))


def _check_refinement(problem: Problem, X: FloatArray) -> None:
    with convert_to_check_error("recommend_settings()"):
        settings = protocol.get_recommended_settings(problem)
    for setting, method in (
        (settings.initial_designs, ProblemMixin.suggest_initial_designs),
        (settings.refine, ProblemMixin.refine),
    ):
        require(
            not setting or has_override(problem, method),
            f"recommend_settings() = {settings._asdict()}: the problem has no {method.__name__}()",
        )
    if has_override(problem, ProblemMixin.refine):
        with convert_to_check_error("refine(X)"):
            next(protocol.iterate_refinement(problem, X[:0]), None)
            next(protocol.iterate_refinement(problem, X[:2]), None)


def _check_fidelities(problem: Problem, X: FloatArray, values: Values) -> None:
    for fidelity in range(len(MGEOStaged().fidelity_schedule)):
        call = f"at_fidelity({fidelity})"
        with convert_to_check_error(call):
            cheaper = call_optional(problem, ProblemMixin.at_fidelity, fidelity)
        require(isinstance(cheaper, Problem), f"{call} = {cheaper!r}: expected a pymoo Problem")
        for key, value in _evaluate(cheaper, X).items():
            expected = values[key].shape
            message = f"{key} of {call} of shape {value.shape}: expected {expected}"
            require(value.shape == expected, message)
    _require_values(problem, X, values, "evaluated after at_fidelity(k)")


def _check_options(problem: Problem, X: FloatArray, values: Values) -> None:
    with convert_to_check_error("to_options() must return JSON values"):
        options = protocol.get_options(problem)
        decoded = json.loads(json.dumps(options, allow_nan=False))
    if options is None:
        return
    require(decoded == options, f"to_options() = {options!r}: comes back from JSON as {decoded!r}")
    cls: Any = type(problem)
    with convert_to_check_error("build the problem from its to_options()"):
        build = getattr(cls, "from_options", None)
        rebuilt = cls(**decoded) if build is None else build(decoded)
    require(
        rebuilt.to_options() == options,
        f"to_options() of a problem built from to_options() = {rebuilt.to_options()!r}: expected "
        f"{options!r}",
    )
    _require_values(rebuilt, X, values, "evaluated by a problem built from to_options()")
