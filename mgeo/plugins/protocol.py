"""What a problem of somebody else gives when it is asked, checked where it comes in.

``docs/plugins.md`` lists the optional parts of a problem. A part that raises, or gives something
else than it should, is a `PluginError` that names it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo._foreign import foreign
from mgeo._typing import FloatArray
from mgeo.evaluation.individuals import variable_names
from mgeo.plugins.discovery import PluginError

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go
    from pymoo.core.problem import Problem

#: Columns of a table of ``limits(X)``, and what its ``bound`` may be.
LIMIT_COLUMNS = ("unit", "value", "bound", "limit", "margin")
BOUNDS = ("at most", "at least")


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
    """Names of variables and objectives, and the number of constraints, as JSON values.

    Raises
    ------
    PluginError
        As `column_names`.
    """
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
        return np.asarray(_ask(problem, "indicator_space(F)", is_valid, expected, F), dtype=float)

    return checked


def options(problem: Problem) -> dict[str, Any] | None:
    """Its ``options()``, None if it has none."""

    def is_valid(given: Any) -> bool:
        return isinstance(given, dict) and all(isinstance(key, str) for key in given)

    found: dict[str, Any] | None
    found = _ask(problem, "options()", is_valid, "a dict with keys of type str")
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
    found = _ask(problem, "robust()", lambda given: isinstance(given, Problem), "a pymoo Problem")
    if found is None:
        raise ValueError(f"{type(problem).__name__} has no robust(): expected a run without it")
    if options(found) is None:
        raise PluginError(f"robust() of problem {type(problem).__name__} has no options()")
    return found


def fingerprint(thing: Any) -> str:
    """The ``fingerprint`` by which a problem's or an algorithm's author vouches; empty for none."""
    given = getattr(thing, "fingerprint", None)
    if given is None:
        return ""
    if not isinstance(given, str) or not given:
        raise PluginError(
            f"fingerprint of {type(thing).__name__} = {given!r:.80}: expected a text that says "
            "what it computes"
        )
    return given


def instance_of(problem: Problem) -> str:
    """Its ``instance_of``, the function of which it is one instance or size; empty for none."""
    given = getattr(problem, "instance_of", "")
    if not isinstance(given, str):
        raise PluginError(
            f"instance_of of problem {type(problem).__name__} = {given!r:.80}: expected a text"
        )
    return given


def describe(problem: Problem, X: NDArray[Any]) -> pd.DataFrame | None:
    """Its ``describe(X)``, one row for each of X; None if it has none."""
    import pandas as pd

    def is_valid(given: Any) -> bool:
        return isinstance(given, pd.DataFrame) and len(given) == len(X)

    found: pd.DataFrame | None
    found = _ask(problem, "describe(X)", is_valid, f"a DataFrame of {len(X)} rows", X)
    return found


def answers(problem: Problem, X: NDArray[Any]) -> list[str] | None:
    """Its ``answers(X)``, a line for each of X; None if it has none."""

    def is_valid(given: Any) -> bool:
        return (
            isinstance(given, list)
            and len(given) == len(X)
            and all(isinstance(line, str) and line for line in given)
        )

    found: list[str] | None
    found = _ask(problem, "answers(X)", is_valid, f"a list of {len(X)} texts", X)
    return found


def remarks(problem: Problem, X: NDArray[Any]) -> list[str]:
    """Its ``remarks(X)``, lines about a front as a whole; empty if it has none."""
    return _texts(problem, "remarks(X)", X) if len(X) else []


def impossible(problem: Problem) -> list[str]:
    """Its ``impossible()``, lines that say why nothing can keep all limits; empty if none."""
    return _texts(problem, "impossible()")


def notes(problem: Problem) -> list[str]:
    """Its ``notes()``, lines about the problem as it stands; empty if it has none."""
    return _texts(problem, "notes()")


def ways_out(problem: Problem, X: NDArray[Any]) -> list[str]:
    """Its ``ways_out(X)``, lines about what stands in the way of solutions; empty if none."""
    return _texts(problem, "ways_out(X)", X) if len(X) else []


def limits(problem: Problem, X: NDArray[Any]) -> list[pd.DataFrame] | None:
    """Its ``limits(X)``, a table for each of X, whose columns are checked; None if it has none."""
    import pandas as pd

    def is_table(given: Any) -> bool:
        if not isinstance(given, pd.DataFrame) or not set(LIMIT_COLUMNS) <= set(given.columns):
            return False
        numbers = all(given[name].map(_is_number).all() for name in ("value", "limit", "margin"))
        return numbers and bool(given["bound"].isin(BOUNDS).all())

    def is_valid(given: Any) -> bool:
        return isinstance(given, list) and len(given) == len(X) and all(map(is_table, given))

    expected = f"{len(X)} DataFrames with the columns {', '.join(LIMIT_COLUMNS)}"
    found: list[pd.DataFrame] | None
    found = _ask(problem, "limits(X)", is_valid, expected, X)
    return found


def front_summary(problem: Problem, F: FloatArray) -> dict[str, float]:
    """Its ``front_summary(F)``, empty if it has none."""

    def is_valid(given: Any) -> bool:
        return isinstance(given, Mapping) and all(
            isinstance(value, int | float | np.number) for value in given.values()
        )

    found = _ask(problem, "front_summary(F)", is_valid, "a dict of numbers", F)
    return {str(name): value for name, value in (found or {}).items()}


def front_figure(problem: Problem, X: NDArray[Any]) -> go.Figure | None:
    """The figure ``front`` of its ``figures(X)``, None if it has none."""

    def is_valid(given: Any) -> bool:
        return isinstance(given, Mapping) and (
            given.get("front") is None or _are_figures({"front": given["front"]})
        )

    found = _ask(problem, "figures(X)", is_valid, "a dict of plotly figures", X)
    return (found or {}).get("front")


def solution_figures(problem: Problem, X: NDArray[Any]) -> list[dict[str, go.Figure]]:
    """Its ``solution_figures(X)``, one dict for each of X; empty if it has none."""

    def is_valid(given: Any) -> bool:
        return isinstance(given, list) and len(given) == len(X) and all(map(_are_figures, given))

    expected = f"{len(X)} dicts of plotly figures"
    found = _ask(problem, "solution_figures(X)", is_valid, expected, X) if len(X) else None
    return [{str(name): figure for name, figure in each.items()} for each in found or []]


def _texts(problem: Problem, call: str, *arguments: Any) -> list[str]:
    """Lines that an optional method gives, empty if the problem has none of this name."""

    def is_valid(given: Any) -> bool:
        return isinstance(given, list) and all(isinstance(line, str) and line for line in given)

    found: list[str] | None = _ask(problem, call, is_valid, "a list of texts", *arguments)
    return found or []


def _ask(
    problem: Problem, call: str, is_valid: Callable[[Any], bool], expected: str, *arguments: Any
) -> Any:
    """What an optional method returns, checked; None if the problem has none of this name."""
    name = call.partition("(")[0]
    method = getattr(problem, name, None)
    if method is None:
        return None
    owner = f"of problem {type(problem).__name__}"
    try:
        with foreign():
            given = method(*arguments)
            given = list(given) if isinstance(given, Iterator) else given
    except Exception as error:  # whatever a problem raises: foreign code
        raised = f"{type(error).__name__}: {error}".removesuffix(": ")
        raise PluginError(f"{name} {owner} raised {raised}") from error
    if not is_valid(given):
        sized = isinstance(given, np.ndarray) or hasattr(given, "iloc")
        found = f"{type(given).__name__} of shape {np.shape(given)}" if sized else repr(given)
        raise PluginError(f"{call} {owner} gives {found:.80}: expected {expected}")
    return given


def _is_number(given: Any) -> bool:
    return isinstance(given, int | float | np.number) and not isinstance(given, bool)


def _are_figures(given: Any) -> bool:
    import plotly.graph_objects as go

    return isinstance(given, Mapping) and all(isinstance(f, go.Figure) for f in given.values())


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
