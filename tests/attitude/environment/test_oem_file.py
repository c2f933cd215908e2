"""Orbit ephemeris messages in several frames and time systems, and invalid messages."""

from __future__ import annotations

import dataclasses
import gzip
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import brahe
import numpy as np
import pytest
from brahe.ccsds import OEM
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.element_set import TLEOrbit, compute_gcrs_states
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.scenario import EphemerisOrbit, OrbitFile
from mgeo_attitude.settings.errors import InvalidValue

from mgeo.plugins.problems import load_problem, read_scenario

from ..scenario.test_orbit import ISS_1, ISS_2

ISS = Path(__file__).parents[1] / "reference" / "iss-2008-09-20.oem"
ISS_EPOCH = datetime(2008, 9, 20, 12, 40, tzinfo=UTC)
SCENARIO = dataclasses.replace(Scenario.paper(), step=10.0, duration=6000.0)
TIMES = np.arange(-300.0, 6301.0, 60.0)

Frame = Callable[[brahe.Epoch, np.ndarray], np.ndarray]
FRAMES: dict[str, Frame] = {
    "GCRF": lambda at, state: state,
    "EME2000": lambda at, state: brahe.state_gcrf_to_eme2000(state),
    "ITRF2000": brahe.state_gcrf_to_itrf,
}


def build_message(
    frame: str, system: str, interpolation: str, start: datetime = SCENARIO.epoch, form: str = "KVN"
) -> str:
    """Return a message of the two-body orbit, converted and written by brahe."""
    brahe.set_global_eop_provider(brahe.StaticEOPProvider.from_zero())
    clock = start.year, start.month, start.day, start.hour, start.minute, start.second
    epoch = brahe.Epoch.from_datetime(*clock, 0.0, brahe.TimeSystem.UTC)
    gcrs = np.hstack(SCENARIO.orbit.propagate(start, TIMES))
    oem = OEM(originator="SOMEBODY ELSE")
    oem.add_segment(
        object_name="PAPER", object_id="2018-001A", center_name="EARTH", ref_frame=frame,
        time_system=system, start_time=epoch + TIMES[0], stop_time=epoch + TIMES[-1],
        interpolation=interpolation, interpolation_degree=7,
    )  # fmt: skip
    for time, own in zip(TIMES.tolist(), gcrs, strict=True):
        state = FRAMES[frame](epoch + time, own)
        oem.segments[0].add_state(
            epoch=epoch + time, position=state[:3].tolist(), velocity=state[3:].tolist()
        )
    return str(oem.to_string(form))


def compute_max_errors(
    orbit: EphemerisOrbit, start: datetime = SCENARIO.epoch
) -> tuple[float, float]:
    """Return the largest errors of position [m] and velocity [m/s] for the two-body orbit."""
    actual = orbit.propagate(start, SCENARIO.times)
    expected = SCENARIO.orbit.propagate(start, SCENARIO.times)
    apart = [np.linalg.norm(a - b, axis=1).max() for a, b in zip(actual, expected, strict=True)]
    return float(apart[0]), float(apart[1])


def read_orbit(path: Path, text: str, epoch: datetime, duration: float, **keys: Any) -> Any:
    path.write_text(text)
    return OrbitFile(file=str(path), **keys).prepare_for_run(epoch, duration)


@pytest.mark.parametrize("form", ["KVN", "XML"])
@pytest.mark.parametrize(
    ("frame", "system", "interpolation"),
    [
        ("GCRF", "UTC", "HERMITE"),
        ("EME2000", "TT", "LAGRANGE"),
        ("ITRF2000", "GPS", "HERMITE"),
        ("ITRF2000", "TAI", "LAGRANGE"),
    ],
)
def test_messages_of_brahe_are_read(
    tmp_path: Path, frame: str, system: str, interpolation: str, form: str
) -> None:
    """Positions in the message are rounded to 1 mm."""
    text = build_message(frame, system, interpolation, form=form)
    orbit = read_orbit(tmp_path / "paper.oem", text, SCENARIO.epoch, SCENARIO.duration)
    position, velocity = compute_max_errors(orbit)
    assert position < 1.5e-3
    assert velocity < 1e-4
    assert bool(orbit.velocity) == (interpolation == "HERMITE")


