"""Terminal output of commands: text and tables, or one JSON document.

The commands of mgeo and of its plugins use this module.
"""

from __future__ import annotations

import json
import os
import re
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, TextIO

from rich.console import Console, RenderableType
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from mgeo._text import TEXT_WIDTH, format_column, is_number, wrap_text

if TYPE_CHECKING:
    import pandas as pd
    from rich.console import JustifyMethod

    from mgeo.plugins.review import Section

#: Space between the columns of a table [columns].
_GAP = 2
_PIPE_WIDTH = 400  # width of tables in pipes and files [columns], unless COLUMNS is set
_stdout_stack: list[TextIO] = []  # the original stdout while `reserve_stdout` is active


@dataclass(frozen=True)
class Output:
    """Printer of the output of a command, as text or JSON according to ``--quiet`` and ``--json``.

    Attributes
    ----------
    quiet : bool
        True to print no text except errors.
    json : bool
        True to print one JSON document on stdout in place of the text.
    """

    quiet: bool = False
    json: bool = False

    @property
    def is_text(self) -> bool:
        """True if text and tables are printed, that is, if both `quiet` and `json` are false."""
        return not (self.quiet or self.json)

    def print(self, *renderables: str | RenderableType) -> None:
        """Print texts and tables, each on a new line, unless `quiet` or `json` is true."""
        if self.is_text:
            show(*renderables)

    def print_note(self, text: str) -> None:
        """Print a line of text on stderr, even if `quiet` or `json` is true."""
        show(text, stderr=True)

    def print_document(self, document: Mapping[str, Any]) -> None:
        """Print a dict as a JSON document on stdout if `json` is true, otherwise print nothing."""
        if self.json:
            print(format_json(document), file=_stdout_stack[0] if _stdout_stack else sys.stdout)


def format_json(document: Mapping[str, Any]) -> str:
    """Return a dict as indented JSON text, with null in place of NaN and infinite numbers."""
    from pydantic_core import to_jsonable_python

    finite = to_jsonable_python(dict(document), inf_nan_mode="null")
    return json.dumps(finite, indent=2, allow_nan=False)


def to_records(frame: pd.DataFrame) -> list[Any]:
    """Return the rows of a DataFrame as a list of dicts keyed by column.

    The index is included, unless it is a RangeIndex.
    """
    import pandas as pd

    complete = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    return complete.to_dict("records")


@contextmanager
def reserve_stdout() -> Iterator[None]:
    """Context manager that redirects stdout to stderr, except for `Output.print_document`."""
    _stdout_stack.append(sys.stdout)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _stdout_stack.pop()


def build_table(
    titles: Iterable[object], rows: Iterable[Sequence[object]], digits: int = 5
) -> Table:
    """Return a borderless terminal table; columns of numbers are right-aligned.

    A number can also be a text, such as "0.68 ± 0.11" or "12 %"; "-" stands for a missing value.

    Parameters
    ----------
    titles : iterable
        Column titles.
    rows : iterable of sequences
        Values of each row, one per column.
    digits : int
        Number of significant digits of floats.
    """
    entries = list(rows)
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 3, 0, 0))
    for i, title in enumerate(titles):
        justify: JustifyMethod = "right" if all(is_number(str(r[i])) for r in entries) else "left"
        table.add_column(escape_text(title), justify=justify, overflow="fold")
    for row in entries:
        table.add_row(*(escape_text(_format_value(value, digits)) for value in row))
    return table


def render_section(section: Section) -> Iterator[str | RenderableType]:
    """Yield the printable parts of a section: title, lines of text, table and note.

    The title is the head of the first column if the rows of the table have names. The note begins
    with the number of the rows that are left out.
    """
    import pandas as pd

    table, note = section.table, section.note
    has_names = table is not None and not isinstance(table.index, pd.RangeIndex)
    if section.title and not has_names:
        yield escape_text(section.title, "bold")
    yield from map(wrap_text, section.lines)
    if table is not None:
        shown = table.iloc[: section.max_rows]
        columns = {
            str(name): format_column(shown[name].tolist(), section.decimals.get(str(name)))
            for name in shown.columns
        }
        if has_names:
            columns = {section.title: [str(name) for name in shown.index], **columns}
        yield build_text_table(columns)
        if len(shown) < len(table):
            n_more = len(table) - len(shown)
            note = f"And {n_more} more row{'' if n_more == 1 else 's'}. {note}".strip()
    if note:
        yield format_note(wrap_text(note))


