"""How commands end: their exit codes, errors as one line on stderr, and Ctrl-C and SIGTERM."""

from __future__ import annotations

import signal
import sys
import threading
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from enum import IntEnum
from pathlib import Path
from types import FrameType
from typing import Any

import typer

from mgeo._foreign import one_line
from mgeo.terminal import folded, write_anything


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does."""


class StopRequest:
    """Which signal asked to stop, if one did."""

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None
        self._may_raise = True

    def __bool__(self) -> bool:
        return self.signal is not None

    @property
    def exit_code(self) -> int:
        """As a shell reports it: 130 after Ctrl-C, 143 after SIGTERM; 0 if there was none."""
        return 0 if self.signal is None else 128 + self.signal

    def settle(self) -> None:
        """From here on only note signals: the work is ending, and its results must be kept."""
        self._may_raise = False

    def receive(self, number: int, frame: FrameType | None = None) -> None:
        """Note a signal; the second raises KeyboardInterrupt, once."""
        if self.signal is not None and self._may_raise:
            self.settle()
            raise KeyboardInterrupt
        self.signal = self.signal or signal.Signals(number)


@contextmanager
def stop_requests() -> Iterator[StopRequest]:
    """Collect SIGINT and SIGTERM instead of dying of them.

    The first lets a generation end in an orderly way; the second, a KeyboardInterrupt, is for
    generations that take long.
    """
    request = StopRequest()
    watched = (signal.SIGINT, signal.SIGTERM)
    previous = {number: signal.signal(number, request.receive) for number in watched}
    try:
        yield request
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


@contextmanager
def terminable() -> Iterator[None]:
    """Raise `Terminated` on SIGTERM, so that processes are ended and no temporary file is left.

    Nothing is changed where somebody else has seen to the signal, nor outside the main thread,
    which alone may.
    """
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
    ):
        yield
        return
    signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _terminate(number: int, frame: FrameType | None) -> None:
    raise Terminated


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
    INCOMPLETE = (
        3,
        "done, but nothing keeps all limits, runs of a study failed, or what was checked does not "
        "hold",
    )
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
    write_anything()
    words = [*(getattr(ctx, "_protected_args", None) or ()), *ctx.args]
    try:
        with terminable():
            yield
            if sys.stdout is not None:  # as where it was closed
                sys.stdout.flush()
    except (typer.Exit, typer.Abort, BrokenPipeError):
        raise
    except (Exception, KeyboardInterrupt) as error:
        message, code = _told(error, ctx, words)
        if ctx.meta.get(_DEBUG) and not isinstance(error, (UsageError, KeyboardInterrupt)):
            traceback.print_exception(error.__cause__ if isinstance(error, Refused) else error)
        typer.echo(folded(f"Error: {message}", stderr=True), err=True)
        raise typer.Exit(code) from error


def of_interrupt(error: KeyboardInterrupt) -> ExitCode:
    """Code of what was ended by Ctrl-C or SIGTERM."""
    return ExitCode.TERMINATED if isinstance(error, Terminated) else ExitCode.INTERRUPTED


def _told(error: BaseException, ctx: Any, words: Sequence[str]) -> tuple[str, ExitCode]:
    """What is said of an error, and the code it ends with; `words` are those of the command."""
    if isinstance(error, UsageError):
        at = getattr(error, "ctx", None) or ctx
        message = _short(error.format_message()).rstrip(".")  # type: ignore[attr-defined]
        hint = _of_commas(words) if " valid " in message else ""
        if getattr(error, "option_name", "").lstrip("-").replace("-", "_") == "n_i":
            hint = "; n_i of the papers is --walkers"
        return f"{message}{hint} (see {at.command_path} --help)", ExitCode.BAD_INPUT
    if isinstance(error, Refused):
        hint = _of_commas(words) if "expected one number" in str(error) else ""
        return f"{error}{hint}", ExitCode.BAD_INPUT
    if isinstance(error, KeyboardInterrupt):
        return "interrupted", of_interrupt(error)
    from mgeo.evaluation.evaluator import EvaluationError
    from mgeo.plugins.discovery import PluginError
    from mgeo.validation.tables import FileError

    if isinstance(error, PluginError | EvaluationError | FileError):
        return _one_line(error), ExitCode.BAD_INPUT
    last = traceback.extract_tb(error.__traceback__)[-1]  # a bug, here or in a plugin
    place = f"{Path(last.filename).name}, line {last.lineno}; see --debug"
    return f"{type(error).__name__}: {_one_line(error)} ({place})", ExitCode.ERROR


def _of_commas(words: Sequence[str]) -> str:
    from mgeo.validation.arguments import decimal_point  # with numpy

    return decimal_point(*words)


def _one_line(error: BaseException) -> str:
    return _short(str(error)) or type(error).__name__


def _short(message: str) -> str:
    """On one line, which a person can read: a value that was quoted may be a whole file."""
    line = one_line(message)
    half = _LONGEST // 2
    return line if len(line) <= _LONGEST else f"{line[:half]} ... {line[-half:]}"