def test_message_may_include_leap_second(tmp_path: Path) -> None:
    start = datetime(2016, 12, 31, 23, 30, tzinfo=UTC)
    text = build_message("GCRF", "UTC", "HERMITE", start)
    assert "2016-12-31T23:59:00" in text
    assert "2017-01-01T00:00:59" in text  # 120 s later
    orbit = read_orbit(tmp_path / "leap.oem", text, start, SCENARIO.duration)
    np.testing.assert_allclose(np.diff(orbit.times), 60.0, rtol=0.0, atol=1e-9)
    assert compute_max_errors(orbit, start)[0] < 1.5e-3


@pytest.mark.parametrize(
    ("keys", "degree", "least", "most"),
    [
        ({}, 8, 0.0, 0.3),  # method of the message; 0.22 m at the samples
        ({"interpolation": "hermite", "degree": 5}, 5, 0.3, 1.5),
    ],
)
def test_message_in_teme_agrees_with_sgp4(
    keys: dict[str, Any], degree: int, least: float, most: float
) -> None:
    """The message was written by the package beyond, with states every 180 s."""
    orbit: Any = OrbitFile(file=str(ISS), **keys).prepare_for_run(ISS_EPOCH, 5400.0)
    times = np.arange(0.0, 5401.0, 10.0)
    satellite = TLEOrbit(line1=ISS_1, line2=ISS_2).build_satellite()
    expected, motion = compute_gcrs_states(satellite, compute_julian_dates(ISS_EPOCH, times))
    actual, velocity = orbit.propagate(ISS_EPOCH, times)
    assert least < np.linalg.norm(actual - expected, axis=1).max() < most
    assert np.linalg.norm(velocity - motion, axis=1).max() < 0.5  # SGP4 alone causes 0.4 m/s.
    assert orbit.degree == degree
    assert orbit.period == pytest.approx(86400.0 / 15.72125391, rel=2e-3)


def test_scenario_stores_samples_instead_of_file(tmp_path: Path) -> None:
    """The path of the file is relative to the scenario file."""
    (tmp_path / "orbits").mkdir()
    copy = tmp_path / "orbits" / "iss.oem"
    copy.write_bytes(ISS.read_bytes())
    path = tmp_path / "mine.toml"
    path.write_text(
        'preset = "cubesat_6u"\nepoch = 2008-09-20T12:40:00Z\nduration = 5400.0\n'
        '[orbit]\nfile = "orbits/iss.oem"\n'
    )
    scenario, options = Scenario.from_toml(path), read_scenario("attitude", str(path))
    copy.unlink()
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    assert Scenario.from_dict(scenario.to_dict()) == scenario
    assert load_problem("attitude", options).to_options() == options
    assert isinstance(scenario.orbit, EphemerisOrbit)
    assert scenario.orbit.source == "iss.oem, ISS (ZARYA) 1998-067A"
    height = np.linalg.norm(Environment.from_scenario(scenario).position, axis=1) - 6378136.3
    assert 330e3 < height.min() < height.max() < 380e3
    with pytest.raises(
        ValueError, match=r"mine\.toml: orbit\.file = .*iss\.oem': expected an exist"
    ):
        read_scenario("attitude", str(path))


def test_unneeded_samples_are_omitted_without_effect() -> None:
    file = OrbitFile(file=str(ISS), interpolation="hermite", degree=7)
    complete, part = (
        file.prepare_for_run(ISS_EPOCH, 5400.0),
        file.prepare_for_run(ISS_EPOCH, 1800.0),
    )
    assert len(part.times) < 25 < len(complete.times)
    times = np.arange(0.0, 1801.0, 7.0)
    actual, expected = (orbit.propagate(ISS_EPOCH, times)[0] for orbit in (part, complete))
    # The nutation is interpolated over the samples, see `gcrs_to_itrs`.
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=2e-3)


