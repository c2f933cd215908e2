"""The rules of the plugin protocol for problems, and how a check fails."""

import json
import pickle
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pymoo.core.problem import Problem

from mgeo._foreign import foreign
from mgeo._typing import FloatArray
from mgeo.algorithms.coding import RealCode
from mgeo.algorithms.staged import MGEOStaged
from mgeo.algorithms.starting import SuggestedSampling
from mgeo.algorithms.variables import KINDS, Variables, designs_of
from mgeo.evaluation.dominance import nondominated
from mgeo.evaluation.individuals import as_numbers
from mgeo.figures.motion import check_motion
from mgeo.plugins import protocol
from mgeo.plugins.shown import SHOWN, ask
from mgeo.plugins.view import View, view_of


class CheckError(AssertionError):
    """A plugin breaks a rule; the message names the rule, what was expected and what was found."""


def require(condition: bool | np.bool_, message: str) -> None:
    """Raise `CheckError` with `message` unless `condition` holds."""
    if not condition:
        raise CheckError(message)


def require_equal(found: ArrayLike, expected: ArrayLike, rule: str, rtol: float = 0.0) -> None:
    """Raise `CheckError` unless two arrays agree in shape and value, NaN being equal to NaN."""
    a, b = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    require(a.shape == b.shape, f"{rule}: got shape {a.shape}, expected {b.shape}")
    same = np.isclose(a, b, rtol=rtol, atol=0, equal_nan=True)
    if not same.all():
        at = tuple(int(i) for i in np.argwhere(~same)[0])
        raise CheckError(f"{rule}: got {a[at]} at {at}, expected {b[at]}")


@contextmanager
def no_error(rule: str) -> Iterator[None]:
    """Turn whatever a plugin raises into a `CheckError` that says what was being checked."""
    try:
        with foreign():
            yield
    except CheckError:
        raise
    except Exception as error:  # the plugin is foreign code: it may raise anything
        raise CheckError(f"{rule}: {type(error).__name__}: {error}") from error


#: What a view of no solutions is asked.
OF_NONE = {"impossible", "facts", "notes", "front_summary"}


def check_problem(problem: Problem, seed: int = 0, n_points: int = 8, rtol: float = 1e-12) -> None:
    """Check a problem against the plugin protocol.

    The problem is evaluated at `n_points` random points and at both corners of its bounds, some
    of them several times. Optional parts of the protocol are checked where the problem has them;
    those about designs get them as numbers, of a choice that of its option.

    Parameters
    ----------
    problem : an instance; its class must also be constructible without arguments.
    seed : of the random points.
    n_points : number of random points, at least 2.
    rtol : how much values may depend on what is evaluated beside them (vectorized sums may round
        differently); 0 for not at all. Repetition must always give the same values exactly.

    Raises
    ------
    CheckError : for the first rule that is broken.

    Examples
    --------
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo.testing import check_problem
    >>> check_problem(ZDT1(n_var=4))
    """
    require(isinstance(problem, Problem), f"{problem!r} is not a pymoo Problem")
    _check_bounds(problem)
    _check_names(problem)
    with no_error("instance_of"):
        protocol.instance_of(problem)
    X = _points(problem, np.random.default_rng(seed), n_points)
    values = _check_evaluation(problem, X)
    _check_grouping(problem, X, values, rtol)
    _check_copies(problem, X, values)
    _check_presentation(problem, X, values["F"])
    _check_search(problem, X, seed)
    _check_stages(problem, X, values)
    _check_options(problem, X, values)


def evaluated(problem: Problem, X: FloatArray) -> dict[str, FloatArray]:
    """F, G and H of the rows of `X`, which must come back unmodified."""
    given = _designs(problem, X)
    with no_error("evaluate(X)"):
        out = problem.evaluate(given, return_values_of=["F", "G", "H"], return_as_dictionary=True)
    with no_error("evaluate(X) must not modify X"):
        left = as_numbers(problem, given)
    require_equal(left, X, "evaluate(X) must not modify X")
    return {key: np.asarray(out[key]) for key in ("F", "G", "H")}


