"""Terminal output of commands: text and tables, or one JSON document.

The commands of mgeo and of its plugins use this module.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TextIO

from rich.console import Console
from rich.text import Text

from mgeo._text import TEXT_WIDTH, wrap_text

if TYPE_CHECKING:
    from mgeo.plugins.review import Section

#: Styles of the parts of a section.
_STYLES = {"title": "bold", "head": "bold", "note": "dim"}
_stdout_stack: list[TextIO] = []  # the original stdout while `reserve_stdout` is active


@dataclass(frozen=True)
class Output:
    """Printer for the output of a command, either as text or as a JSON document.

    The options ``--quiet`` and ``--json`` of the command select the output.

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

    def print(self, *texts: str | Text) -> None:
        """Print each text on a new line, unless `quiet` or `json` is true."""
        if self.is_text:
            show(*texts)

    def print_title(self, text: str) -> None:
        """Print a title in bold, wrapped to the text width."""
        self.print(escape_text(wrap_text(text), "bold"))

    def print_text(self, *paragraphs: str) -> None:
        """Print paragraphs and list items, wrapped to the text width."""
        from mgeo._text_table import wrap_item

        self.print(*map(wrap_item, paragraphs))

    def print_sections(self, *sections: Section) -> None:
        """Print sections and their tables, separated by empty lines."""
        from mgeo._text_table import format_section

        width = build_console().width
        for i, section in enumerate(sections):
            parts = format_section(section, width)
            self.print(
                *([""] if i else []), *(escape_text(t, _STYLES.get(kind, "")) for kind, t in parts)
            )

    def print_warnings(self, warnings: Iterable[str]) -> None:
        """Print each warning as a separate paragraph."""
        for warning in warnings:
            text = escape_text(wrap_text(f"Warning: {warning}", "  "))
            text.stylize("yellow", 0, len("Warning:"))
            self.print(text)

    def print_pairs(self, pairs: Mapping[str, str]) -> None:
        """Print names and texts in two columns."""
        width = max(map(len, pairs), default=0) + 2
        for name, text in pairs.items():
            first, *rest = wrap_text(text, width=TEXT_WIDTH - width).splitlines() or [""]
            line = escape_text(
                "\n".join([f"{name:{width}}{first}", *(" " * width + t for t in rest)])
            )
            line.stylize("dim", 0, len(name))
            self.print(line)

    def print_files(self, files: Mapping[str, str]) -> None:
        """Print the paths of written files, each with a description of its contents."""
        if files:
            self.print("", escape_text("Files", "bold"))
            width = max(map(len, files))
            self.print(*(f"{path:{width}}  {content}".rstrip() for path, content in files.items()))

    def print_commands(self, commands: Mapping[str, str], heading: str = "") -> None:
        """Print suggested next commands, each with its purpose."""
        width = max(map(len, commands), default=0) + 1
        lines = [f"{f'{purpose}:':{width}}  {text}" for purpose, text in commands.items()]
        self.print(*([""] if heading or lines else []), *([heading] if heading else []), *lines)

    def print_note(self, text: str) -> None:
        """Print a line of text on stderr, even if `quiet` or `json` is true."""
        show(text, stderr=True)

    def print_document(self, document: Mapping[str, Any]) -> None:
        """Print a JSON document on stdout if `json` is true, and do nothing otherwise."""
        if self.json:
            print(format_json(document), file=_stdout_stack[0] if _stdout_stack else sys.stdout)


def format_json(document: Mapping[str, Any]) -> str:
    """Format a dict as indented JSON text.

    NaN and infinite numbers become null.
    """
    from pydantic_core import to_jsonable_python

    finite = to_jsonable_python(dict(document), inf_nan_mode="null")
    return json.dumps(finite, indent=2, allow_nan=False)


@contextmanager
def reserve_stdout() -> Iterator[None]:
    """Context manager that redirects stdout to stderr.

    Only `Output.print_document` still writes to stdout.
    """
    _stdout_stack.append(sys.stdout)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _stdout_stack.pop()


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Discard further output, so that the command ends with its own exit code."""
        os.dup2(os.open(os.devnull, os.O_WRONLY), self.file.fileno())


def build_console(*, stderr: bool = False) -> Console:
    """Return a rich console on stdout or stderr.

    Its width is `TEXT_WIDTH` if the stream is not a terminal. The environment variable COLUMNS
    overrides the width.
    """
    console = _Console(stderr=stderr, highlight=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = TEXT_WIDTH
    return console


def show(*texts: str | Text, stderr: bool = False) -> None:
    """Print each text on a new line, on stdout or stderr.

    Long lines of text are wrapped on a terminal only.
    """
    console = build_console(stderr=stderr)
    for text in texts:
        escaped = escape_text(text) if isinstance(text, str) else text
        # Long paths must not be truncated.
        console.print(escaped, soft_wrap=not console.is_terminal, overflow="ignore", crop=False)


def escape_text(text: object, style: str = "") -> Text:
    """Convert a value to styled terminal text, and escape control characters.

    Escaping prevents texts from files or plugins from sending control sequences to the terminal.
    """
    characters = (c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in str(text))
    return Text("".join(characters), style=style)
