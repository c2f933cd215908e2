"""Review documents of single solutions, and the conversion of their sections to text and JSON.

A section is declared once and is shown by the terminal, HTML pages and JSON output.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from mgeo._text import TEXT_WIDTH, format_column, format_key, is_number, wrap_text

if TYPE_CHECKING:
    import pandas as pd

_GAP = "  "


@dataclass(frozen=True)
class Section:
    """Section of a review document: a title, paragraphs, and an optional table.

    Attributes
    ----------
    title : str
    lines : tuple of str
        Paragraphs of plain text.
    table : DataFrame, optional
        Table with row names as index, or with a RangeIndex for rows without names. A column title
        may end with a unit in brackets, as in ``duration [s]``.
    note : str
        Text below the table, which says what the table shows.
    decimals : mapping of str to int
        Columns that a terminal shows with a fixed number of decimals, by title. All other numbers
        have three significant digits.
    max_rows : int, optional
        Maximum number of rows that a terminal shows.
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
    key: str = ""
    is_detail: bool = False


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
        Sections of the first page, followed by details.
    """

    title: str
    summary: str
    sections: tuple[Section, ...]


def format_section(section: Section, width: int = TEXT_WIDTH) -> str:
    """Return the paragraphs, the table and the note of a section as plain text.

    Parameters
    ----------
    section : Section
    width : int
        Width available for the table. Paragraphs are not wider than `TEXT_WIDTH`.
    """
    table = [] if section.table is None else [format_table(section.table, width)]
    paragraphs = [wrap_text(line, width=width) for line in (*section.lines, section.note) if line]
    n_lines = len(section.lines)
    return "\n".join([*paragraphs[:n_lines], *table, *paragraphs[n_lines:]])


def format_table(table: pd.DataFrame, width: int = TEXT_WIDTH) -> str:
    """Return a table as plain text that is not wider than a terminal.

    Units are on a line of their own below the names in the column titles. Numbers are aligned to
    the right. If the columns do not fit side by side, they continue below with the row names
    repeated.

    Parameters
    ----------
    table : DataFrame
    width : int
        Width of the terminal [columns].
    """
    import pandas as pd

    rows = format_cells(table)
    kinds = find_column_kinds(rows)
    cells = [[[value] for value in column] for column in zip(*rows[1:], strict=True)]
    heads = [
        _split_title(title, max((len(text) for (text,) in column), default=0))
        for title, column in zip(rows[0], cells, strict=True)
    ]
    widths = [
        max(len(line) for lines in (head, *column) for line in lines)
        for head, column in zip(heads, cells, strict=True)
    ]
    longest = max(range(len(widths)), key=lambda j: (kinds[j] == "text") * widths[j])
    available = width - sum(widths) + widths[longest] - len(_GAP) * (len(widths) - 1)
    if kinds[longest] == "text" and widths[longest] > max(available, width // 2):
        widths[longest] = max(available, width // 2)
        cells[longest] = [
            textwrap.wrap(text, widths[longest]) or [""] for (text,) in cells[longest]
        ]
    names = [] if isinstance(table.index, pd.RangeIndex) else [0]
    parts = _split_columns(widths, names, width, len(widths))
    if len(parts) > 1:  # Distribute the columns evenly.
        parts = _split_columns(widths, names, width, -(-len(widths) // len(parts)) + len(names))
    return "\n\n".join(
        _join_columns(
            [heads[j] for j in part],
            [[column[i] for column in (cells[j] for j in part)] for i in range(len(table))],
            [widths[j] for j in part],
            [kinds[j] == "number" and j not in names for j in part],
        )
        for part in parts
    )


def _split_columns(
    widths: Sequence[int], first: list[int], width: int, max_columns: int
) -> list[list[int]]:
    """Split the columns of a table into parts that fit into a width; `first` is in each part."""
    parts = [[0]]
    for j in range(1, len(widths)):
        part_width = sum(widths[i] + len(_GAP) for i in parts[-1]) + widths[j]
        if part_width > width or len(parts[-1]) == max_columns:
            parts.append([*first])
        parts[-1].append(j)
    return parts


def _split_title(title: str, width: int) -> list[str]:
    """Split a column title into the name, on two lines if longer than `width`, and the unit."""
    name, _, unit = title.partition(" [")
    words = name.split(" ")
    halves = [[" ".join(words[:i]), " ".join(words[i:])] for i in range(1, len(words))]
    lines = min(halves, key=lambda half: max(map(len, half)), default=[name])
    return [*([name] if len(name) <= width else lines), *([unit.removesuffix("]")] if unit else [])]


def _join_columns(
    heads: Sequence[list[str]],
    rows: Sequence[Sequence[list[str]]],
    widths: Sequence[int],
    are_numbers: Sequence[bool],
) -> str:
    height = max(map(len, heads))
    head = [[""] * (height - len(lines)) + lines for lines in heads]
    result = []
    for row in (head, *rows):
        for k in range(max(map(len, row))):
            texts = [lines[k] if k < len(lines) else "" for lines in row]
            aligned = [
                text.rjust(size) if is_number else text.ljust(size)
                for text, size, is_number in zip(texts, widths, are_numbers, strict=True)
            ]
            result.append(_GAP.join(aligned).rstrip())
    return "\n".join(result)


def build_records(table: pd.DataFrame) -> list[Any]:
    """Return the rows of a table as dicts for JSON output, with units in the keys.

    The column ``duration [s]`` has the key ``duration_s``. Row names are included, unless the index
    is a RangeIndex.
    """
    import pandas as pd

    complete = table if isinstance(table.index, pd.RangeIndex) else table.reset_index()
    return complete.set_axis([format_key(str(c)) for c in complete], axis=1).to_dict("records")


def format_cells(table: pd.DataFrame, digits: int = 3) -> list[list[str]]:
    """Convert a table to rows of strings, of which the first contains the column titles.

    Parameters
    ----------
    table : DataFrame
        The index becomes the first column, unless it is a RangeIndex.
    digits : int
        Significant digits of floats; large numbers have all digits before the decimal point, and
        a column of integral numbers has no decimals. NaN becomes an empty string.
    """
    import pandas as pd

    head = [str(name) for name in table.columns]
    columns = [format_column(table.iloc[:, j].tolist(), digits=digits) for j in range(len(head))]
    rows = [list(row) for row in zip(*columns, strict=True)]
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
        "number" if all(is_number(value) for value in column[1:]) else "text"
        for column in zip(*rows, strict=True)
    ]
