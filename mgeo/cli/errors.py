"""How commands end: their exit codes, and errors as one line on stderr."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum
from pathlib import Path
from typing import Any

import typer

from mgeo.cli.consoles import printable

#: What typer raises for a command line that cannot be understood; where it is kept has changed.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]

_DEBUG = "mgeo.debug"
_LONGEST = 600  # characters of a message


class ExitCode(IntEnum):
    """Exit codes of every command."""

    DONE = 0, "done"
    ERROR = 1, "an error in mgeo or in a problem, which --debug shows with its traceback"
    BAD_INPUT = (
        2,
        "bad input: arguments, files, options, a problem that breaks the plugin protocol, no room "
        "on the disk; nothing is damaged",
    )
    INCOMPLETE = 3, "done, but runs of a study failed, or what was checked does not hold"
    INTERRUPTED = 130, "Ctrl-C; what was found is kept"
    TERMINATED = 143, "SIGTERM; what was found is kept"

    meaning: str

    def __new__(cls, code: int, meaning: str) -> ExitCode:
        member = int.__new__(cls, code)
        member._value_ = code
        member.meaning = meaning
        return member


class Refused(Exception):
    """Something a user can put right; the error itself is its cause."""


@contextmanager
def bad_input(
    kinds: tuple[type[Exception], ...] = (ValueError, TypeError, OSError),
) -> Iterator[None]:
    """For code that reads and checks input or writes files: its errors are the user's.

    Errors of other kinds, and elsewhere, are bugs: here or in a plugin.

    Raises
    ------
    Refused
        In place of an error of these kinds.
    """
    try:
        yield
    except BrokenPipeError:  # nobody reads stdout any more
        raise
    except kinds as error:
        raise Refused(_one_line(error)) from error


def remember_debug(ctx: typer.Context, wanted: bool) -> bool:
    """Callback of the flag --debug, which a command has, for the group that ends it."""
    ctx.meta[_DEBUG] = wanted
    return wanted


@contextmanager
def ended(ctx: Any) -> Iterator[None]:
    """Make of every error one line on stderr, and an exit code."""
    try:
        yield
        sys.stdout.flush()
    except (typer.Exit, typer.Abort, BrokenPipeError):
        raise
    except UsageError as error:
        at = getattr(error, "ctx", None) or ctx
        help_of = f"see {at.command_path} --help"
        message = _short(error.format_message())  # type: ignore[attr-defined]
        raise _end(f"{message.rstrip('.')} ({help_of})", ExitCode.BAD_INPUT) from error
    except Refused as error:
        _show_traceback(ctx, error.__cause__)
        raise _end(str(error), ExitCode.BAD_INPUT) from error
    except KeyboardInterrupt as error:
        raise _end("interrupted", ExitCode.INTERRUPTED) from error
    except Exception as error:  # a bug, here or in a plugin
        from mgeo.evaluation.evaluator import EvaluationError
        from mgeo.files.reading import FileError
        from mgeo.plugins.discovery import PluginError

        _show_traceback(ctx, error)
        if isinstance(error, PluginError | EvaluationError | FileError):
            raise _end(_one_line(error), ExitCode.BAD_INPUT) from error
        line = f"{type(error).__name__}: {_one_line(error)} ({_place(error)}; see --debug)"
        raise _end(line, ExitCode.ERROR) from error


def _end(message: str, code: ExitCode) -> typer.Exit:
    typer.echo(f"Error: {printable(message)}", err=True)
    return typer.Exit(code)


def _show_traceback(ctx: Any, error: BaseException | None) -> None:
    if ctx.meta.get(_DEBUG):
        traceback.print_exception(error)


def _one_line(error: Exception) -> str:
    return _short(str(error)) or type(error).__name__


def _short(message: str) -> str:
    """On one line, which a person can read: a value that was quoted may be a whole file."""
    line = " ".join(message.split())
    half = _LONGEST // 2
    return line if len(line) <= _LONGEST else f"{line[:half]} ... {line[-half:]}"


def _place(error: Exception) -> str:
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{Path(last.filename).name}, line {last.lineno}"
