"""Text for terminals, pipes and logs: consoles, what may be printed on them, and tables.

Commands, those of plugins too, and the progress of studies write through it.
"""

from __future__ import annotations

import io
import os
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral, Real
from typing import TYPE_CHECKING, Literal

from rich.console import Console, ConsoleOptions
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    import pandas as pd

_GAP = 3  # between columns

_WIDE = 40  # at which a text may take as many lines as it needs
_WIDTH_OF_A_FILE = 80  # of tables that are piped or kept, unless COLUMNS says another


def table(titles: Iterable[object], rows: Iterable[Sequence[object]], digits: int = 5) -> Columns:
    """Columns without lines between them, texts to the left, others right.

    Nothing is cut where it is wider than the terminal: words go to the next line, and columns for
    which there is no room stand below the others, the first column again beside them.

    Parameters
    ----------
    digits
        Of numbers that are not whole.
    """
    entries = list(rows)
    columns = []
    for i, title in enumerate(titles):
        texts = all(isinstance(row[i], str) for row in entries)
        cells = tuple(plain(_shown(row[i], digits)) for row in entries)
        columns.append(_Column(plain(title), cells, "left" if texts else "right"))
    return Columns(tuple(columns))


def titled(title: str, frame: pd.DataFrame, digits: int = 4) -> tuple[Text, Columns]:
    """A `table` of a frame, with its index, under a title."""
    rows = frame.itertuples(name=None)
    return plain(f"\n{title}", "bold"), table(["", *frame.columns], rows, digits)


def note(text: str) -> Text:
    """What explains a table."""
    return plain(text, "dim")


def pairs(texts: Mapping[str, str]) -> Table:
    """Names and what they stand for, a line each."""
    grid = Table.grid(padding=(0, 2))
    for name, text in texts.items():
        grid.add_row(plain(name, style="dim"), plain(text))
    return grid


@dataclass(frozen=True)
class _Column:
    title: Text
    cells: tuple[Text, ...]
    justify: Literal["left", "right"]

    @cached_property
    def widest(self) -> int:
        """Width at which every text is on one line."""
        return max(text.cell_len for text in (self.title, *self.cells))

    @cached_property
    def narrowest(self) -> int:
        """Width at which no word is broken, and no text but a title takes many lines."""
        words = (word for text in (self.title, *self.cells) for word in text.plain.split())
        cells = max((text.cell_len for text in self.cells), default=0)
        return max([min(-(-2 * cells // 5), _WIDE), *(Text(word).cell_len for word in words)])


@dataclass(frozen=True)
class Columns:
    """A table that knows how to be narrow; see `table`."""

    columns: tuple[_Column, ...]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table | Text]:
        for i, widths in enumerate(self._blocks(options.max_width)):
            if i:
                yield Text()
            yield _drawn([self.columns[j] for j in widths], list(widths.values()))

    def fits(self, width: int) -> bool:
        """Whether all columns have room side by side."""
        return len(list(self._blocks(width))) == 1

    def _blocks(self, room: int) -> Iterator[dict[int, int]]:
        """Columns that stand side by side, by their number, and how wide each is."""
        least = [column.narrowest for column in self.columns]
        block = [0]
        for j in range(1, len(least)):
            if len(block) > 1 and sum(least[i] + _GAP for i in [*block, j]) - _GAP > room:
                yield self._widths(block, room)
                block = [0]
            block.append(j)
        yield self._widths(block, room)

    def _widths(self, block: Sequence[int], room: int) -> dict[int, int]:
        """The narrowest widths, and what room is left to those that lack most."""
        widths = {j: self.columns[j].narrowest for j in block}
        for _ in range(room - sum(widths.values()) - _GAP * (len(block) - 1)):
            lacking = max(block, key=lambda j: self.columns[j].widest - widths[j])
            if widths[lacking] < self.columns[lacking].widest:
                widths[lacking] += 1
        return widths


def _drawn(columns: Sequence[_Column], widths: Sequence[int]) -> Table:
    made = Table(box=None, pad_edge=False, show_edge=False, padding=(0, _GAP, 0, 0))
    for column, width in zip(columns, widths, strict=True):
        made.add_column(column.title, justify=column.justify, width=width, overflow="fold")
    for cells in zip(*(column.cells for column in columns), strict=True):
        made.add_row(*cells)
    return made


def _shown(value: object, digits: int) -> str:
    whole = not isinstance(value, Real) or isinstance(value, Integral)
    return str(value) if whole else f"{value:.{digits}g}"


def console(*, stderr: bool = False) -> Console:
    """A console on stdout or stderr. It has no colors if NO_COLOR is set, or on a dumb terminal."""
    terminal = is_terminal(stderr=stderr)
    width = None if terminal else told_width() or _WIDTH_OF_A_FILE
    return Console(stderr=stderr, force_terminal=terminal, width=width)


def told_width() -> int | None:
    """The width that COLUMNS in the environment asks for; None where it is not set."""
    told = os.environ.get("COLUMNS", "")
    return int(told) if told.isdecimal() and int(told) else None


def line_width(*, stderr: bool = False) -> int | None:
    """Where lines of text are broken: a terminal's width or that of COLUMNS; None for nowhere.

    A pipe or a file keeps them whole, for what searches them.
    """
    return console(stderr=stderr).width if is_terminal(stderr=stderr) else told_width()


def folded(text: str, *, stderr: bool = False) -> str:
    """Text that may be printed there: control characters written out, lines `broken`."""
    width = line_width(stderr=stderr)
    return printable(text) if width is None else broken(plain(text), width).plain


def write_anything() -> None:
    """Have stdout and stderr write out as an escape what their encoding does not have.

    A command must not lose its result to a terminal of ASCII, or to a name that is no text.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def printable(text: str) -> str:
    """The text with its control characters written out.

    A file, or a folder's name, must not be able to command the terminal it is shown on.
    """
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def plain(text: object, style: str = "") -> Text:
    """Text for a console, with its control characters written out."""
    return Text(printable(str(text)), style=style)


def broken(text: Text, width: int) -> Text:
    """The text, of one style, in lines of this width; words, such as paths, stay whole.

    What goes on with a line is indented by two more columns than it.
    """
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
    """Whether somebody sits at it.

    That is asked of the stream: rich also believes environment variables, and one that asks for
    colors would put control characters into a pipe. A service that runs builds (it sets CI) may
    offer a terminal, but keeps a log of what is written to it.
    """
    stream = sys.stderr if stderr else sys.stdout
    if stream is None:  # it was closed before the program began
        return False
    return stream.isatty() and not os.environ.get("CI")
