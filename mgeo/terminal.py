"""Text and tables on terminals, in pipes and in logs, for all commands and those of plugins."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral, Real
from typing import TYPE_CHECKING

from rich.console import Console, RenderableType
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    import pandas as pd

_WIDTH_OF_A_FILE = 400  # of tables in pipes and files, unless COLUMNS is set


def table(titles: Iterable[object], rows: Iterable[Sequence[object]], digits: int = 5) -> Table:
    """Return a table without lines, texts aligned to the left and other values to the right.

    Parameters
    ----------
    digits
        Significant digits of numbers that are not whole.
    """
    entries = list(rows)
    made = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 3, 0, 0))
    for i, title in enumerate(titles):
        is_text = all(isinstance(row[i], str) for row in entries)
        made.add_column(plain(title), justify="left" if is_text else "right", overflow="fold")
    for row in entries:
        made.add_row(*(plain(_shown(value, digits)) for value in row))
    return made


def fits(shown: Table, width: int) -> bool:
    """Return whether a table can be printed in a width without wrapping a cell."""
    out = console()
    measured = Measurement.get(out, out.options.update(max_width=_WIDTH_OF_A_FILE), shown)
    return measured.maximum <= width


def titled(title: str, frame: pd.DataFrame, digits: int = 4) -> tuple[Text, Table]:
    """Return a title and the `table` of a frame with its index."""
    rows = frame.itertuples(name=None)
    return plain(f"\n{title}", "bold"), table(["", *frame.columns], rows, digits)


def note(text: str) -> Text:
    """Return a note on a table."""
    return plain(text, "dim")


def pairs(texts: Mapping[str, str]) -> Table:
    """Return a table of names and their values, one per line."""
    grid = Table.grid(padding=(0, 2))
    for name, text in texts.items():
        grid.add_row(plain(name, style="dim"), plain(text))
    return grid


def _shown(value: object, digits: int) -> str:
    whole = not isinstance(value, Real) or isinstance(value, Integral)
    return str(value) if whole else f"{value:.{digits}g}"


def console(*, stderr: bool = False) -> Console:
    """Return a console on stdout or stderr, 400 columns wide in a pipe without COLUMNS."""
    made = Console(stderr=stderr, highlight=False)
    if not made.is_terminal and "COLUMNS" not in os.environ:
        made.width = _WIDTH_OF_A_FILE
    return made


def show(*shown: str | RenderableType, stderr: bool = False) -> None:
    """Print text and tables, each on lines of its own. In a pipe no line of text is broken."""
    out = console(stderr=stderr)
    for each in shown:
        if isinstance(each, str | Text):
            text = plain(each) if isinstance(each, str) else each
            # a path that is longer than a line stays whole
            out.print(text, soft_wrap=not out.is_terminal, overflow="ignore", crop=False)
        else:
            out.print(each)


def plain(text: object, style: str = "") -> Text:
    """Return text for a console, with its control characters as escapes."""
    escaped = (c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in str(text))
    return Text("".join(escaped), style=style)
