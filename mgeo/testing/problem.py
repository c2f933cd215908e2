"""Rules of the plugin protocol for problems."""

import json
import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.algorithms.coding import RealCode
from mgeo.algorithms.staged import MGEOStaged
from mgeo.algorithms.variables import KINDS, Variables, designs_of
from mgeo.evaluation.dominance import nondominated
from mgeo.evaluation.individuals import as_numbers
from mgeo.plugins import protocol
from mgeo.plugins.protocol import ProblemMixin, ask, is_own
from mgeo.testing.check import no_error, require, require_equal
from mgeo.testing.view import check_view

Values = Mapping[str, FloatArray]


def check_problem(problem: Problem, seed: int = 0, n_points: int = 8, rtol: float = 1e-12) -> None:
    """Check a problem against the plugin protocol.

    The problem is evaluated at random points and at both corners of its bounds. Optional parts, the
    methods of `mgeo.ProblemMixin` and the view, are checked where the problem defines them.

    Parameters
    ----------
    problem : Problem
        The class must also be constructible without arguments.
    seed : int
        Seed of the random points.
    n_points : int
        Number of random points, at least 2.
    rtol : float
        Relative tolerance between values of the same point in different batches, as vectorized
        sums may round differently. The same batch must give the same values exactly.

    Raises
    ------
    CheckError
        For the first rule that is broken.

    Examples
    --------
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo.testing import check_problem
    >>> check_problem(ZDT1(n_var=4))
    """
    require(isinstance(problem, Problem), f"{problem!r} is not a pymoo Problem")
    with no_error("variables"):
        code = RealCode(Variables.of(problem, KINDS))
    with no_error("names"):
        protocol.column_names(problem)
        protocol.constraint_names(problem)
    points = code.draw([np.random.default_rng(seed)] * n_points)
    X = np.vstack([points, code.variables.xl, code.variables.xu])
    values = _check_evaluation(problem, X)
    _check_batches(problem, X, values, rtol)
    _check_copies(problem, X, values)
    _check_indicator_space(problem, values["F"])
    check_view(problem, X, values["F"])
    _check_starts(problem, seed)
    _check_refinement(problem, X)
    _check_stages(problem, X, values)
    _check_options(problem, X, values)


def _evaluate(problem: Problem, X: FloatArray) -> Values:
    """Evaluate F, G and H of the rows of `X`, which must not be modified."""
    given = designs_of(problem, X.copy())
    with no_error("evaluate(X)"):
        out = problem.evaluate(given, return_values_of=["F", "G", "H"], return_as_dictionary=True)
        left = as_numbers(problem, given)
    require_equal(left, X, "evaluate(X) must not modify X")
    return {key: np.asarray(out[key]) for key in ("F", "G", "H")}


def _require_values(
    problem: Problem, X: FloatArray, expected: Values, rule: str, rtol: float = 0
) -> None:
    for key, found in _evaluate(problem, X).items():
        require_equal(found, expected[key], f"{key}, {rule}", rtol)


def _check_evaluation(problem: Problem, X: FloatArray) -> Values:
    values = _evaluate(problem, X)
    counts = {"F": problem.n_obj, "G": problem.n_ieq_constr, "H": problem.n_eq_constr}
    for key, count in counts.items():
        shape = values[key].shape
        require(shape == (len(X), count), f"{key} of shape {shape}: expected {(len(X), count)}")
        finite = np.isfinite(values[key]).all(axis=1)
        bad = f"{key} of {np.count_nonzero(~finite)} of {len(X)} points is not finite"
        require(finite.all(), f"{bad} (or was never set), such as at x = {X[~finite][:1]}")
    _require_values(problem, X, values, "evaluated again")
    return values


def _check_batches(problem: Problem, X: FloatArray, values: Values, rtol: float) -> None:
    for i in range(len(X)):
        alone = {key: value[i : i + 1] for key, value in values.items()}
        _require_values(problem, X[i : i + 1], alone, f"row {i} evaluated alone", rtol)
    reverse = {key: value[::-1] for key, value in values.items()}
    _require_values(problem, X[::-1].copy(), reverse, "rows evaluated in reverse order", rtol)


def _check_copies(problem: Problem, X: FloatArray, values: Values) -> None:
    with no_error("pickle the problem"):
        revived = pickle.loads(pickle.dumps(problem))
    _require_values(revived, X, values, "evaluated by a pickled copy")
    with no_error(f"{type(problem).__name__}() must be constructible without arguments"):
        type(problem)()


def _check_indicator_space(problem: Problem, F: FloatArray) -> None:
    given = F.copy()
    with no_error("indicator_space(F)"):
        found = ask(problem, ProblemMixin.indicator_space, given)
    require_equal(given, F, "indicator_space(F) must not modify F")
    if found is not None:
        space = np.asarray(found)
        require(space.shape == F.shape, f"indicator_space(F) of shape {space.shape}: {F.shape}")
        require(
            np.array_equal(nondominated(space), nondominated(F)),
            "indicator_space(F) must keep which points dominate which",
        )


def _check_starts(problem: Problem, seed: int) -> None:
    with no_error("starts(n, random_state)"):
        found, again = (
            ask(problem, ProblemMixin.starts, 3, np.random.default_rng(seed)) for _ in range(2)
        )
    if found is None or again is None:
        return
    shape, expected = np.shape(found), (3, problem.n_var)
    require(shape == expected, f"starts(n, random_state) of shape {shape}: expected {expected}")
    require_equal(again, found, "starts(n, random_state), of the same seed")
    _evaluate(problem, np.asarray(found, dtype=float))


def _check_refinement(problem: Problem, X: FloatArray) -> None:
    with no_error("recommended()"):
        advised = protocol.recommended(problem)
    for wanted, method in (
        (advised.starts, ProblemMixin.starts),
        (advised.polish, ProblemMixin.refine),
    ):
        require(
            not wanted or is_own(problem, method),
            f"recommended() = {advised._asdict()}: the problem has no {method.__name__}()",
        )
    if is_own(problem, ProblemMixin.refine):
        with no_error("refine(X)"):
            next(protocol.refinement(problem, X[:0]), None)
            next(protocol.refinement(problem, X[:2]), None)


def _check_stages(problem: Problem, X: FloatArray, values: Values) -> None:
    for stage in range(len(MGEOStaged().stages)):
        with no_error(f"at_stage({stage})"):
            level = ask(problem, ProblemMixin.at_stage, stage)
        require(isinstance(level, Problem), f"at_stage({stage}) is no pymoo Problem: {level!r}")
        for key, found in _evaluate(level, X).items():
            expected = values[key].shape
            require(found.shape == expected, f"{key} of at_stage({stage}): expected {expected}")
    _require_values(problem, X, values, "evaluated after at_stage(k)")


def _check_options(problem: Problem, X: FloatArray, values: Values) -> None:
    with no_error("options(), a dict that survives JSON"):
        options = protocol.options(problem)
        revived = json.loads(json.dumps(options, allow_nan=False))
    if options is None:
        return
    require(revived == options, f"options() = {options!r}: comes back from JSON as {revived!r}")
    cls: Any = type(problem)
    with no_error("build the problem from its options()"):
        build = getattr(cls, "from_options", None)
        again = cls(**revived) if build is None else build(revived)
    require(again.options() == options, "a problem built from options() has other options()")
    _require_values(again, X, values, "evaluated by a problem built from options()")
