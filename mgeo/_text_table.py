"""Layout of sections as text: tables in aligned columns, and wrapped paragraphs."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from mgeo._text import TEXT_WIDTH, wrap_text
from mgeo.plugins.review import Section, find_column_kinds, format_cells

if TYPE_CHECKING:
    import pandas as pd


def format_section(section: Section, width: int = TEXT_WIDTH) -> Iterator[tuple[str, str]]:
    """Yield the title, paragraphs, table and notes of a section as plain text.

    Parameters
    ----------
    section : Section
    width : int
        Width available for the table [columns]. Paragraphs are not wider than `TEXT_WIDTH`.

    Yields
    ------
    kind : {"title", "text", "head", "rows", "note"}
    text : str
        One line or several lines.
    """
    if section.title:
        yield "title", wrap_text(section.title, width=width)
    for line in section.lines:
        yield "text", wrap_item(line, width)
    notes = section.note.splitlines()
    if section.table is not None:
        shown = section.table.iloc[: section.max_rows]
        for i, (head, rows) in enumerate(lay_out_table(shown, width, section.decimals)):
            yield "head", f"\n{head}" if i else head
            yield "rows", rows
        if n_more := len(section.table) - len(shown):
            command = f"; {section.full_command} has all" if section.full_command else ""
            notes.insert(0, f"And {n_more} more row{'' if n_more == 1 else 's'}{command}.")
    for line in notes:
        yield "note", wrap_item(line, width)


def wrap_item(text: str, width: int = TEXT_WIDTH) -> str:
    """Wrap a paragraph or a list item.

    A list item begins with a hyphen, and its further lines are indented.
    """
    return wrap_text(text, "  " if text.startswith("- ") else "", width)


def lay_out_table(
    table: pd.DataFrame, width: int = TEXT_WIDTH, decimals: Mapping[str, int] | None = None
) -> list[tuple[str, str]]:
    """Lay out a table as plain text that is not wider than a terminal.

    Units are on a line of their own below the names in the column titles. Numbers are aligned to
    the right. Two spaces separate the columns, or one space if the table fits only in this way. If
    the columns do not fit side by side, they continue below with the row names repeated.

    Parameters
    ----------
    table : DataFrame
    width : int
        Width of the terminal [columns].
    decimals : mapping of str to int, optional
        Numbers of decimals of columns, keyed by column title.

    Returns
    -------
    list of (str, str)
        Column titles and rows of each part of the table.
    """
    import pandas as pd

    rows = format_cells(table, decimals=decimals)
    kinds = find_column_kinds(rows)
    cells = [[[value] for value in column] for column in zip(*rows[1:], strict=True)]
    cells = cells or [[] for _ in rows[0]]
    heads = [_split_unit(title) for title in rows[0]]
    widths = _measure_columns(heads, cells)
    if _measure_row(widths) > width:
        cell_widths = [max((len(text) for (text,) in column), default=0) for column in cells]
        heads = list(map(_split_name, heads, cell_widths))
        widths = _measure_columns(heads, cells)
    gap = 1 if _measure_row(widths, 1) <= width < _measure_row(widths) else 2
    longest = max(range(len(widths)), key=lambda j: (kinds[j] == "text") * widths[j])
    available = width - _measure_row(widths, gap) + widths[longest]
    if kinds[longest] == "text" and widths[longest] > max(available, width // 2):
        widths[longest] = max(available, width // 2)
        cells[longest] = [
            textwrap.wrap(text, widths[longest]) or [""] for (text,) in cells[longest]
        ]
    names = [] if isinstance(table.index, pd.RangeIndex) else [0]
    parts = _split_columns(widths, names, width, len(widths), gap)
    if len(parts) > 1:  # Distribute the columns evenly.
        n_columns = -(-len(widths) // len(parts)) + len(names)
        parts = _split_columns(widths, names, width, n_columns, gap)
    result = []
    for part in parts:
        sizes = [widths[j] for j in part]
        are_numbers = [kinds[j] == "number" and j not in names for j in part]
        height = max(len(heads[j]) for j in part)
        head = [[""] * (height - len(heads[j])) + heads[j] for j in part]
        body = [[cells[j][i] for j in part] for i in range(len(table))]
        lines = [_join_cells(row, sizes, are_numbers, gap) for row in body]
        result.append((_join_cells(head, sizes, are_numbers, gap), "\n".join(lines)))
    return result


def _measure_columns(heads: Sequence[list[str]], cells: Sequence[Sequence[list[str]]]) -> list[int]:
    return [
        max(len(line) for lines in (head, *column) for line in lines)
        for head, column in zip(heads, cells, strict=True)
    ]


def _measure_row(widths: Sequence[int], gap: int = 2) -> int:
    return sum(widths) + gap * (len(widths) - 1)


def _split_columns(
    widths: Sequence[int], first: list[int], width: int, max_columns: int, gap: int
) -> list[list[int]]:
    """Split the columns of a table into parts that fit a given width.

    Each further part repeats the columns `first`.
    """
    parts = [[0]]
    for j in range(1, len(widths)):
        part_width = _measure_row([widths[i] for i in (*parts[-1], j)], gap)
        if part_width > width or len(parts[-1]) == max_columns:
            parts.append([*first])
        parts[-1].append(j)
    return parts


def _split_unit(title: str) -> list[str]:
    name, _, unit = title.partition(" [")
    return [name, unit.removesuffix("]")] if unit else [name]


def _split_name(head: list[str], width: int) -> list[str]:
    """Split a long column name into two lines of similar length."""
    name, words = head[0], head[0].split(" ")
    if len(name) <= width or len(words) == 1:
        return head
    halves = ([" ".join(words[:i]), " ".join(words[i:])] for i in range(1, len(words)))
    return [*min(halves, key=lambda half: max(map(len, half))), *head[1:]]


def _join_cells(
    row: Sequence[list[str]], widths: Sequence[int], are_numbers: Sequence[bool], gap: int
) -> str:
    """Format a table row whose cells may have several lines."""
    lines = []
    for k in range(max(map(len, row))):
        texts = [cell[k] if k < len(cell) else "" for cell in row]
        aligned = [
            text.rjust(size) if is_number else text.ljust(size)
            for text, size, is_number in zip(texts, widths, are_numbers, strict=True)
        ]
        lines.append((" " * gap).join(aligned).rstrip())
    return "\n".join(lines)