def _points(problem: Problem, rng: np.random.Generator, n: int) -> FloatArray:
    """(n + 2, n_var) numbers: random points, and both corners of the bounds."""
    if getattr(problem, "vars", None) is not None:
        code = RealCode(Variables.of(problem, KINDS))
        return np.vstack([code.draw([rng] * n), code.variables.xl, code.variables.xu])
    unit = rng.random((n, problem.n_var))
    return np.vstack([problem.xl + (problem.xu - problem.xl) * unit, problem.xl, problem.xu])


def _designs(problem: Problem, X: FloatArray) -> NDArray[Any]:
    """Points as the problem takes them, which share nothing with `X`."""
    return designs_of(problem, X.copy())


def _check_bounds(problem: Problem) -> None:
    for name in ("n_var", "n_obj"):
        require(getattr(problem, name) >= 1, f"{name} = {getattr(problem, name)}: expected >= 1")
    if getattr(problem, "vars", None) is not None:
        with no_error("vars"):
            Variables.of(problem, KINDS)
        return
    for name in ("xl", "xu"):
        bound = getattr(problem, name)
        require(
            np.shape(bound) == (problem.n_var,) and np.isfinite(bound).all(),
            f"{name} = {bound}: expected {problem.n_var} finite numbers",
        )
    require(
        np.all(problem.xl <= problem.xu), f"expected xl <= xu, got {problem.xl} and {problem.xu}"
    )


def _check_names(problem: Problem) -> None:
    for attribute, count in (("var_names", problem.n_var), ("obj_names", problem.n_obj)):
        names = getattr(problem, attribute, None)
        if names is None:
            continue
        require(
            len(names) == count and all(isinstance(name, str) and name for name in names),
            f"{attribute} = {names!r}: expected {count} nonempty strings",
        )
        require(len(set(names)) == count, f"{attribute} = {names!r}: expected distinct names")


def _check_evaluation(problem: Problem, X: FloatArray) -> dict[str, FloatArray]:
    values = evaluated(problem, X)
    counts = {"F": problem.n_obj, "G": problem.n_ieq_constr, "H": problem.n_eq_constr}
    for key, count in counts.items():
        shape = values[key].shape
        require(shape == (len(X), count), f"{key} of shape {shape}: expected {(len(X), count)}")
        rows = np.flatnonzero(~np.isfinite(values[key]).all(axis=1))
        require(
            len(rows) == 0,
            f"{key} of {len(rows)} of {len(X)} points is not finite (or was never set), such as "
            f"{values[key][rows[:1]]} at x = {X[rows[:1]]}",
        )
    _require_values(problem, X, values, "evaluated again")
    return values


def _require_values(
    problem: Problem, X: FloatArray, expected: Mapping[str, FloatArray], rule: str, rtol: float = 0
) -> None:
    for key, found in evaluated(problem, X).items():
        require_equal(found, expected[key], f"{key}, {rule}", rtol)


def _check_grouping(
    problem: Problem, X: FloatArray, values: Mapping[str, FloatArray], rtol: float
) -> None:
    for i in range(len(X)):
        alone = {key: value[i : i + 1] for key, value in values.items()}
        _require_values(problem, X[i : i + 1], alone, f"row {i} evaluated alone", rtol)
    reverse = {key: value[::-1] for key, value in values.items()}
    _require_values(problem, X[::-1].copy(), reverse, "rows evaluated in reverse order", rtol)


def _check_copies(problem: Problem, X: FloatArray, values: Mapping[str, FloatArray]) -> None:
    with no_error("pickle the problem"):
        revived = pickle.loads(pickle.dumps(problem))
    _require_values(revived, X, values, "evaluated by a pickled copy")
    with no_error(f"{type(problem).__name__}() must be constructible without arguments"):
        type(problem)()


