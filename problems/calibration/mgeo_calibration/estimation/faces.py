"""Photodiodes of a satellite: which face the Sun, and where together they see it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors import Photodiode, Sensor, Suite

#: Smallest eigenvalue of Σ n nᵀ over normals of lit faces: it is 1 of three at right angles.
_SPREAD = 0.05


def without_dark(sensor: Sensor, rows: Floats) -> Floats:
    """Readings, shape (n, k, 3), of a photodiode without those of a Sun outside its cone.

    Whether it is inside say the samples before and after, since noise of its own that decided
    would be noise of a sign; where both are missing it says so itself.
    """
    if not isinstance(sensor, Photodiode):
        return rows
    values = rows[:, 0, 0]
    around = np.full((2, len(values)), np.nan)
    around[0, 1:], around[1, :-1] = values[:-1], values[1:]
    count = np.isfinite(around).sum(axis=0)
    mean = np.where(count > 0, np.nansum(around, axis=0) / np.maximum(count, 1), values)
    lit = mean >= np.cos(np.radians(sensor.half_angle_deg))
    found: Floats = np.where(lit[:, None, None], rows, np.nan)
    return found


def sun_directions(suite: Suite, readings: Sequence[Floats], states: Floats) -> Floats:
    """Where all photodiodes together see the Sun, body axes, shape (N, 3), NaN where they do not.

    By least squares over those that are lit, of which three or more have to look well apart.

    Parameters
    ----------
    readings : sequence of array, shape (N, k, 3)
        Of each sensor of the suite.
    states : array, shape (N, n_states)
        Whose errors are taken out.
    """
    A, b = np.zeros((len(states), 3, 3)), np.zeros((len(states), 3))
    for sensor, rows in zip(suite.sensors, readings, strict=True):
        if isinstance(sensor, Photodiode):
            first = suite.places(sensor)["sensitivity"]
            normals = sensor.axes[2] + states[:, first : first + 3] @ sensor.axes
            seen = np.isfinite(rows[:, 0, 0])
            A[seen] += normals[seen, :, None] * normals[seen, None]
            b[seen] += normals[seen] * rows[seen, 0]
    found = np.full(b.shape, np.nan)
    apart = np.linalg.eigvalsh(A)[:, 0] > _SPREAD
    found[apart] = np.linalg.solve(A[apart], b[apart, :, None])[..., 0]
    return found
