"""What a problem of somebody else gives when it is asked, checked; for its view see `shown`.

``docs/plugins.md`` lists the optional parts of a problem. A part that raises, or gives something
else than it should, is a `PluginError` that names it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from functools import partial
from operator import length_hint
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray
from mgeo.evaluation.individuals import variable_names
from mgeo.plugins.discovery import PluginError, code_of_others

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


def column_names(problem: Problem) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the variables and of the objectives.

    They are the problem's ``var_names`` and ``obj_names``, or else the keys of its ``vars``, or
    x1, x2, ..., and f1, f2, ...

    Raises
    ------
    PluginError
        If there is not one name for each, or a name occurs twice.
    """
    variables = _names(problem, "var_names", "x", problem.n_var, variable_names(problem))
    objectives = _names(problem, "obj_names", "f", problem.n_obj)
    both = set(variables) & set(objectives)
    if both:
        raise PluginError(f"{min(both)!r} names both a variable and an objective")
    return variables, objectives


def constraint_names(problem: Problem) -> tuple[str, ...]:
    """``constraint_names``, or g1, g2, ..., of inequalities, and h1, h2, ... of equalities.

    Raises
    ------
    PluginError
        If there is not one name for each inequality, or a name occurs twice.
    """
    equalities = tuple(f"h{j + 1}" for j in range(problem.n_eq_constr))
    return (*_names(problem, "constraint_names", "g", problem.n_ieq_constr), *equalities)


def problem_size(problem: Problem) -> dict[str, Any]:
    """Names of variables and objectives, and the number of constraints, as JSON values."""
    variables, objectives = column_names(problem)
    return {
        "variables": list(variables),
        "objectives": list(objectives),
        "constraints": int(problem.n_ieq_constr + problem.n_eq_constr),
    }


def indicator_space(problem: Problem) -> Callable[[ArrayLike], FloatArray] | None:
    """Its ``indicator_space``, which takes and gives shape (n, n_obj); None if it has none."""
    if getattr(problem, "indicator_space", None) is None:
        return None

    def checked(F: ArrayLike) -> FloatArray:
        def is_valid(given: Any) -> bool:
            try:
                points = np.asarray(given, dtype=float)
            except (TypeError, ValueError):
                return False
            return points.shape == np.shape(F) and bool(np.isfinite(points).all())

        expected = f"finite numbers of shape {np.shape(F)}"
        return np.asarray(asked(problem, "indicator_space(F)", is_valid, expected, F), dtype=float)

    return checked


def options(problem: Problem) -> dict[str, Any] | None:
    """Its ``options()``, None if it has none."""

    def is_valid(given: Any) -> bool:
        return isinstance(given, dict) and all(isinstance(key, str) for key in given)

    found: dict[str, Any] | None
    found = asked(problem, "options()", is_valid, "a dict with keys of type str")
    return found


def robust(problem: Problem) -> Problem:
    """Its ``robust()``, the problem of solutions that keep what they promise.

    Raises
    ------
    ValueError
        If it has none.
    PluginError
        If it gives no problem, or one whose ``options()`` would not build it again.
    """
    from pymoo.core.problem import Problem

    found: Problem | None
    found = asked(problem, "robust()", lambda given: isinstance(given, Problem), "a pymoo Problem")
    if found is None:
        raise ValueError(f"{type(problem).__name__} has no robust(): expected a run without it")
    if options(found) is None:
        raise PluginError(f"robust() of problem {type(problem).__name__} has no options()")
    return found


