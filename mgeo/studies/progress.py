"""Progress of the runs of a comparison, as lines of text."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

#: Receives algorithm, seed and error (empty if none) of each run that ended.
Done = Callable[[str, int, str], None]
#: Display of the runs with a title, their number, and how many were reused (None: a new study).
Progress = Callable[[str, int, int | None], AbstractContextManager[Done]]

_INTERVAL = 1.0  # seconds between two lines about runs that finished


def describe_reuse(title: str, total: int, reused: int) -> str:
    """Return the line that says how many runs were reused."""
    return f"{title}: reused {reused} of {total} runs"


@contextmanager
def lines(title: str, total: int, reused: int | None) -> Iterator[Done]:
    """Print to stderr one line per failed run, and at most one per second about the others."""
    new = f"{title}: {total} runs"
    print(new if reused is None else describe_reuse(title, total, reused), file=sys.stderr)
    ended, due = reused or 0, 0.0

    def done(name: str, seed: int, error: str) -> None:
        nonlocal ended, due
        ended += 1
        if error or time.monotonic() >= due or ended == total:
            due = time.monotonic() + _INTERVAL
            outcome = f"failed: {error}" if error else "finished"
            line = f"{ended}/{total}  {name}, seed {seed}: {outcome}"
            print(line, file=sys.stderr, flush=True)

    yield done


@contextmanager
def brief(title: str, total: int, reused: int | None) -> Iterator[Done]:
    """Print to stderr how many runs were reused, if any could be."""
    if reused is not None:
        print(describe_reuse(title, total, reused), file=sys.stderr)
    yield lambda name, seed, error: None


@contextmanager
def silent(title: str, total: int, reused: int | None) -> Iterator[Done]:
    """Print nothing."""
    yield lambda name, seed, error: None


def choose(progress: bool | Progress | None) -> Progress:
    """Return the display for the argument `progress` of `mgeo.compare`."""
    if callable(progress):
        return progress
    if progress is None:
        progress = sys.stderr is not None and sys.stderr.isatty()
        return lines if progress else brief
    return lines if progress else silent
