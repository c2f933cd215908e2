"""What commands print: text for people, or one JSON document for scripts."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TextIO

import typer
from rich.console import RenderableType

from mgeo.terminal import show

if TYPE_CHECKING:
    import pandas as pd

_stdout: list[TextIO] = []  # of the document, while stdout is redirected


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
            typer.echo(json_text(document), file=_stdout[0] if _stdout else sys.stdout)


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


def reserve(ctx: typer.Context, wanted: bool) -> bool:
    """Callback of the flag --json: until the command ends, all other output goes to stderr."""
    if wanted and not ctx.resilient_parsing:
        root = ctx.find_root()
        _stdout.append(sys.stdout)
        root.call_on_close(_stdout.pop)
        root.with_resource(redirect_stdout(sys.stderr))
    return wanted
