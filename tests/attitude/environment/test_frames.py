"""Reference frames of files, compared with brahe and astropy."""

from __future__ import annotations

from datetime import UTC, datetime

import brahe
import numpy as np
import pytest
from astropy.coordinates import GCRS, TETE, CartesianRepresentation
from astropy.time import Time
from mgeo_attitude.environment.frames import convert_to_gcrs, lvlh_to_gcrs, parse_frame_name
from mgeo_attitude.environment.times import compute_julian_dates

EPOCH = datetime(2018, 6, 5, 3, 4, 5, tzinfo=UTC)
STATE = np.array([7e6, 1e5, 2e5, 10.0, 7500.0, 100.0])


@pytest.mark.parametrize(
    ("frame", "from_gcrs", "meters"),
    [
        ("GCRF", lambda at, state: state, 0.0),
        ("EME2000", lambda at, state: brahe.state_gcrf_to_eme2000(state), 1e-4),
        ("ITRF", brahe.state_gcrf_to_itrf, 1e-3),
        ("TEME", brahe.state_gcrf_to_teme, 1.0),  # TEME has two definitions.
    ],
)
def test_states_are_converted_to_gcrs(frame: str, from_gcrs, meters: float) -> None:
    brahe.set_global_eop_provider(brahe.StaticEOPProvider.from_zero())
    at = brahe.Epoch.from_datetime(2018, 6, 5, 3, 4, 5.0, 0.0, brahe.TimeSystem.UTC)
    state = from_gcrs(at, STATE)
    actual = convert_to_gcrs(
        frame, compute_julian_dates(EPOCH, [0.0]), state[None, :3], state[None, 3:]
    )
    assert np.abs(actual[0] - STATE[:3]).max() <= meters
    assert np.abs(actual[1] - STATE[3:]).max() <= 2e-3 * meters


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("ICRF", "GCRF"), ("gcrf", "GCRF"), ("ICRF3", "GCRF"), ("J2000", "EME2000"),
        ("ITRF2000", "ITRF"), ("ITRF-97", "ITRF"), ("WGS-84", "ITRF"), ("TEME", "TEME"),
        ("TEMEOFDATE", "TEME"), ("True of Date", "TOD"),
    ],
)  # fmt: skip
def test_frame_names_are_recognized(text: str, name: str) -> None:
    assert parse_frame_name(text) == name


@pytest.mark.parametrize("text", ["GTOD", "TEMEOFEPOCH", "RTN", "EME1950", ""])
def test_unsupported_frame_is_rejected(text: str) -> None:
    with pytest.raises(ValueError, match=rf"^reference frame '{text}': expected GCRF \(ICRF"):
        parse_frame_name(text)


def test_true_of_date_agrees_with_astropy() -> None:
    given = CartesianRepresentation(*STATE[:3], unit="m")
    when = Time(EPOCH.replace(tzinfo=None), scale="utc")
    true_of_date = (
        GCRS(given, obstime=when).transform_to(TETE(obstime=when)).cartesian.xyz.to_value("m")
    )
    actual, _ = convert_to_gcrs("TOD", compute_julian_dates(EPOCH, [0.0]), true_of_date[None], None)
    assert (
        np.abs(actual[0] - STATE[:3]).max() < 0.5
    )  # The nutation model of astropy is IAU 2006/2000B.


def test_lvlh_axes_are_forward_negative_normal_and_down() -> None:
    position, velocity = np.array([[7e6, 0.0, 0.0]]), np.array([[100.0, 0.0, 7500.0]])
    axes = lvlh_to_gcrs(position, velocity)[0].T
    np.testing.assert_allclose(axes, [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-15)
