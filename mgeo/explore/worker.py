"""One thread in which everything is computed, the most urgent first."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from concurrent.futures import Future
from queue import PriorityQueue
from typing import Any, TypeVar

T = TypeVar("T")


class Worker:
    """Calls functions one after the other, whichever threads ask for them.

    So a problem need not be one for several threads. The thread ends with the process.
    """

    def __init__(self) -> None:
        self._asked: PriorityQueue[tuple[int, int, Future[Any], Callable[[], Any]]]
        self._asked = PriorityQueue()
        self._numbers = itertools.count()
        threading.Thread(target=self._work, daemon=True, name="explorer").start()

    def ask(self, function: Callable[[], T], urgency: int = 0) -> T:
        """What a function gives or raises; those of a lower number go first."""
        future: Future[T] = Future()
        self._asked.put((urgency, next(self._numbers), future, function))
        return future.result()

    def _work(self) -> None:
        while True:
            *_, future, function = self._asked.get()
            try:
                future.set_result(function())
            except BaseException as error:  # whoever asked is told
                future.set_exception(error)
