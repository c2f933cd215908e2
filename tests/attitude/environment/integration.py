"""Numerical integration of orbits under the Earth's point mass and J2."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from mgeo_attitude.environment.constants import EARTH_J2, EARTH_MU, EARTH_RADIUS
from scipy.integrate import solve_ivp


def rates(_time: float, state: np.ndarray, oblate: bool = True) -> np.ndarray:
    """Return velocity and acceleration. The symmetry axis of J2 is z."""
    position = state[:3]
    radius = float(np.linalg.norm(position))
    polar = (position[2] / radius) ** 2
    shape = (
        1.5 * EARTH_J2 * (EARTH_RADIUS / radius) ** 2 * (np.array([1.0, 1.0, 3.0]) - 5.0 * polar)
    )
    return np.concatenate([state[3:], -EARTH_MU / radius**3 * (1.0 + oblate * shape) * position])


def integrated(state: np.ndarray, times: np.ndarray, oblate: bool = True) -> np.ndarray:
    """Return states [m], [m/s], shape (n, 6), at times [s]. The first time is that of `state`."""
    actual: Any = solve_ivp(
        partial(rates, oblate=oblate), times[[0, -1]], state, "DOP853", times,
        rtol=1e-13, atol=1e-6,
    )  # fmt: skip
    return np.asarray(actual.y.T)
