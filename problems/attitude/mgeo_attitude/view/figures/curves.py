"""Curves of few points: corners that draw many samples, directions on Hammer's equal-area map."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo.figures.style import GRAY
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import across

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


Shorts = NDArray[np.int16]

#: Half the width and half the height of the map.
OUTLINE = (10500, 5250)

#: Of the projection's √2, in which the map is 4√2 wide and 2√2 high, in units of the map.
_SCALE = 10000.0 / np.sqrt(8.0)


def projected(vectors: Floats) -> tuple[Shorts, Shorts]:
    """Position on the map of vectors, shape (n, 3), of any length but zero; rows with NaN go.

    The body's x axis is in the middle, y on the right, z on top. E. Hammer, Über die Planisphäre
    von Aitow, Petermanns Mitteilungen 38 (1892) 85-87.
    """
    known = vectors[np.isfinite(vectors).all(axis=1)]
    x, y, z = known.T / np.linalg.norm(known, axis=1)
    half = 0.5 * np.arctan2(y, x)
    level = np.sqrt(np.clip(1.0 - z**2, 0.0, 1.0))
    place = np.array([2.0 * level * np.sin(half), z]) / np.sqrt(0.5 + 0.5 * level * np.cos(half))
    across, up = np.rint(place * _SCALE).astype(np.int16)
    return across, up


def circle(axis: ArrayLike, radius: float) -> tuple[Floats, Floats]:
    """A circle of this angular radius [rad] about a body direction, as a line on the map.

    It is broken where it leaves the map on one side and comes back on the other.
    """
    middle = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    first, second = across(middle)
    around = np.linspace(0.0, 2.0 * np.pi, 145)[:, None]
    edge = np.cos(around) * first + np.sin(around) * second
    points = np.cos(radius) * middle + np.sin(radius) * edge
    place = np.array(projected(points), dtype=float)
    x, y, _ = points.T
    jumps = np.flatnonzero((y[:-1] * y[1:] <= 0.0) & (x[:-1] + x[1:] < 0.0)) + 1
    right, up = np.insert(place, jumps, np.nan, axis=1)
    return right, up


def graticule() -> list[dict[str, Any]]:
    """Traces of meridians and parallels, 45 degrees apart, and of the names of the axes."""
    latitudes = np.linspace(-90.0, 90.0, 37)
    # a hair inside ±180 degrees: beyond it a meridian would jump to the other side
    longitudes = np.linspace(-179.999, 179.999, 73)
    lines = [_line(longitude, latitudes) for longitude in longitudes[::9]]
    lines += [_line(longitudes, latitude) for latitude in (-45.0, 0.0, 45.0)]
    across, up = np.hstack(lines)
    plain = {"type": "scatter", "hoverinfo": "skip", "showlegend": False}
    grid = {"mode": "lines", "line": {"color": GRAY, "width": 0.5}, "opacity": 0.6}
    axes = {"+x": [1, 0, 0], "+y": [0, 1, 0], "-y": [0, -1, 0], "+z": [0, 0, 1], "-z": [0, 0, -1]}
    x, y = projected(np.array(list(axes.values()), dtype=float))
    labels = {"mode": "text", "text": list(axes), "textfont": {"color": GRAY, "size": 13}}
    return [
        {**plain, **grid, "x": across, "y": up},
        {**plain, **labels, "x": x, "y": y},
    ]


def _line(longitude: Any, latitude: Any) -> Floats:
    """Points of a line on the map, and a gap after it, shape (2, n + 1), from angles [deg]."""
    east, north = np.broadcast_arrays(np.radians(longitude), np.radians(latitude))
    level = np.cos(north)
    points = np.column_stack([level * np.cos(east), level * np.sin(east), np.sin(north)])
    place = np.array(projected(points), dtype=float)
    return np.pad(place, ((0, 0), (0, 1)), constant_values=np.nan)