def refinement(problem: Problem, X: FloatArray) -> Generator[FloatArray]:
    """What its ``refine(X)`` gives in the place of solutions, bit by bit, each shape (n, n_var).

    Tables may have more rows, which follow, and no fewer than the one before. Of a problem that
    has none it is refused.
    """
    owner = f"of problem {type(problem).__name__}"
    if getattr(problem, "refine", None) is None:
        raise PluginError(f"refine {owner} is missing: expected a run without --polish")
    with code_of_others(f"refine {owner} raised"):
        steps = iter(problem.refine(X.copy()))
    least = len(X)
    while True:
        with code_of_others(f"refine {owner} raised"):
            given = next(steps, None)
            table = None if given is None else np.array(given, dtype=float)
        if table is None:
            return
        fits = table.ndim == 2 and table.shape[1] == X.shape[1] and len(table) >= least
        if not (fits and np.isfinite(table).all()):
            raise PluginError(
                f"refine(X) {owner} gives {given!r:.80}: expected finite numbers of shape "
                f"({least}, {X.shape[1]}), or more rows"
            )
        least = len(table)
        yield table


def refinement_steps(problem: Problem, X: FloatArray) -> int:
    """How many steps as long as its first one its ``refine(X)`` has, 0 if it does not say."""
    with code_of_others(f"refine of problem {type(problem).__name__} raised"):
        return length_hint(problem.refine(X.copy()))


class Recommended(NamedTuple):
    """With how many of its starts and evaluations, and whether with a polish, a run is best made.

    Evaluations, if there are any, go with the polish.
    """

    starts: int = 0
    polish: bool = False
    evaluations: int | None = None


def recommended(problem: Problem) -> Recommended:
    """What its ``recommended()`` gives."""

    def is_valid(given: Any) -> bool:
        if not isinstance(given, dict) or given.keys() - set(Recommended._fields):
            return False
        found = Recommended(**given)
        evaluations = 1 if found.evaluations is None else found.evaluations
        numbers = type(found.starts) is int and type(evaluations) is int
        return numbers and found.starts >= 0 and evaluations >= 1 and isinstance(found.polish, bool)

    expected = "a dict of starts, an int >= 0, polish, a bool, and evaluations, an int >= 1"
    return Recommended(**(asked(problem, "recommended()", is_valid, expected) or {}))


def instance_of(problem: Problem) -> str:
    """Its ``instance_of``, the function of which it is one instance or size; empty for none."""
    given = getattr(problem, "instance_of", "")
    if not isinstance(given, str):
        raise PluginError(
            f"instance_of of problem {type(problem).__name__} = {given!r:.80}: expected a text"
        )
    return given


def asked(
    problem: Problem, call: str, is_valid: Callable[[Any], bool], expected: str, *arguments: Any
) -> Any:
    """What an optional method returns, checked; None if the problem has none of this name."""
    method = getattr(problem, call.partition("(")[0], None)
    if method is None:
        return None
    return checked_part(problem, call, partial(method, *arguments), is_valid, expected)


def checked_part(
    problem: Problem,
    call: str,
    made: Callable[[], Any],
    is_valid: Callable[[Any], bool],
    expected: str,
) -> Any:
    """What a part of a problem gives when it is asked, checked."""
    owner = f"of problem {type(problem).__name__}"
    with code_of_others(f"{call.partition('(')[0]} {owner} raised"):
        given = made()
        given = list(given) if isinstance(given, Iterator) else given
    if not is_valid(given):
        sized = isinstance(given, np.ndarray) or hasattr(given, "iloc")
        found = f"{type(given).__name__} of shape {np.shape(given)}" if sized else repr(given)
        raise PluginError(f"{call} {owner} gives {found:.80}: expected {expected}")
    return given


def _names(
    problem: Problem,
    attribute: str,
    letter: str,
    count: int,
    declared: tuple[str, ...] | None = None,
) -> tuple[str, ...]:
    default = declared or [f"{letter}{i + 1}" for i in range(count)]
    given = getattr(problem, attribute, None)
    label = f"{attribute} of {type(problem).__name__}"
    try:
        names = tuple(map(str, default if given is None else given))
    except TypeError as error:
        raise PluginError(f"{label} = {given!r:.80}: expected {count} names") from error
    if len(set(names)) != count or len(names) != count:
        raise PluginError(f"{label} = {list(names)}: expected {count} different names")
    return names
