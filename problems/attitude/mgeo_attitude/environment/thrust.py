"""Detection of thrust in orbit samples by comparison with unpowered motion.

From each sample, the motion under the Earth's point mass and J2 is integrated to a later sample.
The remaining change of velocity is attributed to other forces. In low orbits, unmodeled natural
forces are below 4e-4 m/s² (mainly higher gravity harmonics); a chemical thruster causes 1e-3 m/s²
and more. Samples of a two-body orbit are compared with the point mass alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_J2, EARTH_MU, EARTH_RADIUS

#: Acceleration above which an interval contains thrust [m/s²].
_MIN_ACCELERATION = 8e-4
#: Time between compared samples [s], long enough for velocities that are rounded to 1 mm/s.
_COMPARISON_SPAN = 60.0
#: Number of integration steps between two samples.
_N_STEPS = 24


class Thrust(NamedTuple):
    """Time interval in which orbit samples show an acceleration other than gravity.

    Attributes
    ----------
    start, end : float
        Times of the first and the last sample [s].
    acceleration : float
        Largest mean acceleration between two samples of the interval [m/s²].
    """

    start: float
    end: float
    acceleration: float


def find_thrust(times: Floats, position: Floats, velocity: Floats) -> list[Thrust]:
    """Find the time intervals in which orbit samples show thrust, in chronological order.

    Parameters
    ----------
    times : array, shape (n,)
        Times of the samples [s], increasing.
    position, velocity : arrays, shape (n, 3)
        Position [m] and velocity [m/s], in inertial axes whose z axis is close to the Earth's.
    """
    n = len(times)
    # Compare each sample with the last sample within the span, or with the next sample if it is
    # later.
    later = np.searchsorted(times, times + _COMPARISON_SPAN, side="right") - 1
    later = np.maximum(later, np.minimum(np.arange(n) + 1, n - 1))
    rows = np.flatnonzero((times + _COMPARISON_SPAN <= times[-1]) & (later > np.arange(n)))
    duration = (times[later] - times)[rows, None]
    start = np.stack([position[rows], velocity[rows]])
    acceleration = min(
        (
            _compute_residual_acceleration(start, velocity[later[rows]], duration, j2)
            for j2 in (EARTH_J2, 0.0)
        ),
        key=np.median,
    )
    intervals: list[Thrust] = []
    for row in np.flatnonzero(acceleration > _MIN_ACCELERATION).tolist():
        first, last = float(times[rows[row]]), float(times[later[rows[row]]])
        strength = float(acceleration[row])
        if intervals and first <= intervals[-1].end:
            before = intervals.pop()
            first, strength = before.start, max(strength, before.acceleration)
        intervals.append(Thrust(first, last, strength))
    return intervals


def _compute_residual_acceleration(
    start: Floats, velocity: Floats, duration: Floats, j2: float
) -> Floats:
    """Compute the mean non-gravitational acceleration [m/s²] between samples, shape (n,).

    Parameters
    ----------
    start : array, shape (2, n, 3)
        Initial position and velocity.
    velocity : array, shape (n, 3)
        Velocity at the end of the interval [m/s].
    duration : array, shape (n, 1)
        Length of the interval [s].
    j2 : float
        Second zonal harmonic of the Earth, or 0 for a point mass.
    """
    h, state = duration / _N_STEPS, start
    for _ in range(_N_STEPS):
        k1 = _compute_derivative(state, j2)
        k2 = _compute_derivative(state + 0.5 * h * k1, j2)
        k3 = _compute_derivative(state + 0.5 * h * k2, j2)
        k4 = _compute_derivative(state + h * k3, j2)
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return np.asarray(np.linalg.norm(velocity - state[1], axis=1) / duration[:, 0])


def _compute_derivative(state: Floats, j2: float) -> Floats:
    position, velocity = state
    radius = np.linalg.norm(position, axis=1, keepdims=True)
    polar = 5.0 * (position[:, 2:] / radius) ** 2
    oblate = 1.5 * j2 * (EARTH_RADIUS / radius) ** 2 * (np.array([1.0, 1.0, 3.0]) - polar)
    return np.stack([velocity, -EARTH_MU / radius**3 * position * (1.0 + oblate)])
