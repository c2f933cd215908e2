"""Parts of the screens of ``verify``, ``fly`` and ``calibrate``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from textwrap import fill, wrap

import pandas as pd
from rich.console import JustifyMethod
from rich.table import Table

from mgeo.plugins.review import Section, find_column_kinds, format_cells
from mgeo.terminal import Output, escape_text, format_note

#: Width of text [columns].
_WIDTH = 80


def wrap_text(text: str, indent: str = "") -> str:
    """Wrap a text at 80 columns, with all lines but the first indented."""
    return fill(
        text, _WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def print_sections(sections: Iterable[Section], output: Output) -> None:
    """Print sections, each with its title, table, note and lines of text."""
    for section in sections:
        output.print(escape_text(f"\n{section.title}", "bold"))
        if section.table is not None:
            output.print(_build_table(section.table))
        if section.note:
            output.print(format_note(wrap_text(section.note)))
        output.print(*(wrap_text(line, "  ") for line in section.lines))


def print_warnings(lines: Iterable[str], output: Output) -> None:
    """Print warnings, one sentence each."""
    for line in lines:
        output.print(wrap_text(line))


def print_files(files: Mapping[str, str], output: Output) -> None:
    """Print the names of written files with their contents."""
    if files:
        width = max(map(len, files))
        lines = (f"{file:{width}}  {content}" for file, content in files.items())
        output.print(escape_text("\nFiles", "bold"), *lines)


def print_next_steps(steps: Sequence[str], output: Output) -> None:
    """Print what the user can do next, one line per step."""
    if steps:
        output.print(escape_text("\nNext", "bold"), *steps)


def _build_table(frame: pd.DataFrame) -> Table:
    rows = format_cells(frame, digits=4)
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 2, 0, 0))
    for column, kind in zip(zip(*rows, strict=True), find_column_kinds(rows), strict=True):
        title, *cells = column
        width = max(len(title) // 2 + 2, *map(len, (*cells, *title.split())))
        justify: JustifyMethod = "right" if kind == "number" else "left"
        head = escape_text("\n".join(wrap(title, width)))
        table.add_column(head, justify=justify, vertical="bottom", overflow="fold")
    for row in rows[1:]:
        table.add_row(*map(escape_text, row))
    return table
