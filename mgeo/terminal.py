"""Text for terminals, pipes and logs: consoles, what may be printed on them, and tables.

Commands, those of plugins too, and the progress of studies write through it.
"""

from __future__ import annotations

import io
import os
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral, Real
from typing import TYPE_CHECKING

from rich.console import Console
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
    """Return a console on stdout or stderr, without colors if NO_COLOR is set."""
    terminal = is_terminal(stderr=stderr)
    width = None if terminal else _columns() or _WIDTH_OF_A_FILE
    return Console(stderr=stderr, force_terminal=terminal, width=width)


def _columns() -> int | None:
    """Return the width in the environment variable COLUMNS, None if it is not set."""
    given = os.environ.get("COLUMNS", "")
    return int(given) if given.isdecimal() and int(given) else None


def line_width(*, stderr: bool = False) -> int | None:
    """Return the width at which text is broken: of the terminal, or COLUMNS; None for a pipe."""
    return console(stderr=stderr).width if is_terminal(stderr=stderr) else _columns()


def folded(text: str, *, stderr: bool = False) -> str:
    """Return printable text that is `broken` at the width of stdout or stderr."""
    width = line_width(stderr=stderr)
    return printable(text) if width is None else broken(plain(text), width).plain


def write_anything() -> None:
    """Make stdout and stderr write characters that their encoding does not have as escapes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def printable(text: str) -> str:
    """Return the text with its control characters as escapes.

    The name of a file must not be able to control the terminal that shows it.
    """
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def plain(text: object, style: str = "") -> Text:
    """Return text for a console, with its control characters as escapes."""
    return Text(printable(str(text)), style=style)


def broken(text: Text, width: int) -> Text:
    """Break a text of one style between words. Continued lines are indented by two columns."""
    lines: list[str] = []
    for line in text.plain.splitlines():
        indent = line[: len(line) - len(line.lstrip())]
        lines += textwrap.wrap(
            line,
            width,
            subsequent_indent=f"{indent}  ",
            break_long_words=False,
            break_on_hyphens=False,
        ) or [""]
    return Text("\n".join(lines), style=text.style)


def is_terminal(*, stderr: bool = False) -> bool:
    """Return whether stdout or stderr is a terminal.

    Unlike rich this ignores FORCE_COLOR, which would put control characters into a pipe. A build
    service, which sets CI, keeps a log even where it offers a terminal.
    """
    stream = sys.stderr if stderr else sys.stdout
    if stream is None:  # it was closed before the program began
        return False
    return stream.isatty() and not os.environ.get("CI")
