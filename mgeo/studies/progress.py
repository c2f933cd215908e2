"""How far a comparison is, on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.progress import TimeRemainingColumn as TimeLeftColumn

from mgeo.terminal import console, is_terminal

_LINES_EVERY = 1.0  # seconds at least between two lines about runs that finished


class Reporter(Protocol):
    """Hears of each run that ends."""

    def done(self, name: str, seed: int, error: str | None) -> None:
        """A run finished, or failed with this error."""


@contextmanager
def progress(title: str, total: int, found: int, shown: bool | None) -> Iterator[Reporter]:
    """A bar on a terminal; elsewhere a line per run, or per second if they are shorter.

    Parameters
    ----------
    total, found : how many runs there are, and how many of them were made before.
    shown : False for nothing, None for something only if stderr is a terminal.
    """
    terminal = is_terminal(stderr=True)
    if shown is False or (shown is None and not terminal):
        yield _Silent()
    elif not terminal:
        yield _Lines(title, total, found)
    else:
        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[failed]}", style="red", markup=False),
            TimeElapsedColumn(),
            TimeLeftColumn(elapsed_when_finished=False),
        )
        with Progress(*columns, console=console(stderr=True)) as bar:
            yield _Bar(bar, title, total, found)


class _Silent:
    def done(self, name: str, seed: int, error: str | None) -> None:
        """Nothing is shown."""


class _Lines:
    def __init__(self, title: str, total: int, found: int) -> None:
        self._total, self._ended, self._next = total, found, 0.0
        print(f"{title}: {total} runs, {found} of them found on disk", file=sys.stderr)

    def done(self, name: str, seed: int, error: str | None) -> None:
        self._ended += 1
        now = time.monotonic()
        if error is None and now < self._next and self._ended < self._total:
            return
        self._next = now + _LINES_EVERY
        outcome = "finished" if error is None else f"failed: {error}"
        line = f"{self._ended}/{self._total}  {name}, seed {seed}: {outcome}"
        print(line, file=sys.stderr, flush=True)


class _Bar:
    def __init__(self, bar: Progress, title: str, total: int, found: int) -> None:
        self._bar, self._failed = bar, 0
        self._task = bar.add_task(title, total=total, completed=found, failed="")

    def done(self, name: str, seed: int, error: str | None) -> None:
        if error is not None:
            self._failed += 1
            self._bar.update(self._task, failed=f"{self._failed} failed")
            self._bar.console.print(f"{name}, seed {seed}: {error}", markup=False, style="red")
        self._bar.advance(self._task)
