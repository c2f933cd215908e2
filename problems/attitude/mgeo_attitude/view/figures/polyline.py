"""Few samples that draw many curves well."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mgeo_attitude._typing import Floats

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
    every = np.arange(len(x))
    rows = np.unique([0, len(x) - 1])
    while 1 < len(rows) < count:
        after = np.clip(np.searchsorted(rows, every, side="right"), 1, len(rows) - 1)
        low, high = rows[after - 1], rows[after]
        span = x[high] - x[low]
        share = (x - x[low]) / np.where(span > 0.0, span, 1.0)
        lines = scaled[low] + share[:, None] * (scaled[high] - scaled[low])
        off = np.abs(scaled - lines).max(axis=1)
        if off.max() <= _EXACT:
            break
        rows = np.sort(np.append(rows, off.argmax()))
    return rows
