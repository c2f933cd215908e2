"""How commands end: their exit codes, and errors as one line on stderr."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

ERROR, BAD_INPUT, NOT_ACHIEVED, INTERRUPTED = 1, 2, 3, 130

#: What the exit codes mean.
EXIT_CODES = {
    0: "done; the plan achieves what it promises",
    ERROR: "an error in mgeo-attitude, which --debug shows with its traceback",
    BAD_INPUT: "bad input: arguments, files, no room on the disk; nothing is damaged",
    NOT_ACHIEVED: "done, but the plan does not achieve what it promises",
    INTERRUPTED: "Ctrl-C",
}

#: What typer raises for a command line that cannot be understood; where it is kept has changed.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]

_DEBUG = "mgeo_attitude.debug"
_LONGEST = 600  # characters of a message
_USERS = (ValueError, TypeError, OSError, ImportError)  # what a user can put right


class Commands(TyperGroup):
    """Commands of which every error is one line, and an exit code."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options before the command's name; without any words, show the help."""
        if not args:
            return super().parse_args(ctx, args)
        with _ended(ctx):
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Read the command's own words and do it."""
        with _ended(ctx):
            return super().invoke(ctx)


def remember_debug(ctx: typer.Context, wanted: bool) -> bool:
    """Callback of the flag --debug, which a command has, for the group that ends it."""
    ctx.meta[_DEBUG] = wanted
    return wanted


@contextmanager
def _ended(ctx: Any) -> Iterator[None]:
    try:
        yield
        sys.stdout.flush()
    except (typer.Exit, typer.Abort, BrokenPipeError):
        raise
    except UsageError as error:
        at = getattr(error, "ctx", None) or ctx
        message = error.format_message()  # type: ignore[attr-defined]
        line = f"{' '.join(message.split()).rstrip('.')} (see {at.command_path} --help)"
        raise _end(line, BAD_INPUT) from error
    except KeyboardInterrupt as error:
        raise _end("interrupted", INTERRUPTED) from error
    except Exception as error:
        if ctx.meta.get(_DEBUG):
            traceback.print_exception(error)
        message = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, _USERS):
            raise _end(message, BAD_INPUT) from error
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(last.filename).name}, line {last.lineno}"
        raise _end(f"{type(error).__name__}: {message} ({place}; see --debug)", ERROR) from error


def _end(message: str, code: int) -> typer.Exit:
    if len(message) > _LONGEST:  # a value that was quoted may be a whole file
        message = f"{message[: _LONGEST // 2]} ... {message[-_LONGEST // 2 :]}"
    typer.echo(f"Error: {printable(message)}", err=True)
    return typer.Exit(code)


def printable(text: str) -> str:
    """The text with its control characters written out.

    A file, or a folder's name, must not be able to command the terminal it is shown on.
    """
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
