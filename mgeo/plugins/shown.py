"""One solution as a document for a review, and its tables as text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Section:
    """A part of a review: paragraphs, then a table.

    Attributes
    ----------
    title : str
    lines : tuple of str
        Plain text, one paragraph each.
    table : DataFrame, optional
        The index names the rows, unless it only counts them.
    note : str
        Text below the table.
    """

    title: str
    lines: tuple[str, ...] = ()
    table: pd.DataFrame | None = None
    note: str = ""


@dataclass(frozen=True)
class Review:
    """One solution as a document.

    Attributes
    ----------
    title : str
        What is to be approved.
    answer : str
        Summary of the solution in one line.
    sections : tuple of Section
    """

    title: str
    answer: str
    sections: tuple[Section, ...]


def cells(table: pd.DataFrame, digits: int = 4) -> list[list[str]]:
    """Return a table as text, column titles first, with `digits` digits of each float."""
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
    """Return for each column of `cells` whether it is ``text`` or ``number``."""
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
