"""Orbits: periods from independent sources, and rejected elements and element sets."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import Any

import pytest
from mgeo_attitude.scenario import Orbit, TLEOrbit
from mgeo_attitude.settings.errors import InvalidValue
from sgp4.api import Satrec
from sgp4.conveniences import sat_epoch_datetime

# International Space Station, 2008-09-20: the common example in descriptions of the format
ISS_1 = "1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927"
ISS_2 = "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537"
# Vanguard 1, 2000-06-27: verification case 00005 of Vallado et al. 2006, Revisiting Spacetrack 3
VANGUARD_1 = "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753"
VANGUARD_2 = "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667"

ELEMENTS: dict[str, Any] = {
    "semi_major_axis": 7e6,
    "eccentricity": 0.01,
    "inclination_deg": 98.0,
    "raan_deg": 0.0,
    "argument_of_perigee_deg": 0.0,
    "true_anomaly_deg": 0.0,
}


def with_checksum(line: str) -> str:
    """Return a line with the checksum of its first 68 columns, as the format defines it."""
    total = sum(int(c) for c in line[:68] if c in "0123456789") + line[:68].count("-")
    return f"{line[:68]}{total % 10}"


def test_geostationary_period_is_sidereal_day() -> None:
    orbit = Orbit(**ELEMENTS | {"semi_major_axis": 42_164_170.0})
    assert orbit.period == pytest.approx(86164.09, abs=0.1)


@pytest.mark.parametrize(("axis", "eccentricity"), [(6378136.3, 0.0), (7e6, 0.1), (7130.982, 0.0)])
def test_perigee_below_earth_surface_is_rejected(axis: float, eccentricity: float) -> None:
    with pytest.raises(InvalidValue) as error:
        Orbit(**ELEMENTS | {"semi_major_axis": axis, "eccentricity": eccentricity})
    message = str(error.value)
    assert message.startswith(f"semi_major_axis = {axis!r}: expected a perigee above the Earth")
    assert "> 6378136.3 m" in message
    assert f"not {axis * (1 - eccentricity):.12g} m" in message


@pytest.mark.parametrize(("line1", "line2"), [(ISS_1, ISS_2), (VANGUARD_1, VANGUARD_2)])
def test_element_sets_are_read_as_by_sgp4_package(line1: str, line2: str) -> None:
    orbit, satellite = TLEOrbit(line1=line1, line2=line2), Satrec.twoline2rv(line1, line2)
    revolutions_per_minute = satellite.no_kozai / math.tau
    assert orbit.period == pytest.approx(60.0 / revolutions_per_minute, rel=1e-14)
    assert abs((orbit.epoch - sat_epoch_datetime(satellite)).total_seconds()) < 1e-4


def test_two_digit_years_begin_in_1957() -> None:
    def year(digits: str) -> int:
        line1 = with_checksum(f"{ISS_1[:18]}{digits}{ISS_1[20:]}")
        return TLEOrbit(line1=line1, line2=ISS_2).epoch.year

    assert [year(digits) for digits in ("57", "99", "00", "56")] == [1957, 1999, 2000, 2056]


def test_day_one_is_first_of_january() -> None:
    line1 = with_checksum(f"{ISS_1[:20]}001.50000000{ISS_1[32:]}")
    assert TLEOrbit(line1=line1, line2=ISS_2).epoch == datetime(2008, 1, 1, 12, tzinfo=UTC)


@pytest.mark.parametrize(
    ("key", "line", "expected"),
    [
        ("line1", ISS_1[:-1], "expected 69 characters, not 68"),
        ("line2", ISS_2[:-1] + "é", "your TLE lines are broken"),
        ("line1", ISS_2, "TLE format error"),
        ("line1", ISS_1[:-1] + "8", "TLE line gives its checksum as 8 but in fact tallies to 7"),
        ("line2", VANGUARD_2, "Object numbers in lines 1 and 2 do not match"),
        ("line2", with_checksum(ISS_2[:8] + " 5x.6416" + ISS_2[16:]), "could not convert string"),
        (
            "line2",
            with_checksum(ISS_2[:52] + "18.72125391" + ISS_2[63:]),
            "expected a perigee above the Earth's surface",
        ),
    ],
)
def test_invalid_element_sets_are_rejected(key: str, line: str, expected: str) -> None:
    with pytest.raises(InvalidValue) as error:
        TLEOrbit(**{"line1": ISS_1, "line2": ISS_2} | {key: line})
    assert expected in str(error.value)
    assert repr(line) in str(error.value)
