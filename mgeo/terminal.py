"""Terminal output of commands: text and tables, or one JSON document.

The commands of mgeo and of its plugins use this module.
"""

from __future__ import annotations

import json
import math
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

if TYPE_CHECKING:
    import pandas as pd
    from rich.console import JustifyMethod

    from mgeo.plugins.review import Section

#: Width of texts [columns].
TEXT_WIDTH = 80
_PIPE_WIDTH = 400  # width of tables in pipes and files [columns], unless COLUMNS is set
_NUMBER = re.compile(r"([-+]?[\d.,]+(e[-+]\d+)?|nan|inf|-|None|)( ± [\d.]+)?( ?%)?", re.IGNORECASE)
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


def to_records(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """Return the rows of a DataFrame as a list of dicts keyed by column.

    The index is included, unless it is a RangeIndex.
    """
    import pandas as pd

    complete = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    return complete.to_dict("records")


def format_key(title: str) -> str:
    """Convert the title of a column or section to a key of a JSON document.

    Examples
    --------
    >>> format_key("attitude 1-sigma [deg]"), format_key("rate x [deg/s]"), format_key("trace [-]")
    ('attitude_1sigma_deg', 'rate_x_deg_s', 'trace')
    """
    text = title.lower().replace("1-sigma", "1sigma").replace("%", "percent")
    return re.sub(r"[^a-z0-9]+", "_", text).strip("_")


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
        is_number = all(_is_number(str(row[i])) for row in entries)
        table.add_column(
            escape_text(title), justify="right" if is_number else "left", overflow="fold"
        )
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
    are right-aligned.
    """
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 2, 0, 0))
    for title, texts in columns.items():
        head = re.sub(r" +\[([^\[]*)\]$", r"\n\1", title)
        justify: JustifyMethod = "right" if all(map(_is_number, texts)) else "left"
        table.add_column(escape_text(head, "bold"), justify=justify, overflow="fold")
    for row in zip(*columns.values(), strict=True):
        table.add_row(*map(escape_text, row))
    return table


def format_column(values: Sequence[object], decimals: int | None = None) -> list[str]:
    """Format the values of a column for people to read.

    Parameters
    ----------
    values : sequence
        Numbers and texts. NaN becomes an empty text.
    decimals : int, optional
        Number of decimals. By default, a column of integers has none, and all other numbers have
        three significant digits.
    """
    finite = [float(v) for v in values if isinstance(v, Real) and math.isfinite(v)]
    if decimals is None and all(n.is_integer() and abs(n) < 1e6 for n in finite):
        decimals = 0
    return [
        str(value) if not isinstance(value, Real) else format_number(float(value), decimals)
        for value in values
    ]


def format_number(value: float, decimals: int | None = None) -> str:
    """Format a number with three significant digits, or with a fixed number of decimals.

    Integer digits are not rounded below a million. NaN becomes an empty text.

    Examples
    --------
    >>> format_number(1234.5), format_number(0.0336), format_number(2.048e-06), format_number(1.1)
    ('1234', '0.0336', '2.05e-06', '1.10')
    """
    if math.isnan(value):
        return ""
    if math.isinf(value) or not (value == 0.0 or 1e-3 <= abs(value) < 1e6):
        return f"{value:.{2 if decimals is None else decimals}{'e' if decimals is None else 'f'}}"
    if decimals is None:
        decimals = max(2 - math.floor(math.log10(abs(value))), 0) if value else 0
    return f"{value + 0.0:.{decimals}f}"


def wrap_text(text: str, indent: str = "") -> str:
    """Wrap a text to `TEXT_WIDTH` columns; all lines but the first are indented."""
    # A number and its percent sign stay together: a no-break space is no place for a new line.
    lines = textwrap.wrap(
        text.replace(" %", "\N{NO-BREAK SPACE}%"),
        TEXT_WIDTH,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return "\n".join(lines).replace("\N{NO-BREAK SPACE}", " ")


def _is_number(text: str) -> bool:
    return _NUMBER.fullmatch(text) is not None


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
