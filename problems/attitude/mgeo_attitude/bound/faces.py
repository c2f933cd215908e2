"""What photodiodes tell together of the attitude, at most: the Sun shines on few faces at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.photodiode import Photodiode

#: Directions that are looked at.
_POINTS = 60000


def together(diodes: Sequence[Photodiode]) -> float:
    """A κ with which a sample of all tells no more than κ (I - s sᵀ), whatever the attitude.

    A diode tells w (n × s) (n × s)ᵀ for w = 1 / r² while the angle of the Sun s from its normal n
    is less than h: a matrix with no part along s. The largest eigenvalue of the sum is the square
    of the norm of the matrix of all √w (n × s), which changes by no more than √(Σ w) δ over an
    angle δ. No direction is farther from one of the points than δ; at a point those diodes count
    that are lit within it.
    """
    return _greatest(
        tuple((tuple(d.axes[2].tolist()), d.half_angle_deg, d.noise()[0]) for d in diodes)
    )


@cache
def _greatest(diodes: tuple[tuple[tuple[float, ...], float, float], ...]) -> float:
    points, within = _points()
    normals = np.array([normal for normal, _, _ in diodes])
    sides = np.array([1.0 / noise for _, _, noise in diodes])
    lit = points @ normals.T >= np.cos(np.radians([half for _, half, _ in diodes]) + within)
    rows = np.where(lit[:, :, None], sides[:, None] * np.cross(normals, points[:, None]), 0.0)
    norms = np.sqrt(np.linalg.eigvalsh(np.einsum("pia,pib->pab", rows, rows))[:, -1])
    slopes = np.sqrt(lit @ sides**2)
    return float((norms + within * slopes).max() ** 2)


@cache
def _points() -> tuple[Floats, float]:
    """Points of the unit sphere, and the angle from one of them within which all directions are.

    They are the middles of cells between parallels and meridians: a direction is half a cell's
    width from the middle meridian, along its parallel, and from there half a height.
    """
    n = round(np.sqrt(_POINTS * np.pi / 4.0))
    step = np.pi / n
    found = []
    for latitude in -0.5 * np.pi + step * (np.arange(n) + 0.5):
        widest = np.cos(max(abs(latitude) - 0.5 * step, 0.0))
        count = max(3, int(np.ceil(2.0 * n * widest)))
        longitude = 2.0 * np.pi / count * np.arange(count)
        found.append(
            np.column_stack(
                [
                    np.cos(latitude) * np.cos(longitude),
                    np.cos(latitude) * np.sin(longitude),
                    np.full(count, np.sin(latitude)),
                ]
            )
        )
    return np.concatenate(found), step
