"""What files of ephemerides hold, whatever their format."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Floats


@dataclass(frozen=True, eq=False)
class Segment:
    """Samples between which one may interpolate.

    `times` [s], increasing, count from the epoch that the reader was given; `position` [m] and
    `velocity` [m/s] are of shape (n, 3) in `frame`. It is good from `start` to `stop`, of which
    nothing is said if they are infinite; samples outside serve interpolation. What a file does not
    say is empty or None.
    """

    name: str
    frame: str
    times: Floats
    position: Floats
    velocity: Floats | None
    start: float = -math.inf
    stop: float = math.inf
    interpolation: str = ""
    degree: int | None = None


def numbers(line: int, words: Sequence[str]) -> list[float]:
    """Finite numbers of a line; anything else is a ValueError."""
    try:
        found = [float(word) for word in words]
    except ValueError:
        found = [math.nan]
    if not all(map(math.isfinite, found)):
        raise ValueError(f"line {line}: {' '.join(words)!r:.80}: expected finite numbers")
    return found


def increasing(times: Floats, stamps: Sequence[str]) -> Floats:
    """The times, if they are in order; else a ValueError with the stamps of the first two."""
    for k in np.flatnonzero(np.diff(times) <= 0.0)[:1]:
        raise ValueError(f"time {stamps[k + 1]} below {stamps[k]}: expected times in order")
    return times
