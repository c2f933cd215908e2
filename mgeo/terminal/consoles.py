"""Consoles that write control characters to a terminal only."""

from __future__ import annotations

import io
import os
import sys
import textwrap

from rich.console import Console
from rich.text import Text

_WIDTH_OF_A_FILE = 400  # rich would cut what is wider than 80


def console(*, stderr: bool = False) -> Console:
    """A console on stdout or stderr. It has no colors if NO_COLOR is set, or on a dumb terminal."""
    terminal = is_terminal(stderr=stderr)
    return Console(
        stderr=stderr, force_terminal=terminal, width=None if terminal else _WIDTH_OF_A_FILE
    )


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
