"""Time scales and frame rotations, compared with values of SOFA and Vallado."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import erfa
import numpy as np
import pytest
from mgeo_attitude.environment.frames import gcrs_to_itrs, rotate, teme_to_gcrs
from mgeo_attitude.environment.times import JulianDates, compute_julian_dates

# Vallado, Fundamentals of Astrodynamics and Applications, example 3-15 and table 3-6 [m]. The TEME
# vector is the one printed there and in AIAA 2006-6753 for the same satellite and instant.
EXAMPLE_3_15 = datetime(2004, 4, 6, 7, 51, 28, 386009, tzinfo=UTC)
GCRF = 1e3 * np.array([[5102.50895790, 6123.01140070, 6378.13692820]])
ITRF = 1e3 * np.array([[-1033.4793830, 7901.2952754, 6380.3565958]])
TEME = 1e3 * np.array([[5094.18016210, 6127.64465950, 6380.34453270]])
DUT1 = -0.4399619
POLAR_MOTION = np.array([-0.140682, 0.333309]) * erfa.DAS2R


def add_dut1(at: JulianDates) -> JulianDates:
    return at._replace(ut=at.ut + DUT1 / 86400.0)


def distance(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm(a - b))


def test_terrestrial_time_equals_vallado_example_3_15() -> None:
    at = compute_julian_dates(EXAMPLE_3_15, [0.0])
    assert at.midnight == 2453101.5
    assert at.tt[0] == pytest.approx(0.328154745, abs=1e-9)


def test_gcrs_to_itrs_with_published_earth_orientation() -> None:
    """With dUT1 and polar motion applied, only dX and dY (1 cm) are neglected."""
    at = add_dut1(compute_julian_dates(EXAMPLE_3_15, [0.0]))
    tirs = rotate(gcrs_to_itrs(at), GCRF)
    wobble = erfa.pom00(*POLAR_MOTION, erfa.sp00(at.midnight, at.tt))
    assert distance(rotate(wobble, tirs), ITRF) < 0.02


def test_error_of_neglected_earth_orientation_is_as_documented() -> None:
    """Without dUT1 and polar motion, the error in this example is 262 m."""
    at = compute_julian_dates(EXAMPLE_3_15, [0.0])
    assert distance(rotate(gcrs_to_itrs(at), GCRF), ITRF) == pytest.approx(262.0, abs=1.0)


def test_teme_to_gcrs_equals_vallado_example_3_15() -> None:
    at = compute_julian_dates(EXAMPLE_3_15, [0.0])
    assert distance(rotate(teme_to_gcrs(at), TEME), GCRF) < 0.02
    assert distance(rotate(teme_to_gcrs(add_dut1(at)), TEME), GCRF) < 0.02


def test_earth_rotation_angle_equals_sofa() -> None:
    at = JulianDates(2400000.5, ut=np.array([54388.0]), tt=np.array([54388.0]))
    rotation = gcrs_to_itrs(at)[0] @ erfa.c2i06a(2400000.5, 54388.0).T
    angle = math.atan2(rotation[0, 1], rotation[0, 0])
    assert angle == pytest.approx(0.4022837240028158102, abs=1e-12)


@pytest.mark.parametrize(("duration", "tolerance"), [(11984.0, 3e-10), (86400.0, 3e-8)])
def test_interpolated_rotation_agrees_with_series(duration: float, tolerance: float) -> None:
    at = compute_julian_dates(datetime(2020, 6, 19, tzinfo=UTC), np.linspace(0.0, duration, 60))
    series = erfa.c2t06a(at.midnight, at.tt, at.midnight, at.ut, 0.0, 0.0)
    assert np.abs(gcrs_to_itrs(at) - series).max() < tolerance


def test_julian_dates_are_continuous_through_leap_second() -> None:
    """The interval from 2016-12-31T23:59:59 to midnight has two seconds."""
    before = compute_julian_dates(datetime(2016, 12, 31, 23, 59, 59, tzinfo=UTC), [0.0, 2.0])
    after = compute_julian_dates(datetime(2017, 1, 1, tzinfo=UTC), [0.0])
    elapsed = (after.midnight - before.midnight + after.tt[0] - before.tt[1]) * 86400.0
    assert elapsed == pytest.approx(0.0, abs=1e-9)
    assert before.tt[0] - before.ut[0] == pytest.approx(68.184 / 86400.0, abs=1e-14)
    assert before.ut[1] - before.ut[0] == pytest.approx(2.0 / 86400.0, abs=1e-14)


@pytest.mark.parametrize(("year", "offset"), [(1900, 32.184), (1950, 32.184), (2029, 69.184)])
def test_years_without_leap_seconds_cause_no_warning(year: int, offset: float) -> None:
    at = compute_julian_dates(datetime(year, 7, 1, 12, tzinfo=UTC), [0.0])
    assert (at.tt - at.ut) * 86400.0 == pytest.approx([offset], abs=1e-9)


def test_epoch_without_utc_offset_is_rejected() -> None:
    with pytest.raises(ValueError, match=r"epoch = 2020-06-19T00:00:00: expected a UTC offset"):
        compute_julian_dates(datetime(2020, 6, 19), [0.0])
