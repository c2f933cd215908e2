"""What the view of a problem of somebody else gives when it is asked, checked, and its `Review`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np

from mgeo._typing import FloatArray
from mgeo.plugins.protocol import checked_part

if TYPE_CHECKING:
    import pandas as pd
    from pymoo.core.problem import Problem


@dataclass(frozen=True)
class Section:
    """A part of a review: paragraphs, then a table.

    Attributes
    ----------
    title : str
    lines : tuple of str
        Plain text.
    table : DataFrame, optional
        Its index names the rows, unless that only counts them.
    note : str
        Below the table.
    """

    title: str
    lines: tuple[str, ...] = ()
    table: pd.DataFrame | None = None
    note: str = ""


@dataclass(frozen=True)
class Review:
    """One solution, from what it is about to what it leaves.

    Attributes
    ----------
    title : str
        Of the document: what is to be approved.
    answer : str
        What the solution is worth, in one line.
    sections : tuple of Section
    """

    title: str
    answer: str
    sections: tuple[Section, ...]


def cells(table: pd.DataFrame, digits: int = 4) -> list[list[str]]:
    """A table as texts, its titles first; numbers that are not whole with so many digits."""
    import pandas as pd

    head = [str(name) for name in table.columns]
    rows = [[_shown(value, digits) for value in row] for row in table.astype(object).to_numpy()]
    if isinstance(table.index, pd.RangeIndex):
        return [head, *rows]
    return [
        [str(table.index.name or ""), *head],
        *([str(name), *row] for name, row in zip(table.index, rows, strict=True)),
    ]


def kinds_of(rows: Sequence[Sequence[str]]) -> list[str]:
    """Of each column of `cells` whether it is ``text``, or ``number``."""
    return [
        "number" if all(_reads_as_number(value) for value in column[1:]) else "text"
        for column in zip(*rows, strict=True)
    ]


def _reads_as_number(value: str) -> bool:
    try:
        float(value or "nan")
    except ValueError:
        return False
    return True


def _shown(value: object, digits: int) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.{digits}g}"
    return str(value)


P = ParamSpec("P")
T = TypeVar("T")

#: Columns of a table of a view's ``limits()``, and what its ``bound`` may be.
LIMIT_COLUMNS = ("unit", "value", "bound", "limit", "margin")
BOUNDS = ("at most", "at least")


class Shown(Protocol):
    """Of what a view is asked: of which solutions of which problem it is."""

    problem: Problem
    X: FloatArray


#: Of each method of a view what it may give for it, and how that is said.
_RULES: dict[str, tuple[Callable[[Shown, Any], bool], str]] = {
    **dict.fromkeys(
        ("describe", "glance"),
        (
            lambda view, given: _is_frame(given) and len(given) == len(view.X),
            "a DataFrame of {n} rows",
        ),
    ),
    "answers": (
        lambda view, given: _are_texts(given) and len(given) == len(view.X),
        "a list of {n} texts",
    ),
    "limits": (
        lambda view, given: _are_of(given, view) and all(map(_is_table, given)),
        "{n} DataFrames with the columns " + ", ".join(LIMIT_COLUMNS),
    ),
    **dict.fromkeys(
        ("remarks", "ways_out", "impossible", "notes"),
        (lambda view, given: _are_texts(given), "a list of texts"),
    ),
    "figures": (lambda view, given: _are_figures(given), "a dict of plotly figures"),
    "solution_figures": (
        lambda view, given: _are_of(given, view) and all(map(_are_figures, given)),
        "{n} dicts of plotly figures",
    ),
    "drawings": (
        lambda view, given: _are_of(given, view) and all(map(_are_trees, given)),
        "{n} dicts of dicts with data and layout",
    ),
    "facts": (
        lambda view, given: isinstance(given, Mapping) and _are_texts([*given, *given.values()]),
        "a dict of texts by texts",
    ),
    "front_summary": (lambda view, given: _are_numbers(given), "a dict of numbers"),
}
#: Methods of a view of any number of solutions.
SHOWN = tuple(_RULES)
_RULES["review"] = (
    lambda view, given: type(given).__name__ == "Review",
    "a mgeo.plugins.shown.Review",
)


def ask(view: Shown, method: Callable[Concatenate[Any, P], T], *args: P.args, **kw: P.kwargs) -> T:
    """What a method of a view, such as ``View.describe``, gives, checked.

    Raises
    ------
    PluginError
        If it raises, or gives something else than a `View` should.
    """
    name = method.__name__
    is_valid, expected = _RULES[name]
    given: T = checked_part(
        view.problem,
        f"{name}({'F' if args else ''})",
        partial(getattr(view, name), *args, **kw),
        partial(is_valid, view),
        expected.format(n=len(view.X)),
    )
    return given


def _is_frame(given: Any) -> bool:
    import pandas as pd

    return isinstance(given, pd.DataFrame)


def _is_table(given: Any) -> bool:
    """Whether it is a table of limits."""
    if not _is_frame(given) or not set(LIMIT_COLUMNS) <= set(given.columns):
        return False
    numbers = all(given[name].map(_is_number).all() for name in ("value", "limit", "margin"))
    return numbers and bool(given["bound"].isin(BOUNDS).all())


def _are_of(given: Any, view: Shown) -> bool:
    return isinstance(given, list) and len(given) == len(view.X)


def _are_texts(given: Any) -> bool:
    return isinstance(given, list) and all(isinstance(line, str) and line for line in given)


def _are_numbers(given: Any) -> bool:
    return isinstance(given, Mapping) and all(
        isinstance(value, int | float | np.number) for value in given.values()
    )


def _is_number(given: Any) -> bool:
    return isinstance(given, int | float | np.number) and not isinstance(given, bool)


def _are_figures(given: Any) -> bool:
    import plotly.graph_objects as go

    return isinstance(given, Mapping) and all(
        figure is None or isinstance(figure, go.Figure) for figure in given.values()
    )


def _are_trees(given: Any) -> bool:
    return isinstance(given, Mapping) and all(
        isinstance(tree, Mapping) and {"data", "layout"} == tree.keys() for tree in given.values()
    )