def build_text_table(columns: Mapping[str, Sequence[str]]) -> Table:
    """Return a borderless terminal table, given the texts of each column by title.

    A unit in the title, such as ``time [s]``, is in a second line of the head. Columns of numbers
    are right-aligned. If the table is wider than `TEXT_WIDTH`, the heads are wrapped.
    """
    heads = [re.sub(r" +\[([^\[]*)\]$", r"\n\1", title) for title in columns]
    widths = [max(map(len, texts), default=1) for texts in columns.values()]
    gaps = _GAP * (len(heads) - 1)
    if sum(map(max, widths, map(_measure, heads))) + gaps > TEXT_WIDTH:
        heads = [
            "\n".join(
                textwrap.fill(line, max(width, _measure(head.replace(" ", "\n"))))
                for line in head.splitlines()
            )
            for head, width in zip(heads, widths, strict=True)
        ]
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, _GAP, 0, 0))
    for head, texts in zip(heads, columns.values(), strict=True):
        justify: JustifyMethod = "right" if all(map(is_number, texts)) else "left"
        table.add_column(escape_text(head, "bold"), justify=justify, overflow="fold")
    for row in zip(*columns.values(), strict=True):
        table.add_row(*map(escape_text, row))
    return table


def _measure(text: str) -> int:
    """Return the length of the longest line of a text."""
    return max(map(len, text.splitlines()), default=1)


def is_within_width(content: Table, width: int) -> bool:
    """Return True if a table fits into a terminal of the given width without wrapping a cell."""
    console = build_console()
    measurement = Measurement.get(console, console.options.update(max_width=_PIPE_WIDTH), content)
    return measurement.maximum <= width


def build_titled_table(title: str, frame: pd.DataFrame, digits: int = 4) -> tuple[Text, Table]:
    """Return a bold title, and the rows of a DataFrame with its index as a terminal table.

    Parameters
    ----------
    title : str
        Title, which is preceded by an empty line.
    frame : DataFrame
        Table, whose index becomes the first column.
    digits : int
        Number of significant digits of floats.
    """
    rows = frame.itertuples(name=None)
    return escape_text(f"\n{title}", "bold"), build_table(["", *frame.columns], rows, digits)


def format_note(text: str) -> Text:
    """Return a text in dim style, for a note below a table."""
    return escape_text(text, "dim")


def build_key_value_table(texts: Mapping[str, str]) -> Table:
    """Return a two-column terminal table without titles: the keys of a dict and their texts."""
    grid = Table.grid(padding=(0, 2))
    for name, text in texts.items():
        grid.add_row(escape_text(name, style="dim"), escape_text(text))
    return grid


def _format_value(value: object, digits: int) -> str:
    is_exact = not isinstance(value, Real) or isinstance(value, Integral)
    return str(value) if is_exact else f"{value:.{digits}g}"


def build_console(*, stderr: bool = False) -> Console:
    """Return a rich console on stdout or stderr.

    Its width is 400 columns if the stream is not a terminal. The environment variable COLUMNS
    overrides the width.
    """
    console = Console(stderr=stderr, highlight=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = _PIPE_WIDTH
    return console


def show(*renderables: str | RenderableType, stderr: bool = False) -> None:
    """Print texts, tables and other rich renderables on stdout or stderr, each on a new line.

    Long lines of text are wrapped on a terminal only.
    """
    console = build_console(stderr=stderr)
    for renderable in renderables:
        if isinstance(renderable, str | Text):
            text = escape_text(renderable) if isinstance(renderable, str) else renderable
            # Long paths must not be truncated.
            console.print(text, soft_wrap=not console.is_terminal, overflow="ignore", crop=False)
        else:
            console.print(renderable)


def escape_text(text: object, style: str = "") -> Text:
    """Convert a value to styled terminal text, with control characters escaped.

    Escaping prevents texts from files or plugins from sending control sequences to the terminal.
    """
    characters = (c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in str(text))
    return Text("".join(characters), style=style)
