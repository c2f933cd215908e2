"""What commands print: for people, or one JSON document for scripts, on a stdout kept for it."""

from __future__ import annotations

import ctypes
import json
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TextIO

import typer
from rich.console import RenderableType
from rich.text import Text

from mgeo.terminal import broken, console, folded, line_width, plain

if TYPE_CHECKING:
    import pandas as pd

_C_LIBRARY = "ucrtbase" if os.name == "nt" else None  # None: what this process has loaded
_kept: list[TextIO] = []  # stdout itself, while it is reserved


@dataclass(frozen=True)
class Output:
    """What goes to stdout, and whether progress is shown on stderr.

    Attributes
    ----------
    quiet : nothing but errors (and the document, if that is asked for).
    json : nothing on stdout but one document.
    """

    quiet: bool = False
    json: bool = False

    @property
    def for_people(self) -> bool:
        """Whether `print` prints."""
        return not (self.quiet or self.json)

    def print(self, *shown: str | RenderableType) -> None:
        """Show people something, each on lines of its own; text is not cut at the margin.

        A terminal, or COLUMNS in the environment, breaks it between words, a pipe nowhere.
        """
        if not self.for_people:
            return
        out, width = console(), line_width()
        for each in shown:
            text = plain(each) if isinstance(each, str) else each
            if isinstance(text, Text) and width is not None:
                text = broken(text, width)
            out.print(text, soft_wrap=isinstance(text, Text))

    def note(self, text: str) -> None:
        """Tell something beside the result, on stderr."""
        typer.echo(folded(text, stderr=True), err=True)

    def result(self, document: Mapping[str, Any]) -> None:
        """Give scripts what the command found; see `json_text`."""
        if self.json:
            write(json_text(document))


def json_text(document: Mapping[str, Any]) -> str:
    """The document, with null for numbers that JSON does not have."""
    from pydantic_core import to_jsonable_python

    finite = to_jsonable_python(dict(document), inf_nan_mode="null")
    return json.dumps(finite, indent=2, allow_nan=False)


def rows(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """The rows of a table for a document, with its index unless that only counts them."""
    import pandas as pd

    named = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    return named.to_dict("records")


@contextmanager
def reserved() -> Iterator[None]:
    """Meanwhile `write` alone writes to stdout; what anybody prints goes to stderr.

    So it does from threads and processes that are started meanwhile, and from compiled code, which
    knows nothing of `sys.stdout`: it is the descriptor that is changed.
    """
    if _kept or sys.stdout is None:
        yield
        return
    try:
        is_descriptor = sys.stdout.fileno() == 1
    except OSError:  # of a stream in memory
        is_descriptor = False
    if not is_descriptor:
        _kept.append(sys.stdout)
        try:
            with redirect_stdout(sys.stderr):
                yield
        finally:
            _kept.clear()
        return
    stdout = sys.stdout
    stdout.flush()
    with open(os.dup(1), "w", encoding=stdout.encoding, errors=stdout.errors) as document:
        os.dup2(2, 1)
        _kept.append(document)
        try:
            yield
        finally:
            _kept.clear()
            stdout.flush()
            # what compiled code has printed and C still holds
            ctypes.CDLL(_C_LIBRARY).fflush(None)
            os.dup2(document.fileno(), 1)


def write(text: str) -> None:
    """Write a line to stdout, also while it is reserved."""
    file = _kept[0] if _kept else sys.stdout
    typer.echo(text, file=file)


def reserve(ctx: typer.Context, wanted: bool) -> bool:
    """Callback of the flag --json: stdout is the document's until all of the command has ended."""
    if wanted and not ctx.resilient_parsing:
        ctx.find_root().with_resource(reserved())
    return wanted
