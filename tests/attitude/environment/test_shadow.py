"""Eclipses, compared with published transitions and with rays to the Sun's disc."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import numpy as np
import pytest
from mgeo_attitude.environment.constants import ASTRONOMICAL_UNIT, EARTH_RADIUS, SUN_RADIUS
from mgeo_attitude.environment.kepler import Elements, propagate_two_body
from mgeo_attitude.environment.sun_moon import sun_position, visible_sun_fraction
from mgeo_attitude.environment.times import compute_julian_dates

_SUN = np.array([[ASTRONOMICAL_UNIT, 0.0, 0.0]])


def test_eclipse_times_of_paper_orbit() -> None:
    """Half of the disc is visible at 3877, 5843, 9869 and 11835 s."""
    angles = (math.radians(degrees) for degrees in (98.405, 230.297, 90.0, 305.0))
    times = np.arange(12000.0)
    position, _ = propagate_two_body(Elements(7130982.0, 0.001111, *angles), times)
    sun = sun_position(compute_julian_dates(datetime(2020, 6, 19, tzinfo=UTC), times))
    fraction = visible_sun_fraction(position, sun)
    sunlit = fraction >= 0.5
    transitions = times[1:][np.diff(sunlit.astype(int)) != 0]
    np.testing.assert_allclose(transitions, [3877.0, 5843.0, 9869.0, 11835.0], atol=1.0)
    assert sunlit.mean() == pytest.approx(0.672, abs=5e-4)
    # The edges of umbra and penumbra are within 6 s, since the orbit crosses the penumbra in 11 s.
    for lit in (fraction == 1.0, fraction > 0.0):
        edges = times[1:][np.diff(lit.astype(int)) != 0]
        np.testing.assert_allclose(edges, [3877.0, 5843.0, 9869.0, 11835.0], atol=6.0)


def cast_rays(position: np.ndarray, sun: np.ndarray, rays: int = 400) -> float:
    """Return the fraction of the Sun's disc from which a straight line reaches the satellite."""
    to_sun = sun - position
    distance = np.linalg.norm(to_sun)
    axis = to_sun / distance
    side = np.cross(axis, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    grid = np.linspace(-1.0, 1.0, rays)
    u, v = (g[np.hypot(*np.meshgrid(grid, grid)) <= 1.0] for g in np.meshgrid(grid, grid))
    radius = math.asin(SUN_RADIUS / distance)
    directions = axis + radius * (u[:, None] * side + v[:, None] * np.cross(axis, side))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    along = directions @ position
    miss = np.linalg.norm(position - along[:, None] * directions, axis=1)
    return float(np.mean((along > 0.0) | (miss > EARTH_RADIUS)))


def test_visible_fraction_equals_ray_casting() -> None:
    """The positions cross the penumbra of a low orbit."""
    angles = math.pi - math.asin(EARTH_RADIUS / 7.1e6) + np.linspace(-0.007, 0.007, 15)
    position = 7.1e6 * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    fraction = visible_sun_fraction(position, np.repeat(_SUN, 15, axis=0))
    rays = [cast_rays(point, _SUN[0]) for point in position]
    np.testing.assert_allclose(fraction, rays, atol=4e-3)
    assert fraction.min() == 0.0
    assert fraction.max() == 1.0
    assert ((fraction > 0.0) & (fraction < 1.0)).sum() > 5


def test_visible_fraction_on_shadow_axis() -> None:
    """The positions are in the umbra, in sunlight, and beyond the tip of the umbra."""
    far = 2e9
    position = np.array([[-7e6, 0.0, 0.0], [7e6, 0.0, 0.0], [-far, 0.0, 0.0]])
    fraction = visible_sun_fraction(position, np.repeat(_SUN, 3, axis=0))
    ratio = math.asin(EARTH_RADIUS / far) / math.asin(SUN_RADIUS / (ASTRONOMICAL_UNIT + far))
    np.testing.assert_allclose(fraction, [0.0, 1.0, 1.0 - ratio**2], rtol=1e-9)
    assert ratio < 1.0


@pytest.mark.parametrize("radius", [6.3e6, 0.0, math.nan])
def test_position_inside_earth_is_rejected(radius: float) -> None:
    with pytest.raises(ValueError, match="expected a satellite above the Earth's surface"):
        visible_sun_fraction(np.array([[radius, 0.0, 0.0]]), _SUN)