def _check_presentation(problem: Problem, X: FloatArray, F: FloatArray) -> None:
    if hasattr(problem, "indicator_space"):
        space = np.asarray(_asked(problem, "indicator_space", F=F))
        require(space.shape == F.shape, f"indicator_space(F) of shape {space.shape}: not {F.shape}")
        require(np.isfinite(space).all(), "indicator_space(F) must be finite where F is")
        require(
            np.array_equal(nondominated(space), nondominated(F)),
            "indicator_space(F) must keep which points dominate which",
        )
    with no_error("view(X)"):
        view, none = view_of(problem, X), view_of(problem)
    found = {}
    for name in SHOWN:
        given = [F.copy()] if name == "front_summary" else []
        with no_error(f"{name} of view(X)"):
            found[name] = ask(view, getattr(View, name), *given)
        require_equal(view.X, X, f"{name} of view(X) must not modify X")
        if name in OF_NONE:
            with no_error(f"{name} of view(X) of no solutions"):
                ask(none, getattr(View, name), *given)
    with no_error("front_summary(F), one row of JSON-able values"):
        json.dumps(found["front_summary"])
    for i, figures in enumerate(found["solution_figures"]):
        for name, figure in figures.items():
            with no_error(f"solution_figures()[{i}][{name!r}], a figure that moves or does not"):
                check_motion(figure)


def _check_search(problem: Problem, X: FloatArray, seed: int) -> None:
    """What it suggests to a search, and what it makes of what that has found."""
    with no_error("recommended(), of what it has"):
        starts, polish, _ = protocol.recommended(problem)
    require(
        (not starts or hasattr(problem, "starts")) and (not polish or hasattr(problem, "refine")),
        f"recommended() gives {starts} starts and polish = {polish}: expected of what it has",
    )
    if hasattr(problem, "starts"):
        for n in (1, 3):
            first, again = (
                SuggestedSampling(n).suggested(problem, n, np.random.default_rng(seed))
                for _ in range(2)
            )
            require_equal(again, first, "starts(n, random_state), of the same seed")
            with no_error("starts(n, random_state), within the bounds"):
                evaluated(problem, first)
    if hasattr(problem, "refine"):
        for rows in (X[:0], X[:2]):
            with no_error("refine(X)"):
                next(protocol.refinement(problem, rows), None)


def _check_stages(problem: Problem, X: FloatArray, values: Mapping[str, FloatArray]) -> None:
    """How stages of a search judge the points, in those that `MGEOStaged` has by default."""
    if not hasattr(problem, "at_stage"):
        return
    for stage in range(len(MGEOStaged().stages)):
        with no_error(f"at_stage({stage})"):
            judge = problem.at_stage(stage)
        require(isinstance(judge, Problem), f"at_stage({stage}) is no pymoo Problem: {judge!r}")
        for key, found in evaluated(judge, X).items():
            shape, expected = found.shape, values[key].shape
            require(shape == expected, f"{key} of at_stage({stage}) of shape {shape}: {expected}")
    _require_values(problem, X, values, "evaluated after at_stage(k)")


def _asked(problem: Problem, method: str, **given: FloatArray) -> Any:
    """What a method gives for an array, which it must leave as it is."""
    ((name, array),) = given.items()
    copy = array.copy()
    with no_error(f"{method}({name})"):
        answer = getattr(problem, method)(copy)
    require_equal(copy, array, f"{method}({name}) must not modify {name}")
    return answer


def _check_options(problem: Problem, X: FloatArray, values: Mapping[str, FloatArray]) -> None:
    if not hasattr(problem, "options"):
        return
    cls: Any = type(problem)
    with no_error("options(), a dict that survives JSON"):
        options = problem.options()
        revived = json.loads(json.dumps(options, allow_nan=False))
    require(revived == options, f"options() = {options!r}: comes back from JSON as {revived!r}")
    with no_error("build the problem from its options()"):
        again = cls.from_options(revived) if hasattr(cls, "from_options") else cls(**revived)
    require(again.options() == options, "a problem built from options() has other options()")
    _require_values(again, X, values, "evaluated by a problem built from options()")
