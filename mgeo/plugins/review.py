"""What a document for a review says of one solution."""

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
        "number" if all(_is_number(value) for value in column[1:]) else "text"
        for column in zip(*rows, strict=True)
    ]


def _is_number(value: str) -> bool:
    try:
        float(value or "nan")
    except ValueError:
        return False
    return True


def _shown(value: object, digits: int) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.{digits}g}"
    return str(value)
