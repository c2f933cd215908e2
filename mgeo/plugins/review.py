"""Review documents of single solutions, and the cells and JSON records of their tables.

A section is declared once and is shown by the terminal, HTML pages and JSON output.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from mgeo._text import format_column, format_key, is_number

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Section:
    """Section of a review document with a title, paragraphs and an optional table.

    Attributes
    ----------
    title : str
    lines : tuple of str
        Paragraphs of plain text above the table. A line that begins with a hyphen is a list item.
    table : DataFrame, optional
        Table with row names as index, or with a RangeIndex for rows without names. A column title
        may end with a unit in brackets, as in ``duration [s]``.
    note : str
        Text below the table, which says what the table shows. Paragraphs are separated by newlines.
    decimals : mapping of str to int
        Number of decimals for each column title. Other columns have three significant digits.
    max_rows : int, optional
        Maximum number of rows that a terminal shows.
    full_command : str
        Command whose output has all rows of the table, such as ``mgeo report``.
    key : str
        Name of the section in options and in JSON output.
    is_detail : bool
        False for a section of the first page, True for details that follow.
    """

    title: str
    lines: tuple[str, ...] = ()
    table: pd.DataFrame | None = None
    note: str = ""
    decimals: Mapping[str, int] = field(default_factory=dict)
    max_rows: int | None = None
    full_command: str = ""
    key: str = ""
    is_detail: bool = False


@dataclass(frozen=True)
class Review:
    """Review document of one solution, for the person who approves the solution.

    Attributes
    ----------
    title : str
        Title, for example the name of the maneuver that a reviewer approves.
    summary : str
        Summary of the solution in one line.
    sections : tuple of Section
        Sections of the first page, followed by details.
    """

    title: str
    summary: str
    sections: tuple[Section, ...]


def build_records(table: pd.DataFrame) -> list[Any]:
    """Return the rows of a table as dicts for JSON output, with units in the keys.

    The column ``duration [s]`` has the key ``duration_s``. Row names are included, unless the index
    is a RangeIndex.
    """
    import pandas as pd

    complete = table if isinstance(table.index, pd.RangeIndex) else table.reset_index()
    return complete.set_axis([format_key(str(c)) for c in complete], axis=1).to_dict("records")


def format_bounds(types: pd.Series, values: pd.Series | Sequence[str]) -> pd.Series:
    """Return bounds as texts such as "max 5".

    Parameters
    ----------
    types : Series of str
        "at most" or "at least". Other types, such as that of a row without a bound, give NaN.
    values : Series or sequence of str
        Formatted values of the bounds.
    """
    return types.map({"at most": "max", "at least": "min"}) + " " + values


def format_cells(
    table: pd.DataFrame, digits: int = 3, decimals: Mapping[str, int] | None = None
) -> list[list[str]]:
    """Format a table as rows of strings. The first row contains the column titles.

    Parameters
    ----------
    table : DataFrame
        The index becomes the first column, unless it is a RangeIndex.
    digits : int
        Significant digits of floats; large numbers have all digits before the decimal point, and
        a column of integral numbers has no decimals. NaN becomes an empty string.
    decimals : mapping of str to int, optional
        Number of decimals for each column title.
    """
    import pandas as pd

    head, fixed = [str(name) for name in table.columns], decimals or {}
    columns = [
        format_column(table.iloc[:, j].tolist(), fixed.get(name), digits)
        for j, name in enumerate(head)
    ]
    rows = [list(row) for row in zip(*columns, strict=True)]
    if isinstance(table.index, pd.RangeIndex):
        return [head, *rows]
    return [
        [str(table.index.name or ""), *head],
        *([str(name), *row] for name, row in zip(table.index, rows, strict=True)),
    ]


def find_column_kinds(rows: Sequence[Sequence[str]]) -> list[str]:
    """Classify each column of a formatted table as ``"number"`` or ``"text"``.

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
        "number" if all(is_number(value) for value in column[1:]) else "text"
        for column in zip(*rows, strict=True)
    ]
