"""Two-body motion, and first-order secular drift by J2."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_J2, EARTH_MU, EARTH_RADIUS

#: Size of a Newton step [rad] below which the iteration ends.
_TOLERANCE = 1e-14
#: Largest number of iterations; 6 iterations suffice even at e = 1 - 1e-16.
_MAX_ITERATIONS = 50
#: Angle E [rad] below which E - sin E is computed by 8 terms of its series, to avoid cancellation.
_MAX_SERIES_ANGLE = 0.5


class Elements(NamedTuple):
    """Keplerian elements of an elliptic orbit about the Earth, in meters and radians."""

    semi_major_axis: float
    eccentricity: float
    inclination: float
    raan: float
    argument_of_perigee: float
    true_anomaly: float


def orbital_period(semi_major_axis: float) -> float:
    """Return the Keplerian period [s] of an orbit with a given semi-major axis [m]."""
    return math.tau * math.sqrt(semi_major_axis**3 / EARTH_MU)


def propagate_two_body(elements: Elements, times: ArrayLike) -> tuple[Floats, Floats]:
    """Compute position and velocity from Keplerian elements, assuming two-body motion.

    Parameters
    ----------
    elements : Elements
    times : array_like, shape (n,)
        Times after the epoch of the elements [s].

    Returns
    -------
    position, velocity : arrays, shape (n, 3)
        Position [m] and velocity [m/s] in the inertial axes of the elements.
    """
    return _propagate(elements, times, (0.0, 0.0, 0.0))


def propagate_j2_secular(elements: Elements, times: ArrayLike) -> tuple[Floats, Floats]:
    """Compute position and velocity by two-body motion with secular J2 drift of the elements.

    The velocity is the Keplerian velocity of the drifting elements, which neglects the motion of
    node and perigee (of relative size J2). The symmetry axis of J2 is the z axis of the elements.
    Parameters and results are those of `propagate_two_body`.
    """
    rates = j2_secular_rates(elements.semi_major_axis, elements.eccentricity, elements.inclination)
    return _propagate(elements, times, rates)


def j2_secular_rates(
    semi_major_axis: float, eccentricity: float, inclination: float
) -> tuple[float, float, float]:
    """Return the secular drift rates [rad/s] of node, argument of perigee and mean anomaly due to
    J2.

    The drift of the mean anomaly is relative to the Keplerian mean motion. Source: Kozai, The
    motion of a close Earth satellite, Astronomical Journal 64 (1959), equation 14, in which node
    and perigee drift in proportion to the perturbed mean motion.
    """
    eta_squared = 1.0 - eccentricity**2
    parameter = semi_major_axis * eta_squared
    sin_squared = math.sin(inclination) ** 2
    keplerian_motion = math.tau / orbital_period(semi_major_axis)
    strength = 0.75 * EARTH_J2 * (EARTH_RADIUS / parameter) ** 2
    mean_rate = keplerian_motion * strength * math.sqrt(eta_squared) * (2.0 - 3.0 * sin_squared)
    motion = keplerian_motion + mean_rate
    return (
        -2.0 * motion * strength * math.cos(inclination),
        motion * strength * (4.0 - 5.0 * sin_squared),
        mean_rate,
    )


def eccentric_anomaly(mean_anomaly: ArrayLike, eccentricity: float) -> Floats:
    """Solve Kepler's equation M = E - e sin E for the eccentric anomaly E [rad].

    The eccentricity must be below 1. Newton's method starts above the root, where the equation is
    convex, so that it converges monotonically. The number of revolutions of M is preserved.
    """
    mean = np.asarray(mean_anomaly, dtype=np.float64)
    revolutions = math.tau * np.round(mean / math.tau)
    folded = np.abs(mean - revolutions)  # The equation is odd in M, so that [0, pi] suffices.
    # These are upper bounds of the root from sin E <= 1, sin E <= E, and E - sin E >= E³/pi² for e
    # near 1.
    anomaly = np.minimum(folded + eccentricity, folded / (1.0 - eccentricity))
    if eccentricity > 0.5:
        anomaly = np.minimum(anomaly, np.cbrt(math.pi**2 * folded / eccentricity))
    anomaly = np.minimum(anomaly, math.pi)
    for _ in range(_MAX_ITERATIONS):
        slope = (1.0 - eccentricity) + 2.0 * eccentricity * np.sin(0.5 * anomaly) ** 2
        step = (_mean_anomaly(anomaly, eccentricity) - folded) / slope
        anomaly = anomaly - step
        if np.max(np.abs(step), initial=0.0) <= _TOLERANCE:
            break
    return revolutions + np.copysign(anomaly, mean - revolutions)


def propagate_elements(
    elements: Elements, time: float, rates: tuple[float, float, float]
) -> Elements:
    """Propagate Keplerian elements to a later time, with constant drift rates of the angles.

    Parameters
    ----------
    elements : Elements
    time : float
        Time after the epoch of the elements [s].
    rates : tuple of three float
        Drift of node, argument of perigee and mean anomaly [rad/s].

    Returns
    -------
    Elements
        Angles are not reduced to one revolution.
    """
    a, e, i, raan, perigee, true_anomaly = elements
    raan_rate, perigee_rate, mean_rate = rates
    mean = (
        mean_anomaly_from_true(true_anomaly, e) + (math.tau / orbital_period(a) + mean_rate) * time
    )
    half = 0.5 * float(eccentric_anomaly(mean, e))
    true = 2.0 * math.atan2(
        math.sqrt(1.0 + e) * math.sin(half), math.sqrt(1.0 - e) * math.cos(half)
    )
    return Elements(a, e, i, raan + raan_rate * time, perigee + perigee_rate * time, true)


def mean_anomaly_from_true(true_anomaly: float, eccentricity: float) -> float:
    """Return the mean anomaly [rad], between -pi and pi, for a true anomaly [rad]."""
    half = 0.5 * math.remainder(true_anomaly, math.tau)
    eccentric = 2.0 * math.atan2(
        math.sqrt(1.0 - eccentricity) * math.sin(half),
        math.sqrt(1.0 + eccentricity) * math.cos(half),
    )
    return float(_mean_anomaly(np.asarray(eccentric), eccentricity))


def _propagate(
    elements: Elements, times: ArrayLike, rates: tuple[float, float, float]
) -> tuple[Floats, Floats]:
    a, e, i, raan, perigee, true_anomaly = elements
    t = np.asarray(times, dtype=np.float64)
    raan_rate, perigee_rate, mean_rate = rates
    motion = math.tau / orbital_period(a) + mean_rate
    eccentric = eccentric_anomaly(mean_anomaly_from_true(true_anomaly, e) + motion * t, e)

    sin_e, cos_e = np.sin(eccentric), np.cos(eccentric)
    minor = math.sqrt(1.0 - e * e)
    speed = math.sqrt(EARTH_MU / a) / (1.0 - e * cos_e)
    toward_perigee, along = _compute_perifocal_axes(
        raan + raan_rate * t, perigee + perigee_rate * t, i
    )
    position = (a * (cos_e - e))[:, None] * toward_perigee + (a * minor * sin_e)[:, None] * along
    velocity = (-speed * sin_e)[:, None] * toward_perigee + (speed * minor * cos_e)[:, None] * along
    return position, velocity


def _compute_perifocal_axes(
    raan: Floats, perigee: Floats, inclination: float
) -> tuple[Floats, Floats]:
    """Return unit vectors toward the perigee and 90° ahead of the perigee, shape (n, 3)."""
    cos_r, sin_r, zero = np.cos(raan), np.sin(raan), np.zeros_like(raan)
    cos_i, sin_i = math.cos(inclination), math.sin(inclination)
    node = np.stack([cos_r, sin_r, zero], axis=1)
    ahead = np.stack([-cos_i * sin_r, cos_i * cos_r, zero + sin_i], axis=1)
    cosine, sine = np.cos(perigee)[:, None], np.sin(perigee)[:, None]
    return cosine * node + sine * ahead, cosine * ahead - sine * node


def _mean_anomaly(eccentric: Floats, eccentricity: float) -> Floats:
    """Convert an eccentric anomaly to the mean anomaly, accurately even if e is close to 1."""
    return (1.0 - eccentricity) * eccentric + eccentricity * _angle_minus_sine(eccentric)


def _angle_minus_sine(angle: Floats) -> Floats:
    """Return an angle minus its sine, without cancellation at small angles."""
    square = np.minimum(angle * angle, _MAX_SERIES_ANGLE**2)
    series = np.ones_like(square)
    for k in range(8, 0, -1):
        series = 1.0 - square / ((2 * k + 2) * (2 * k + 3)) * series
    return np.where(
        np.abs(angle) < _MAX_SERIES_ANGLE, angle**3 / 6.0 * series, angle - np.sin(angle)
    )
