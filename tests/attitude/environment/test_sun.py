"""Position and direction of the Sun, compared with SOFA and other ephemerides."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import pytest
from mgeo_attitude.environment.constants import ASTRONOMICAL_UNIT
from mgeo_attitude.environment.sun_moon import sun_direction, sun_position
from mgeo_attitude.environment.times import JulianDates, compute_julian_dates


def test_sun_position_equals_sofa() -> None:
    day = np.array([53411.52501161])
    sun = sun_position(JulianDates(2400000.5, ut=day, tt=day))
    earth = [-0.7757238809297706813, 0.5598052241363340596, 0.2426998466481686993]
    np.testing.assert_allclose(-sun[0] / ASTRONOMICAL_UNIT, earth, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize(
    ("date", "published"),
    [
        (datetime(2020, 6, 19, tzinfo=UTC), (0.03654755, 0.91688813, 0.39746753)),
        (datetime(2024, 3, 20, tzinfo=UTC), (0.99996778, -0.00736415, -0.00319557)),
    ],
)
def test_sun_direction_agrees_with_other_ephemerides(
    date: datetime, published: tuple[float, float, float]
) -> None:
    """Four ephemerides agree on these geocentric directions to 4e-6°."""
    sun = sun_position(compute_julian_dates(date, [0.0]))
    direction = sun_direction(np.zeros((1, 3)), sun)[0]
    assert np.degrees(np.linalg.norm(np.cross(direction, published))) < 4e-6
    assert direction @ published > 0.0


def test_interpolated_sun_position_equals_theory() -> None:
    at = compute_julian_dates(datetime(2025, 3, 1, 12, tzinfo=UTC), np.linspace(0.0, 1e6, 25001))
    some = np.arange(0, 25001, 500)
    each = sun_position(JulianDates(at.midnight, at.ut[some], at.tt[some]))
    error = sun_position(at)[some] - each
    assert np.abs(error).max() < 1e-12 * ASTRONOMICAL_UNIT


def test_sun_direction_is_seen_from_satellite() -> None:
    position = np.array([[7e6, 0.0, 0.0], [0.0, 7e6, 0.0]])
    sun = np.array([[7e6, 1e11, 0.0], [0.0, 0.0, 1e11]])
    direction = sun_direction(position, sun)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, rtol=1e-15)
    np.testing.assert_allclose(direction, [[0.0, 1.0, 0.0], [0.0, -7e-5, 1.0]], atol=1e-8)
