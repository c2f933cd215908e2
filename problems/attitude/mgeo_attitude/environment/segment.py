"""What files of ephemerides hold, whatever their format."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats


@dataclass(frozen=True, eq=False)
class Segment:
    """Samples between which one may interpolate.

    `times` [s], increasing, count from the epoch that the reader was given; `position` [m] and
    `velocity` [m/s] are of shape (n, 3) in `frame`, whose axes may be those of one instant,
    `frame_epoch`, which counts as they do. It is good from `start` to `stop`, of which nothing is
    said if they are infinite; samples outside serve interpolation. What a file does not say is
    empty or None.
    """

    name: str
    frame: str
    times: Floats
    position: Floats
    velocity: Floats | None
    start: float = -math.inf
    stop: float = math.inf
    frame_epoch: float | None = None
    interpolation: str = ""
    degree: int | None = None


class Origin(NamedTuple):
    """The file that an orbit is from: its name, and the SHA-256 of what is in it."""

    file: str
    digest: str

    def of(self, name: str) -> str:
        """In words, of an object's orbit."""
        return ", ".join(filter(None, (self.file, name, f"SHA-256 {self.digest}")))


def numbers(line: int, words: Sequence[str]) -> list[float]:
    """Finite numbers of a line; anything else is a ValueError."""
    try:
        found = [float(word) for word in words]
    except ValueError:
        found = [math.nan]
    if not all(map(math.isfinite, found)):
        raise ValueError(f"line {line}: {' '.join(words)!r:.80}: expected finite numbers")
    return found


def in_order(times: Floats, stamps: Sequence[str]) -> Floats:
    """The times, if they are in order; else a ValueError with the stamps of the first two.

    The same twice is a jump, between before and after it.
    """
    steps = np.diff(times)
    wrong = steps < 0.0
    wrong[1:] |= (steps[1:] == 0.0) & (steps[:-1] == 0.0)
    for k in np.flatnonzero(wrong)[:1]:
        raise ValueError(
            f"time {stamps[k + 1]} after {stamps[k]}: expected times in order, the same at most "
            "twice"
        )
    return times
