"""Exit codes, error messages, and handling of Ctrl-C and SIGTERM, for all commands."""

from __future__ import annotations

import re
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
    """Exception raised on SIGTERM so that a command cleans up as it does after Ctrl-C."""


class StopRequest:
    """Request to end a run, set by the first SIGINT or SIGTERM.

    Attributes
    ----------
    signal : Signals or None
        First received signal.
    may_raise : bool
        Whether a second signal raises KeyboardInterrupt. It is set to False while results are
        written.
    """

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None
        self.may_raise = True

    def __bool__(self) -> bool:
        return self.signal is not None

    @property
    def exit_code(self) -> int:
        """Exit code by shell convention: 128 plus the signal number, or 0 without a signal."""
        return 0 if self.signal is None else 128 + self.signal

    def receive(self, signal_number: int, frame: FrameType | None = None) -> None:
        """Store the first signal, and raise KeyboardInterrupt on the second.

        Later signals are ignored, and so is the second one while `may_raise` is false.

        Parameters
        ----------
        signal_number
            Number of the received signal.
        frame
            Unused; part of the interface of signal handlers.
        """
        if self.signal is None:
            self.signal = signal.Signals(signal_number)
        elif self.may_raise:
            self.may_raise = False
            raise KeyboardInterrupt


@contextmanager
def collect_stop_requests() -> Iterator[StopRequest]:
    """Context manager that turns SIGINT and SIGTERM into a `StopRequest`.

    The run can then end after its current generation. A second signal raises KeyboardInterrupt,
    which ends a long generation at once. The previous signal handlers are restored on exit.

    Yields
    ------
    StopRequest
        Request that is false until a signal is received.
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
    """Install a signal handler that raises `TerminationInterrupt` on SIGTERM.

    The exception lets a command stop its worker processes and remove its temporary files.
    """

    def terminate(number: int, frame: FrameType | None) -> None:
        raise TerminationInterrupt

    signal.signal(signal.SIGTERM, terminate)


#: Exception class of typer for invalid command lines. Its module depends on the version of typer.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]


class ExitCode(IntEnum):
    """Exit codes of the ``mgeo`` command, described in `EXIT_CODES`."""

    SUCCESS, ERROR, BAD_INPUT, INCOMPLETE = range(4)
    INTERRUPTED, TERMINATED = 130, 143


#: Descriptions of the exit codes, for the help.
EXIT_CODES: Mapping[ExitCode, str] = {
    ExitCode.SUCCESS: "success",
    ExitCode.ERROR: "error in mgeo or in a problem; --debug prints the traceback",
    ExitCode.BAD_INPUT: "invalid input (options, files, plugins), or a full disk",
    ExitCode.INCOMPLETE: "no feasible solution, a failed run of a study, or a failed test "
    "by a command such as mgeo attitude verify",
    ExitCode.INTERRUPTED: "interrupted by Ctrl-C; the results so far are saved",
    ExitCode.TERMINATED: "ended by SIGTERM; the results so far are saved",
}


class InputError(Exception):
    """Error that the user can correct, such as an invalid option or a missing file.

    The original exception is its ``__cause__``.
    """


@contextmanager
def convert_input_errors(
    error_types: tuple[type[Exception], ...] = (ValueError, TypeError, OSError),
) -> Iterator[None]:
    """Context manager that reraises exceptions of the given types as `InputError`.

    The context encloses code that reads input or writes files. Exceptions of other types, or in
    other code, are bugs of mgeo or of a plugin.
    """
    try:
        yield
    except BrokenPipeError:  # typer ends the command silently.
        raise
    except error_types as error:
        raise InputError(_format_input_error(error)) from error


@contextmanager
def report_errors(ctx: typer.Context, *, debug: bool = False) -> Iterator[None]:
    """Context manager that prints an exception as one line on stderr and exits.

    Parameters
    ----------
    ctx
        Context of the command, which names the command in messages on invalid command lines.
    debug
        Whether to print the traceback as well.

    Raises
    ------
    typer.Exit
        After an exception has been printed, with the exit code of this exception.
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
    """Print a warning as one line on stderr, in place of `warnings.showwarning`."""
    show(f"Warning: {join_lines(str(message))}", stderr=True)


def get_interrupt_exit_code(error: KeyboardInterrupt) -> ExitCode:
    """Return the exit code for an interrupted command: 143 after SIGTERM, 130 after Ctrl-C."""
    return ExitCode.TERMINATED if isinstance(error, TerminationInterrupt) else ExitCode.INTERRUPTED


def _format_input_error(error: Exception) -> str:
    """Return the message of an exception, starting with the path for file system errors."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{error.filename}: {error.strerror[0].lower()}{error.strerror[1:]}"
    return str(error) or type(error).__name__


def _format_usage_error(error: Any) -> str:
    """Return an error message that states the invalid value and the expected ones."""
    if possibilities := getattr(error, "possibilities", None):
        names = " or ".join(sorted(possibilities))
        return f"There is no option {error.option_name}; did you mean {names}?"
    find_details = getattr(error.__cause__, "errors", None)
    if find_details is None or getattr(error, "param", None) is None:
        return str(error.format_message()).rstrip(".")
    # typer converts values by pydantic, whose messages do not state the value.
    from mgeo.validation.tables import format_expectation

    details, parameter = find_details()[0], error.param
    is_option = parameter.param_type_name == "option"
    name = max(parameter.opts, key=len) if is_option else parameter.metavar
    expected = "expected one of" if "," in details["msg"] else "expected"
    expectation = re.sub("'.*' is not one of", expected, format_expectation(details["msg"]))
    return f"{name} {details['input']}: {expectation}"


def _describe_error(error: BaseException, ctx: typer.Context) -> tuple[str, ExitCode]:
    if isinstance(error, UsageError):
        error_context: Any = getattr(error, "ctx", None) or ctx
        message = _format_usage_error(error)
        return f"{message} (see {error_context.command_path} --help)", ExitCode.BAD_INPUT
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
