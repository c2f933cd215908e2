"""What commands print, those of plugins too: text and tables, or one JSON document."""

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

_WIDTH_OF_A_FILE = 400  # of tables in pipes and files, unless COLUMNS is set
_documents: list[TextIO] = []  # stdout, while all else goes to stderr


@dataclass(frozen=True)
class Output:
    """Output of a command.

    Attributes
    ----------
    quiet : print errors only, and the document if one is asked for.
    json : print nothing but one document on stdout.
    """

    quiet: bool = False
    json: bool = False

    @property
    def for_people(self) -> bool:
        """Whether `print` prints."""
        return not (self.quiet or self.json)

    def print(self, *shown: str | RenderableType) -> None:
        """Print text and tables, each on lines of its own."""
        if self.for_people:
            show(*shown)

    def note(self, text: str) -> None:
        """Print a line on stderr, beside the result."""
        show(text, stderr=True)

    def result(self, document: Mapping[str, Any]) -> None:
        """Print the document for scripts, see `json_text`."""
        if self.json:
            print(json_text(document), file=_documents[0] if _documents else sys.stdout)


def json_text(document: Mapping[str, Any]) -> str:
    """Return a document as JSON, with null for numbers that JSON does not have."""
    from pydantic_core import to_jsonable_python

    finite = to_jsonable_python(dict(document), inf_nan_mode="null")
    return json.dumps(finite, indent=2, allow_nan=False)


def rows(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """Return the rows of a table for a document, with the index unless it only counts them."""
    import pandas as pd

    named = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    return named.to_dict("records")


@contextmanager
def stdout_for_documents() -> Iterator[None]:
    """Keep stdout for `Output.result`, and send all other output to stderr."""
    _documents.append(sys.stdout)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _documents.pop()


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
