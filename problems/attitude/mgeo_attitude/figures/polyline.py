"""Few samples that draw many curves well."""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Of the extent of a curve: closer than this a line is the curve.
_EXACT = 0.002


def corners(x: Floats, curves: Floats, count: int) -> NDArray[np.int64]:
    """Rows at which straight lines between them come closest to curves, ascending.

    From the first and last row on, the row farthest from the lines so far is added (as Douglas and
    Peucker 1973 do) until there are `count` or the lines are exact; of all curves the worst one
    decides, each measured by its own extent.

    Parameters
    ----------
    x : array, shape (k,)
        Not decreasing, no value more than twice.
    curves : array, shape (k, m)
    """
    extent = np.ptp(curves, axis=0)
    scaled = curves / np.where(extent > 0.0, extent, 1.0)
    chosen = {0, len(x) - 1}
    waiting: list[tuple[float, int, int, int]] = []

    def push(low: int, high: int) -> None:
        if high - low < 2:
            return
        share = (x[low + 1 : high] - x[low]) / (x[high] - x[low])
        line = scaled[low] + share[:, None] * (scaled[high] - scaled[low])
        off = np.abs(scaled[low + 1 : high] - line).max(axis=1)
        worst = int(np.argmax(off))
        heapq.heappush(waiting, (-float(off[worst]), low + 1 + worst, low, high))

    push(0, len(x) - 1)
    while waiting and len(chosen) < count:
        error, middle, low, high = heapq.heappop(waiting)
        if -error <= _EXACT:
            break
        chosen.add(middle)
        push(low, middle)
        push(middle, high)
    return np.array(sorted(chosen), dtype=np.int64)
