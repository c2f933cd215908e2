"""What commands print: for people, or one JSON document for scripts."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import typer
from rich.console import RenderableType
from rich.text import Text

from mgeo.cli.stdout import write
from mgeo.terminal import broken, console, plain, printable


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

        A terminal breaks it between words, a file or a pipe nowhere.
        """
        if not self.for_people:
            return
        out = console()
        for each in shown:
            text = plain(each) if isinstance(each, str) else each
            if isinstance(text, Text) and out.is_terminal:
                text = broken(text, out.width)
            out.print(text, soft_wrap=isinstance(text, Text))

    def note(self, text: str) -> None:
        """Tell something beside the result, on stderr."""
        typer.echo(printable(text), err=True)

    def result(self, document: Mapping[str, Any]) -> None:
        """Give scripts what the command found; see `json_text`."""
        if self.json:
            write(json_text(document))


def json_text(document: Mapping[str, Any]) -> str:
    """The document, with null for numbers that JSON does not have."""
    from pydantic_core import to_jsonable_python

    finite = to_jsonable_python(dict(document), inf_nan_mode="null")
    return json.dumps(finite, indent=2, allow_nan=False)
