"""Check that the view of a problem returns tables, figures and text of the expected types."""

import json
from typing import Any

import pandas as pd
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.figures.motion import validate_motion
from mgeo.plugins.review import Review, Section
from mgeo.plugins.view import View, build_view
from mgeo.testing.check import convert_to_check_error, require, require_equal

_FIGURES = ("solution_figures", "figure_dicts")
_LINES = ("warnings", "suggestions", "infeasibility_reasons", "notes")
_CONSTRAINT_COLUMNS = {"unit", "value", "bound_type", "bound_value", "margin"}


def check_view(problem: Problem, X: FloatArray, F: FloatArray) -> None:
    """Check that the view of a problem returns tables, figures and text of the expected types.

    The view is checked with solutions and without.

    Parameters
    ----------
    problem : Problem
    X : array, shape (n, n_var)
        Designs of the solutions, n > 0.
    F : array, shape (n, n_obj)
        Objectives of the solutions.

    Raises
    ------
    CheckError
        For the first rule that the view violates.
    """
    with convert_to_check_error("view(X)"):
        view, empty = build_view(problem, X), build_view(problem)
    require(isinstance(view, View), f"view(X) = {view!r:.80}: expected a View")
    n = len(X)
    for name in ("describe", "quick_metrics", "front_table"):
        table = _call_method(view, name)
        is_table = isinstance(table, pd.DataFrame) and len(table) == n
        _require(is_table, name, table, f"a DataFrame of {n} rows")
    lists = {name: _call_method(view, name) for name in ("summaries", "constraints", *_FIGURES)}
    for name, each in lists.items():
        is_list = isinstance(each, list) and len(each) == n
        _require(is_list, name, each, f"a list with an entry for each of {n} solutions")
    for table in lists["constraints"]:
        _require(
            set(table.columns) >= _CONSTRAINT_COLUMNS,
            "constraints",
            table,
            f"{_CONSTRAINT_COLUMNS}",
        )
    for figures in lists["solution_figures"]:
        for name, figure in figures.items():
            with convert_to_check_error(
                f"solution_figures(), {name!r} as a still or animated figure"
            ):
                validate_motion(figure)
    for name in _LINES:
        lines = _call_method(view, name)
        are_texts = isinstance(lines, list) and all(isinstance(line, str) for line in lines)
        _require(are_texts, name, lines, "a list of texts")
    single = view.select([0])
    for presented, name, kind in ((view, "figures", dict), (single, "review", Review)):
        value = _call_method(presented, name)
        _require(isinstance(value, kind), name, value, f"a {kind.__name__}")
    sections = _call_method(single, "overview")
    are_sections = isinstance(sections, dict) and all(
        isinstance(section, Section) for section in sections.values()
    )
    _require(are_sections, "overview", sections, "a dict of sections")
    with convert_to_check_error("next_commands() of the view"):
        commands = view.next_commands("runs/a")
    _require(isinstance(commands, dict), "next_commands", commands, "a dict of texts")
    for name in ("infeasibility_reasons", "notes", "facts"):
        _call_method(empty, name)
    with convert_to_check_error("front_summary(F) must return JSON values"):
        json.dumps(empty.front_summary(F.copy()))


def _call_method(view: View, method: str) -> Any:
    X_before = view.X.copy()
    with convert_to_check_error(f"{method}() of the view"):
        value = getattr(view, method)()
    require_equal(view.X, X_before, f"{method}() of the view must not modify X")
    return value


def _require(condition: bool, method: str, value: Any, expected: str) -> None:
    require(condition, f"{method}() of the view = {value!r:.80}: expected {expected}")
