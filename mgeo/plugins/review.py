"""Review documents of single solutions, and the conversion of their tables to text.

Commands and reports write these documents for a reviewer who approves a solution.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Section:
    """Section of a review document: a title, paragraphs, and an optional table.

    Attributes
    ----------
    title : str
    lines : tuple of str
        Paragraphs of plain text.
    table : DataFrame, optional
        Table with row names as index, or with a RangeIndex for rows without names.
    note : str
        Text below the table.
    decimals : mapping of str to int
        Columns that a terminal shows with a fixed number of decimals, by title. All other numbers
        have three significant digits.
    max_rows : int, optional
        Maximum number of rows that a terminal shows.
    """

    title: str
    lines: tuple[str, ...] = ()
    table: pd.DataFrame | None = None
    note: str = ""
    decimals: Mapping[str, int] = field(default_factory=dict)
    max_rows: int | None = None


@dataclass(frozen=True)
class Review:
    """Review document of one solution, for a reviewer who checks and approves the solution.

    Attributes
    ----------
    title : str
        Title, for example the name of the maneuver that a reviewer approves.
    summary : str
        Summary of the solution in one line.
    sections : tuple of Section
    """

    title: str
    summary: str
    sections: tuple[Section, ...]


def format_cells(table: pd.DataFrame, digits: int = 4) -> list[list[str]]:
    """Convert a table to rows of strings, of which the first contains the column titles.

    Parameters
    ----------
    table : DataFrame
        The index becomes the first column, unless it is a RangeIndex.
    digits : int
        Significant digits of floats. NaN becomes an empty string.
    """
    import pandas as pd

    head = [str(name) for name in table.columns]
    rows = [
        [_format_value(value, digits) for value in row] for row in table.astype(object).to_numpy()
    ]
    if isinstance(table.index, pd.RangeIndex):
        return [head, *rows]
    return [
        [str(table.index.name or ""), *head],
        *([str(name), *row] for name, row in zip(table.index, rows, strict=True)),
    ]


def find_column_kinds(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return ``"number"`` for each numeric column of a table of strings, otherwise ``"text"``.

    Parameters
    ----------
    rows : sequence of sequences of str
        Return value of `format_cells`. The first row contains the column titles.

    Returns
    -------
    list of str
        ``"number"`` if every cell of the column is a number or empty.
    """
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


def _format_value(value: object, digits: int) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.{digits}g}"
    return str(value)
