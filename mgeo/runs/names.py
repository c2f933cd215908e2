"""Names of variables and objectives, with units where the problem gives them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mgeo.evaluation.designs import variable_names
from mgeo.plugins.discovery import PluginError

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


def column_names(problem: Problem) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the variables and of the objectives.

    They are the problem's ``var_names`` and ``obj_names``, or else the keys of its ``vars``, or
    x1, x2, ..., and f1, f2, ...

    Raises
    ------
    ValueError
        If there is not one name for each, or a name occurs twice.
    """
    variables = _names(problem, "var_names", "x", problem.n_var, variable_names(problem))
    objectives = _names(problem, "obj_names", "f", problem.n_obj)
    both = set(variables) & set(objectives)
    if both:
        raise PluginError(f"{min(both)!r} names both a variable and an objective")
    return variables, objectives


def problem_size(problem: Problem) -> dict[str, Any]:
    """Names of variables and objectives, and the number of constraints, as JSON values.

    Raises
    ------
    ValueError
        As `column_names`.
    """
    variables, objectives = column_names(problem)
    return {
        "variables": list(variables),
        "objectives": list(objectives),
        "constraints": int(problem.n_ieq_constr + problem.n_eq_constr),
    }


def _names(
    problem: Problem,
    attribute: str,
    letter: str,
    count: int,
    declared: tuple[str, ...] | None = None,
) -> tuple[str, ...]:
    default = declared or [f"{letter}{i + 1}" for i in range(count)]
    given = getattr(problem, attribute, None)
    try:
        names = tuple(map(str, default if given is None else given))
    except TypeError as error:
        raise PluginError(
            f"{attribute} of {type(problem).__name__} = {given!r:.80}: expected {count} names"
        ) from error
    if len(set(names)) != count or len(names) != count:
        raise PluginError(
            f"{attribute} of {type(problem).__name__} = {list(names)}: "
            f"expected {count} different names"
        )
    return names
