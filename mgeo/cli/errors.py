"""Exit codes of the commands, errors as one line on stderr, and handling of Ctrl-C and SIGTERM."""

from __future__ import annotations

import signal
import sys
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from enum import IntEnum
from pathlib import Path
from types import FrameType
from typing import Any

import typer

from mgeo._text import join_lines
from mgeo.terminal import show


class TerminationInterrupt(KeyboardInterrupt):
    """Exception raised on SIGTERM, which ends a command like Ctrl-C."""


class StopRequest:
    """Signal that requested a run to stop; false if there was none.

    Attributes
    ----------
    signal : Signals or None
        The received signal.
    may_raise : bool
        Whether a second signal raises KeyboardInterrupt. False while results are written.
    """

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None
        self.may_raise = True

    def __bool__(self) -> bool:
        return self.signal is not None

    @property
    def exit_code(self) -> int:
        """Exit code of a shell for the signal: 130 for Ctrl-C, 143 for SIGTERM, 0 for none."""
        return 0 if self.signal is None else 128 + self.signal

    def receive(self, signal_number: int, frame: FrameType | None = None) -> None:
        """Store the first signal; raise KeyboardInterrupt at the second one, once."""
        if self.signal is None:
            self.signal = signal.Signals(signal_number)
        elif self.may_raise:
            self.may_raise = False
            raise KeyboardInterrupt


@contextmanager
def collect_stop_requests() -> Iterator[StopRequest]:
    """Collect SIGINT and SIGTERM, so that a run can end after the current generation.

    A second signal raises KeyboardInterrupt, to end long generations.
    """
    request = StopRequest()
    watched = (signal.SIGINT, signal.SIGTERM)
    previous = {number: signal.signal(number, request.receive) for number in watched}
    try:
        yield request
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def raise_on_sigterm() -> None:
    """Raise `TerminationInterrupt` on SIGTERM, so that workers are stopped and temporary files removed."""

    def terminate(number: int, frame: FrameType | None) -> None:
        raise TerminationInterrupt

    signal.signal(signal.SIGTERM, terminate)


#: Exception of typer for an invalid command line; its module differs between versions.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]


class ExitCode(IntEnum):
    """Exit codes of all commands, see `EXIT_CODES`."""

    SUCCESS, ERROR, BAD_INPUT, INCOMPLETE = range(4)
    INTERRUPTED, TERMINATED = 130, 143


#: Descriptions of the exit codes, for the help.
EXIT_CODES: Mapping[ExitCode, str] = {
    ExitCode.SUCCESS: "done",
    ExitCode.ERROR: "an error in mgeo or in a problem; --debug shows the traceback",
    ExitCode.BAD_INPUT: "bad input: arguments, files, options, an error in a plugin, or a full "
    "disk; existing files are intact",
    ExitCode.INCOMPLETE: "done, but no solution satisfies all constraints, runs of a study failed, "
    "or a check failed",
    ExitCode.INTERRUPTED: "Ctrl-C; the results so far are saved",
    ExitCode.TERMINATED: "SIGTERM; the results so far are saved",
}


class InputError(Exception):
    """Error that the user can correct; its cause is the original exception."""


@contextmanager
def convert_input_errors(
    error_types: tuple[type[Exception], ...] = (ValueError, TypeError, OSError),
) -> Iterator[None]:
    """Raise `InputError` for errors of the given kinds.

    Use it around code that reads input or writes files. Errors of other kinds, or in other code,
    are bugs of mgeo or of a plugin.
    """
    try:
        yield
    except BrokenPipeError:  # typer ends the command silently.
        raise
    except error_types as error:
        raise InputError(str(error) or type(error).__name__) from error


@contextmanager
def report_errors(ctx: typer.Context, *, debug: bool = False) -> Iterator[None]:
    """Print an error as one line on stderr and end the command with its exit code.

    Parameters
    ----------
    ctx
        Context of the command, for the command name in usage errors.
    debug
        Whether to print the traceback as well.
    """
    try:
        yield
        sys.stdout.flush()
    except (typer.Exit, typer.Abort, BrokenPipeError):
        raise
    except (Exception, KeyboardInterrupt) as error:
        message, code = _describe_error(error, ctx)
        if debug and not isinstance(error, (UsageError, KeyboardInterrupt)):
            traceback.print_exception(error.__cause__ if isinstance(error, InputError) else error)
        show(f"Error: {join_lines(message)}", stderr=True)
        raise typer.Exit(code) from error


def print_warning(message: Warning | str, *_: object, **__: object) -> None:
    """Print a warning as one line on stderr, as a replacement of `warnings.showwarning`."""
    show(f"Warning: {join_lines(str(message))}", stderr=True)


def get_interrupt_exit_code(error: KeyboardInterrupt) -> ExitCode:
    """Return the exit code of an interrupt by Ctrl-C or SIGTERM."""
    return ExitCode.TERMINATED if isinstance(error, TerminationInterrupt) else ExitCode.INTERRUPTED


def _describe_error(error: BaseException, ctx: typer.Context) -> tuple[str, ExitCode]:
    if isinstance(error, UsageError):
        at: Any = getattr(error, "ctx", None) or ctx
        message = error.format_message().rstrip(".")  # type: ignore[attr-defined]
        return f"{message} (see {at.command_path} --help)", ExitCode.BAD_INPUT
    if isinstance(error, KeyboardInterrupt):
        return "interrupted", get_interrupt_exit_code(error)
    from mgeo.evaluation.evaluator import EvaluationError
    from mgeo.plugins.discovery import PluginError
    from mgeo.validation.entries import FileError

    if isinstance(error, InputError | PluginError | EvaluationError | FileError):
        return str(error), ExitCode.BAD_INPUT
    # Any other error is a bug of mgeo or of a plugin.
    last = traceback.extract_tb(error.__traceback__)[-1]
    place = f"{Path(last.filename).name}, line {last.lineno}; see --debug"
    return f"{type(error).__name__}: {error} ({place})", ExitCode.ERROR
