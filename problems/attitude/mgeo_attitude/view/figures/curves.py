"""Simplification of curves to few points, and projection of directions on Hammer's equal-area
map.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo.figures.style import GRAY
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import perpendicular_axes

#: Tolerance of the simplification relative to the range of a curve.
_TOLERANCE = 0.002


def simplify_curves(x: Floats, curves: Floats, n_points: int) -> NDArray[np.int64]:
    """Select at most `n_points` samples that approximate all curves by polylines.

    Starting from both ends, the sample farthest from the polyline is added until there are
    `n_points` points or the tolerance is met (Douglas and Peucker 1973). The distance is the
    largest over all curves, each relative to its own range.

    Parameters
    ----------
    x : array, shape (k,)
        Abscissas of the samples, nondecreasing, no value more than twice.
    curves : array, shape (k, m)
        Samples of m curves.
    n_points : int
        Largest number of points.

    Returns
    -------
    array of int
        Indices in ascending order.
    """
    extent = np.ptp(curves, axis=0)
    scaled = curves / np.where(extent > 0.0, extent, 1.0)
    samples = np.arange(len(x))
    rows = np.unique([0, len(x) - 1])
    while 1 < len(rows) < n_points:
        after = np.clip(np.searchsorted(rows, samples, side="right"), 1, len(rows) - 1)
        low, high = rows[after - 1], rows[after]
        span = x[high] - x[low]
        share = (x - x[low]) / np.where(span > 0.0, span, 1.0)
        lines = scaled[low] + share[:, None] * (scaled[high] - scaled[low])
        distances = np.abs(scaled - lines).max(axis=1)
        if distances.max() <= _TOLERANCE:
            break
        rows = np.sort(np.append(rows, distances.argmax()))
    return rows


Int16Array = NDArray[np.int16]

#: Half the width and half the height of the map.
MAP_HALF_SIZE = (10500, 5250)

#: Map units per unit of the projection, in which the map is 4√2 wide and 2√2 high.
_SCALE = 10000.0 / np.sqrt(8.0)


def project_directions(vectors: Floats) -> tuple[Int16Array, Int16Array]:
    """Project directions onto a map in Hammer's equal-area projection.

    The body's x axis is at the center of the map, y on the right, z on top. Vectors with NaN are
    dropped. Source: E. Hammer, Über die Planisphäre von Aitow, Petermanns Mitteilungen 38 (1892)
    85-87.

    Parameters
    ----------
    vectors : array, shape (n, 3)
        Vectors in body axes, of any nonzero length.

    Returns
    -------
    across, up : arrays of int16, shape (m,)
        Horizontal and vertical map coordinates, within ± `MAP_HALF_SIZE`.
    """
    finite_vectors = vectors[np.isfinite(vectors).all(axis=1)]
    x, y, z = finite_vectors.T / np.linalg.norm(finite_vectors, axis=1)
    half = 0.5 * np.arctan2(y, x)
    level = np.sqrt(np.clip(1.0 - z**2, 0.0, 1.0))
    coordinates = np.array([2.0 * level * np.sin(half), z]) / np.sqrt(
        0.5 + 0.5 * level * np.cos(half)
    )
    across, up = np.rint(coordinates * _SCALE).astype(np.int16)
    return across, up


def project_circle(axis: ArrayLike, radius: float) -> tuple[Floats, Floats]:
    """Project a circle of directions onto a map in Hammer's equal-area projection.

    The line is interrupted by NaN where it crosses the edge of the map.

    Parameters
    ----------
    axis : array_like, shape (3,)
        Center of the circle in body axes.
    radius : float
        Angular radius [rad].

    Returns
    -------
    across, up : arrays, shape (k,)
        Horizontal and vertical map coordinates.
    """
    middle = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    first, second = perpendicular_axes(middle)
    around = np.linspace(0.0, 2.0 * np.pi, 145)[:, None]
    edge = np.cos(around) * first + np.sin(around) * second
    points = np.cos(radius) * middle + np.sin(radius) * edge
    coordinates = np.array(project_directions(points), dtype=float)
    x, y, _ = points.T
    jumps = np.flatnonzero((y[:-1] * y[1:] <= 0.0) & (x[:-1] + x[1:] < 0.0)) + 1
    right, up = np.insert(coordinates, jumps, np.nan, axis=1)
    return right, up


def draw_graticule() -> list[dict[str, Any]]:
    """Return plotly traces of the map grid and the axis labels."""
    latitudes = np.linspace(-90.0, 90.0, 37)
    # At exactly ±180 degrees, a meridian would jump to the other side of the map.
    longitudes = np.linspace(-179.999, 179.999, 73)
    lines = [_project_line(longitude, latitudes) for longitude in longitudes[::9]]
    lines += [_project_line(longitudes, latitude) for latitude in (-45.0, 0.0, 45.0)]
    across, up = np.hstack(lines)
    plain = {"type": "scatter", "hoverinfo": "skip", "showlegend": False}
    grid = {"mode": "lines", "line": {"color": GRAY, "width": 0.5}, "opacity": 0.6}
    axes = {"+x": [1, 0, 0], "+y": [0, 1, 0], "-y": [0, -1, 0], "+z": [0, 0, 1], "-z": [0, 0, -1]}
    x, y = project_directions(np.array(list(axes.values()), dtype=float))
    labels = {"mode": "text", "text": list(axes), "textfont": {"color": GRAY, "size": 13}}
    return [
        {**plain, **grid, "x": across, "y": up},
        {**plain, **labels, "x": x, "y": y},
    ]


def _project_line(longitude: Any, latitude: Any) -> Floats:
    """Project a line of longitudes and latitudes [deg] onto the map, followed by a NaN point."""
    east, north = np.broadcast_arrays(np.radians(longitude), np.radians(latitude))
    level = np.cos(north)
    points = np.column_stack([level * np.cos(east), level * np.sin(east), np.sin(north)])
    coordinates = np.array(project_directions(points), dtype=float)
    return np.pad(coordinates, ((0, 0), (0, 1)), constant_values=np.nan)
