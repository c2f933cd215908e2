"""Code of others, which may want to end the program, and its messages."""

import signal
import traceback
from types import TracebackType


class ExitError(RuntimeError):
    """Code of others raised `SystemExit` or `GeneratorExit`, neither of which is an Exception."""


class foreign:
    """For calls of code of others: what it raises is an Exception, or ends the program indeed.

    A script that became a problem, or what it imports, may call `sys.exit`. That would end all
    without a word, and a worker of a pool so that its result is waited for forever. What a signal's
    handler raises meanwhile is the program's own wish, as a KeyboardInterrupt is, and stays; and so
    does the exit by which rich ends a program whose stdout nobody reads any more.

    Raises
    ------
    ExitError
        In place of SystemExit and GeneratorExit, with their traceback.
    """

    def __enter__(self) -> None:
        """Nothing is set up."""

    def __exit__(
        self, kind: object, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Raise what takes the place of the error, if it is one of these."""
        own = error is not None and isinstance(error.__context__, BrokenPipeError)
        if isinstance(error, SystemExit | GeneratorExit) and not (own or _of_a_signal(trace)):
            raise ExitError(f"{error!r} was raised").with_traceback(trace) from error


def _of_a_signal(trace: TracebackType | None) -> bool:
    """Whether one of this process' handlers of signals has raised it."""
    handlers = (signal.getsignal(number) for number in signal.valid_signals())
    codes = {code for handler in handlers if (code := getattr(handler, "__code__", None))}
    return any(frame.f_code in codes for frame, _ in traceback.walk_tb(trace))


def one_line(text: str) -> str:
    """The lines of a text, without blanks at their ends, on one line.

    Blanks within a line stay: a value that a message quotes may be told by its columns.
    """
    return " ".join(filter(None, map(str.strip, text.splitlines())))
