"""How far a comparison is, on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.progress import TimeRemainingColumn as TimeLeftColumn

from mgeo.terminal import console, is_terminal

_LINES_EVERY = 1.0  # seconds at least between two lines about runs that finished

Done = Callable[[str, int, str], None]  # hears of each run that ends: algorithm, seed, its error


@contextmanager
def progress(title: str, total: int, found: int, shown: bool | None) -> Iterator[Done]:
    """A bar on a terminal; elsewhere a line per run, or per second if they are shorter.

    Parameters
    ----------
    total, found : how many runs there are, and how many of them were made before.
    shown : False for nothing, None for something only if stderr is a terminal.
    """
    terminal = is_terminal(stderr=True)
    if shown is False or (shown is None and not terminal):
        yield lambda name, seed, error: None
    elif not terminal:
        yield _lines(title, total, found)
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
            yield _bar(bar, title, total, found)


def _lines(title: str, total: int, found: int) -> Done:
    print(f"{title}: {total} runs, {found} of them found on disk", file=sys.stderr)
    ended, soonest = found, 0.0

    def done(name: str, seed: int, error: str) -> None:
        nonlocal ended, soonest
        ended += 1
        if error or time.monotonic() >= soonest or ended == total:
            soonest = time.monotonic() + _LINES_EVERY
            outcome = f"failed: {error}" if error else "finished"
            line = f"{ended}/{total}  {name}, seed {seed}: {outcome}"
            print(line, file=sys.stderr, flush=True)

    return done


def _bar(bar: Progress, title: str, total: int, found: int) -> Done:
    task = bar.add_task(title, total=total, completed=found, failed="")
    failed = 0

    def done(name: str, seed: int, error: str) -> None:
        nonlocal failed
        if error:
            failed += 1
            bar.update(task, failed=f"{failed} failed")
            bar.console.print(f"{name}, seed {seed}: {error}", markup=False, style="red")
        bar.advance(task)

    return done