def remove_rows(text: str, start: int, stop: int | None) -> str:
    lines = text.rstrip().splitlines()
    del lines[start:stop]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda t: "", "expected element sets (OMM, or two lines) or an orbit ephemeris message"),
        (lambda t: t.replace("= TEME", "= GTOD"), "reference frame 'GTOD': expected GCRF (ICRF"),
        (lambda t: t.replace("META_STOP", "REF_FRAME_EPOCH = 2000-01-01T12:00:00\nMETA_STOP"),
         "REF_FRAME_EPOCH: expected no entry, since only axes of date"),
        (lambda t: t.replace("STOP_TIME            = 2008-09-20T14", "STOP_TIME = 2008-09-20T13"),
         "expected the whole run, 2008-09-20T12:40:00.000Z to 2008-09-20T14:10:00.000Z, in one "
         "segment; found 2008-09-20T12:25:40.104Z to 2008-09-20T13:25:40.104Z"),
        (lambda t: remove_rows(t, 24, 44), "through neighboring samples that agree to 1000 m"),
        (lambda t: remove_rows(t, -10, None), "expected samples for the whole run"),
        (lambda t: t.replace("2699.420566", "2729.42"), "a maneuver, or wrong samples, from 2008"),
    ],
)  # fmt: skip
def test_invalid_messages_are_rejected(
    tmp_path: Path, change: Callable[[str], str], expected: str
) -> None:
    path = tmp_path / "iss.oem"
    with pytest.raises(InvalidValue) as caught:
        read_orbit(path, change(ISS.read_text()), ISS_EPOCH, 5400.0)
    assert str(caught.value).startswith(f"file = '{path}': ")
    assert expected in str(caught.value)


def test_run_must_be_within_one_segment(tmp_path: Path) -> None:
    """There may be a maneuver between segments, even if they share an instant."""
    meeting = "2008-09-20T13:25:40.104192"
    first, second = (
        ISS.read_text().replace(f"{key:21}= {old}", f"{key} = {meeting}")
        for key, old in (
            ("STOP_TIME", "2008-09-20T14:25:40.104192"),
            ("START_TIME", "2008-09-20T12:25:40.104192"),
        )
    )
    rows, late = first.splitlines(), second.splitlines()
    both = "\n".join([*rows[:37], *late[4:16], *late[36:]])
    path = tmp_path / "two.oem"
    early = read_orbit(path, both, ISS_EPOCH, 2700.0)
    assert early.times[-1] == pytest.approx(45.0 * 60.0 + 40.104192)
    later = read_orbit(path, both, datetime(2008, 9, 20, 13, 26, tzinfo=UTC), 3000.0)
    assert later.times[0] == pytest.approx(-19.895808)
    with pytest.raises(InvalidValue, match=r"in one segment; found .* there may be a maneuver"):
        read_orbit(path, both, ISS_EPOCH, 5400.0)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"file": "none.oem"}, "file = 'none.oem': expected an existing file"),
        ({"file": "a.oem", "object": "MIR"}, "file = 'a.oem': object = 'MIR': expected ISS (ZARYA"),
    ],
)
def test_invalid_keys_are_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, keys: dict[str, Any], expected: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.oem").write_bytes(ISS.read_bytes())
    with pytest.raises(InvalidValue) as caught:
        OrbitFile(**keys).prepare_for_run(ISS_EPOCH, 5400.0)
    assert str(caught.value).startswith(expected)


def test_compressed_file_gives_same_orbit(tmp_path: Path) -> None:
    packed = tmp_path / "iss.oem.gz"
    packed.write_bytes(gzip.compress(ISS.read_bytes()))
    actual, expected = (
        OrbitFile(file=str(f)).prepare_for_run(ISS_EPOCH, 5400.0) for f in (packed, ISS)
    )
    assert (actual.times, actual.position) == (expected.times, expected.position)
    packed.write_bytes(packed.read_bytes()[:-100])
    with pytest.raises(InvalidValue, match=r"iss\.oem\.gz': "):
        OrbitFile(file=str(packed)).prepare_for_run(ISS_EPOCH, 5400.0)


def test_missing_package_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "oem", None)
    with pytest.raises(InvalidValue, match=r"needs the package oem: pip install 'mgeo-attitude\["):
        OrbitFile(file=str(ISS)).prepare_for_run(ISS_EPOCH, 5400.0)
