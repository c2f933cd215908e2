"""Ctrl-C and SIGTERM as a request to stop."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


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
