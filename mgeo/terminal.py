"""Terminal output of commands: text and tables, or one JSON document.

Commands of plugins use this module, too.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, TextIO

from rich.console import Console, RenderableType
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    import pandas as pd

_PIPE_WIDTH = 400  # Columns of tables in pipes and files, unless COLUMNS is set.
_stdout_stack: list[TextIO] = []  # The real stdout while `reserve_stdout` is active.


@dataclass(frozen=True)
class Output:
    """Output of a command in the format that the user selected.

    Attributes
    ----------
    quiet : bool
        True to print only errors, and the JSON document if `json` is true.
    json : bool
        True to print only one JSON document on stdout.
    """

    quiet: bool = False
    json: bool = False

    @property
    def is_text(self) -> bool:
        """True if text and tables are printed."""
        return not (self.quiet or self.json)

    def print(self, *renderables: str | RenderableType) -> None:
        """Print text and tables on separate lines, unless `quiet` or `json` is true."""
        if self.is_text:
            show(*renderables)

    def print_note(self, text: str) -> None:
        """Print a line on stderr."""
        show(text, stderr=True)

    def print_document(self, document: Mapping[str, Any]) -> None:
        """Print a JSON document on stdout if `json` is true."""
        if self.json:
            print(format_json(document), file=_stdout_stack[0] if _stdout_stack else sys.stdout)


def format_json(document: Mapping[str, Any]) -> str:
    """Return a document as JSON text, with null for NaN and infinite numbers."""
    from pydantic_core import to_jsonable_python

    finite = to_jsonable_python(dict(document), inf_nan_mode="null")
    return json.dumps(finite, indent=2, allow_nan=False)


def to_records(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """Return the rows of a table as dicts, including the index unless it is a RangeIndex."""
    import pandas as pd

    named = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    return named.to_dict("records")


@contextmanager
def reserve_stdout() -> Iterator[None]:
    """Reserve stdout for `Output.result` and redirect all other output to stderr."""
    _stdout_stack.append(sys.stdout)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _stdout_stack.pop()


def build_table(
    titles: Iterable[object], rows: Iterable[Sequence[object]], digits: int = 5
) -> Table:
    """Return a table without borders, with text left-aligned and other values right-aligned.

    Parameters
    ----------
    titles : iterable
        Column titles.
    rows : iterable of sequences
        Values of each row.
    digits : int
        Significant digits of floats.
    """
    entries = list(rows)
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 3, 0, 0))
    for i, title in enumerate(titles):
        is_text = all(isinstance(row[i], str) for row in entries)
        table.add_column(
            escape_text(title), justify="left" if is_text else "right", overflow="fold"
        )
    for row in entries:
        table.add_row(*(escape_text(_format_value(value, digits)) for value in row))
    return table


def is_within_width(content: Table, width: int) -> bool:
    """Return whether a table fits into a width in columns without wrapping a cell."""
    out = build_console()
    measurement = Measurement.get(out, out.options.update(max_width=_PIPE_WIDTH), content)
    return measurement.maximum <= width


def build_titled_table(title: str, frame: pd.DataFrame, digits: int = 4) -> tuple[Text, Table]:
    """Return a bold title and the `table` of a DataFrame, including its index."""
    rows = frame.itertuples(name=None)
    return escape_text(f"\n{title}", "bold"), build_table(["", *frame.columns], rows, digits)


def format_note(text: str) -> Text:
    """Return dimmed text, for a note below a table."""
    return escape_text(text, "dim")


def build_key_value_table(texts: Mapping[str, str]) -> Table:
    """Return a table with one name and its text per line."""
    grid = Table.grid(padding=(0, 2))
    for name, text in texts.items():
        grid.add_row(escape_text(name, style="dim"), escape_text(text))
    return grid


def _format_value(value: object, digits: int) -> str:
    is_exact = not isinstance(value, Real) or isinstance(value, Integral)
    return str(value) if is_exact else f"{value:.{digits}g}"


def build_console(*, stderr: bool = False) -> Console:
    """Return a console on stdout or stderr, with 400 columns if it is not a terminal.

    The environment variable COLUMNS overrides the width.
    """
    console = Console(stderr=stderr, highlight=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = _PIPE_WIDTH
    return console


def show(*renderables: str | RenderableType, stderr: bool = False) -> None:
    """Print text and tables on separate lines; lines of text are wrapped only in a terminal."""
    out = build_console(stderr=stderr)
    for each in renderables:
        if isinstance(each, str | Text):
            text = escape_text(each) if isinstance(each, str) else each
            # Long paths must not be truncated.
            out.print(text, soft_wrap=not out.is_terminal, overflow="ignore", crop=False)
        else:
            out.print(each)


def escape_text(text: object, style: str = "") -> Text:
    """Return text for a console, with control characters escaped.

    Prevents that names from files or plugins send control sequences to the terminal.
    """
    escaped = (c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in str(text))
    return Text("".join(escaped), style=style)
