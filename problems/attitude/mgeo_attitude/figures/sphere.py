"""Directions as points of an equal-area map of the sphere (Hammer's projection)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mgeo.figures.style import GRAY

Floats = NDArray[np.float64]
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
    root = np.sqrt(1.0 + level * np.cos(half))
    across = 2.0 * np.sqrt(2.0) * level * np.sin(half) / root
    up = np.sqrt(2.0) * z / root
    return _short(across), _short(up)


def graticule() -> list[dict[str, Any]]:
    """Traces of meridians and parallels, 45 degrees apart, and of the names of the axes."""
    fine = np.radians(np.linspace(-90.0, 90.0, 37))
    # a hair inside ±180 degrees: beyond it a meridian would jump to the other side
    longitudes = np.radians([-179.999, -135.0, -90.0, -45.0, 0.0, 45.0, 90.0, 135.0, 179.999])
    lines = [_unit(np.full(37, longitude), fine) for longitude in longitudes]
    around = np.radians(np.linspace(-179.999, 179.999, 73))
    lines += [_unit(around, np.full(73, np.radians(latitude))) for latitude in (-45.0, 0.0, 45.0)]
    across: list[float | None] = []
    up: list[float | None] = []
    for line in lines:
        x, y = projected(line)
        across += [*x.tolist(), None]
        up += [*y.tolist(), None]
    plain = {"type": "scatter", "hoverinfo": "skip", "showlegend": False}
    grid = {"mode": "lines", "line": {"color": GRAY, "width": 0.5}, "opacity": 0.6}
    names = ("+x", "+y", "-y", "+z", "-z")
    ends = np.array([[1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    x, y = projected(ends)
    labels = {"mode": "text", "text": list(names), "textfont": {"color": GRAY, "size": 13}}
    return [
        {**plain, **grid, "x": across, "y": up},
        {**plain, **labels, "x": x, "y": y},
    ]


def _unit(longitude: Floats, latitude: Floats) -> Floats:
    level = np.cos(latitude)
    return np.column_stack([level * np.cos(longitude), level * np.sin(longitude), np.sin(latitude)])


def _short(values: Floats) -> Shorts:
    short: Shorts = np.rint(values * _SCALE).astype(np.int16)
    return short
