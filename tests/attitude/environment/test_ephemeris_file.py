"""Ephemerides in files: of other tools, in their frames and time systems, and bad ones."""

from __future__ import annotations

import dataclasses
import gzip
import hashlib
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path
from typing import Any

import brahe
import erfa
import numpy as np
import pytest
from brahe.ccsds import OEM
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.element_set import TLEOrbit, gcrs_of
from mgeo_attitude.environment.frames import rotate
from mgeo_attitude.environment.times import instants
from mgeo_attitude.scenario import EphemerisOrbit, OrbitFile
from mgeo_attitude.settings.errors import InvalidValue

from mgeo.plugins.problems import load_problem
from mgeo.store.scenario_file import read_scenario

from ..scenario.test_orbit import ISS_1, ISS_2

ISS = Path(__file__).parents[1] / "reference" / "iss-2008-09-20.oem"
ISS_EPOCH = datetime(2008, 9, 20, 12, 40, tzinfo=UTC)
ISS_SET = TLEOrbit(line1=ISS_1, line2=ISS_2)
SCENARIO = dataclasses.replace(Scenario.paper(), step=10.0, duration=6000.0)
TIMES = np.arange(-300.0, 6301.0, 60.0)

Frame = Callable[[brahe.Epoch, np.ndarray], np.ndarray]
FRAMES: dict[str, Frame] = {
    "GCRF": lambda at, state: state,
    "EME2000": lambda at, state: brahe.state_gcrf_to_eme2000(state),
    "ITRF2000": brahe.state_gcrf_to_itrf,
}


def states(frame: str, start: datetime) -> list[tuple[brahe.Epoch, np.ndarray]]:
    """Samples of the two-body orbit in another frame, transformed by brahe."""
    brahe.set_global_eop_provider(brahe.StaticEOPProvider.from_zero())
    day = start.year, start.month, start.day
    epoch = brahe.Epoch.from_datetime(
        *day, start.hour, start.minute, start.second, 0.0, brahe.TimeSystem.UTC
    )
    instants = [epoch + t for t in TIMES.tolist()]
    gcrs = np.hstack(SCENARIO.orbit.propagate(start, TIMES))
    return [(at, FRAMES[frame](at, state)) for at, state in zip(instants, gcrs, strict=True)]


def message(frame: str, system: str, interpolation: str, start: datetime = SCENARIO.epoch) -> str:
    """Their orbit ephemeris message, written by brahe to the millimeter."""
    found = states(frame, start)
    oem = OEM(originator="SOMEBODY ELSE")
    oem.add_segment(
        object_name="PAPER", object_id="2018-001A", center_name="EARTH", ref_frame=frame,
        time_system=system, start_time=found[0][0], stop_time=found[-1][0],
        interpolation=interpolation, interpolation_degree=7,
    )  # fmt: skip
    for at, state in found:
        oem.segments[0].add_state(
            epoch=at, position=state[:3].tolist(), velocity=state[3:].tolist()
        )
    return str(oem.to_string("KVN"))


def table(frame: str, unit: str) -> str:
    """Their positions and velocities as CSV, to the last digit."""
    names = [f"{axis}_{unit}" for axis in "xyz"] + [f"v{axis}_{unit}_s" for axis in "xyz"]
    found = np.array([state for _, state in states(frame, SCENARIO.epoch)])
    rows = np.column_stack([TIMES, found / {"m": 1.0, "km": 1e3}[unit]]).tolist()
    return "\n".join([",".join(["time_s", *names]), *(",".join(map(repr, row)) for row in rows)])


def read(tmp_path: Path, name: str, text: str, **keys: Any) -> EphemerisOrbit:
    """The orbit of a scenario file beside the file of this name."""
    (tmp_path / name).write_text(text)
    entry = {"propagator": "ephemeris-file", "file": name} | keys
    scenario = Scenario.from_dict(SCENARIO.to_dict() | {"orbit": entry}, tmp_path)
    assert isinstance(scenario.orbit, EphemerisOrbit)
    return scenario.orbit


def miss(orbit: EphemerisOrbit) -> tuple[float, float]:
    """How far from the two-body orbit it is at most, in m and in m/s."""
    found = orbit.propagate(SCENARIO.epoch, SCENARIO.times)
    expected = SCENARIO.orbit.propagate(SCENARIO.epoch, SCENARIO.times)
    apart = [np.linalg.norm(a - b, axis=1).max() for a, b in zip(found, expected, strict=True)]
    return float(apart[0]), float(apart[1])


@pytest.mark.parametrize("interpolation", ["HERMITE", "LAGRANGE"])
@pytest.mark.parametrize(
    ("frame", "system"),
    [("GCRF", "UTC"), ("EME2000", "TT"), ("ITRF2000", "GPS"), ("ITRF2000", "TAI")],
)
def test_messages_of_another_tool(
    tmp_path: Path, frame: str, system: str, interpolation: str
) -> None:
    """Its millimeters are half a millimeter of rounding on each axis, sqrt(3)/2 in all."""
    orbit = read(tmp_path, "paper.oem", message(frame, system, interpolation))
    position, velocity = miss(orbit)
    assert position < 1.5e-3
    assert velocity < 1e-4
    assert bool(orbit.velocity) == (interpolation == "HERMITE")


@pytest.mark.parametrize(
    ("frame", "unit", "meters"),
    [("GCRF", "m", 1e-6), ("EME2000", "km", 1e-4), ("ITRF2000", "m", 1e-3)],
)
def test_tables(tmp_path: Path, frame: str, unit: str, meters: float) -> None:
    text = "# of another tool\n\n" + table(frame, unit)
    position, velocity = miss(read(tmp_path, "paper.csv", text, frame=frame))
    assert position < meters
    assert velocity < 1e-5


def test_a_message_through_a_leap_second(tmp_path: Path) -> None:
    start = datetime(2016, 12, 31, 23, 30, tzinfo=UTC)
    (tmp_path / "leap.oem").write_text(message("GCRF", "UTC", "HERMITE", start))
    assert "2016-12-31T23:59:00" in (tmp_path / "leap.oem").read_text()
    assert "2017-01-01T00:00:59" in (tmp_path / "leap.oem").read_text()  # 120 s later
    orbit = OrbitFile(file=str(tmp_path / "leap.oem")).for_run(start, SCENARIO.duration)
    np.testing.assert_allclose(np.diff(orbit.times), 60.0, rtol=0.0, atol=1e-9)
    found, _ = orbit.propagate(start, SCENARIO.times)
    expected, _ = SCENARIO.orbit.propagate(start, SCENARIO.times)
    assert np.linalg.norm(found - expected, axis=1).max() < 1.5e-3


def test_a_table_of_positions_at_utc_times(tmp_path: Path) -> None:
    at = np.arange(-60.0, 200.0, 30.0)
    position, _ = SCENARIO.orbit.propagate(SCENARIO.epoch, at)
    stamps = [(SCENARIO.epoch + timedelta(seconds=t)).isoformat() for t in at.tolist()]
    rows = [",".join([t, *map(repr, r)]) for t, r in zip(stamps, position.tolist(), strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["time_utc,x_m,y_m,z_m", *rows]))
    orbit = OrbitFile(file=str(tmp_path / "a.csv"), frame="ICRF").for_run(SCENARIO.epoch, 120.0)
    found, _ = orbit.propagate(SCENARIO.epoch, np.array([0.0, 45.0, 120.0]))
    expected, _ = SCENARIO.orbit.propagate(SCENARIO.epoch, np.array([0.0, 45.0, 120.0]))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-4)


def test_the_message_in_teme_against_sgp4() -> None:
    """SGP4 by the package sgp4 here, by beyond there, whose states are 180 s apart."""
    orbit = OrbitFile(file=str(ISS)).for_run(ISS_EPOCH, 5400.0)
    times = np.arange(0.0, 5401.0, 10.0)
    expected, motion = gcrs_of(
        TLEOrbit(line1=ISS_1, line2=ISS_2).satellite(), instants(ISS_EPOCH, times)
    )
    found, velocity = orbit.propagate(ISS_EPOCH, times)
    apart = np.linalg.norm(found - expected, axis=1)
    assert apart.max() < 0.3  # 0.22 m at the samples themselves
    assert np.linalg.norm(velocity - motion, axis=1).max() < 0.5  # of which SGP4's own are 0.4
    assert (orbit.degree, orbit.velocity) == (8, ())  # as the message says
    assert orbit.period == pytest.approx(86400.0 / 15.72125391, rel=2e-3)


def test_an_interpolation_of_ones_own() -> None:
    own = OrbitFile(file=str(ISS), interpolation="hermite", degree=5).for_run(ISS_EPOCH, 5400.0)
    assert own.degree == 5
    times = np.arange(0.0, 5401.0, 10.0)
    expected, _ = gcrs_of(
        TLEOrbit(line1=ISS_1, line2=ISS_2).satellite(), instants(ISS_EPOCH, times)
    )
    assert 0.3 < np.linalg.norm(own.propagate(ISS_EPOCH, times)[0] - expected, axis=1).max() < 1.5


def test_what_the_run_does_not_need_is_left_out_and_changes_nothing() -> None:
    file = OrbitFile(file=str(ISS), interpolation="hermite", degree=7)
    whole, part = file.for_run(ISS_EPOCH, 5400.0), file.for_run(ISS_EPOCH, 1800.0)
    assert len(part.times) == 10 + 2 + 2 * 4 < len(whole.times)
    times = np.arange(0.0, 1801.0, 7.0)
    found, expected = (orbit.propagate(ISS_EPOCH, times)[0] for orbit in (part, whole))
    # the nutation is linear in time over the samples, see `gcrs_to_itrs`
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=2e-3)


def test_the_scenario_keeps_the_samples_and_not_the_file(tmp_path: Path) -> None:
    (tmp_path / "orbits").mkdir()
    copy = tmp_path / "orbits" / "iss.oem"
    copy.write_bytes(ISS.read_bytes())
    path = tmp_path / "mine.toml"
    path.write_text(
        'preset = "cubesat_6u"\nepoch = 2008-09-20T12:40:00Z\nduration = 5400.0\n'
        '[orbit]\npropagator = "ephemeris-file"\nfile = "orbits/iss.oem"\n'
    )
    scenario = Scenario.from_toml(path)
    copy.write_text("something else")
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    assert Scenario.from_dict(scenario.to_dict()) == scenario
    assert isinstance(scenario.orbit, EphemerisOrbit)
    digest = hashlib.sha256(ISS.read_bytes()).hexdigest()
    assert scenario.orbit.source == f"iss.oem, ISS (ZARYA) 1998-067A, SHA-256 {digest}"
    environment = Environment.from_scenario(scenario)
    height = np.linalg.norm(environment.position, axis=1) - 6378136.3
    assert 330e3 < height.min() < height.max() < 380e3


def test_a_run_is_of_the_samples_wherever_it_was_started(tmp_path: Path) -> None:
    """Options as `mgeo solve` and `mgeo study` read them, with the file beside the scenario's."""
    (tmp_path / "iss.oem").write_bytes(ISS.read_bytes())
    path = tmp_path / "mine.toml"
    path.write_text(
        'preset = "cubesat_6u"\nepoch = 2008-09-20T12:40:00Z\nduration = 5400.0\n'
        '[orbit]\npropagator = "ephemeris-file"\nfile = "iss.oem"\n'
    )
    options = read_scenario("attitude", str(path))
    (tmp_path / "iss.oem").unlink()
    problem = load_problem("attitude", options)
    assert problem.options() == options
    assert len(options["orbit"]["times"]) == len(options["orbit"]["position"])
    with pytest.raises(ValueError, match=r"mine\.toml: orbit\.file = .*iss\.oem': expected a file"):
        read_scenario("attitude", str(path))
    path.write_text('preset = "paper"')
    assert read_scenario("attitude", str(path)) == {"preset": "paper"}


def changed(text: str, *pairs: tuple[str, str]) -> str:
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def swapped(text: str, k: int) -> str:
    """Two neighboring lines, counted from the end, in the other order."""
    lines = text.rstrip().splitlines()
    lines[-k], lines[-k - 1] = lines[-k - 1], lines[-k]
    return "\n".join(lines)


def without(text: str, k: int, count: int) -> str:
    """Without some lines, counted from the end."""
    lines = text.rstrip().splitlines()
    end = len(lines) - k
    return "\n".join(lines[: end - count] + lines[end:])


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda t: "", "expected element sets (OMM, or two lines), or a message in KVN, with C"),
        (lambda t: "<xml/>", "expected element sets (OMM, or two lines), or a message in KVN, "),
        (lambda t: t.replace("META_STOP", ""), "line 5: META_START: expected META_STOP and data"),
        (lambda t: t[: t.index("2008-09-20T12:28")], "expected samples for the whole run, from "
         "2008-09-20T12:40:00.000Z to 2008-09-20T14:10:00.000Z, in one segment, or in some "
         "that share an instant; found from 2008-09-20T12:25:40.104Z to 2008-09-20T12:25:40.104Z"),
        (lambda t: changed(t, ("= EARTH", "= MARS")), "CENTER_NAME = 'MARS': expected EARTH"),
        (lambda t: changed(t, ("REF_FRAME ", "FRAME ")), "REF_FRAME = '': expected one"),
        (lambda t: changed(t, ("= TEME", "= GTOD")), "reference frame 'GTOD': expected GCRF (ICRF"),
        (lambda t: changed(t, ("= UTC", "= TDB")), "time system 'TDB': expected UTC, TAI, TT, GPS"),
        (lambda t: changed(t, ("= LAGRANGE", "= SPLINE")), "INTERPOLATION = 'SPLINE': expected "
         "HERMITE or LAGRANGE or LINEAR"),
        (lambda t: changed(t, ("DEGREE = 8", "DEGREE = x")), "INTERPOLATION_DEGREE = 'x': expected "
         "an integer"),
        (lambda t: changed(t, ("DEGREE = 8", "DEGREE = 20")), "degree = 20: expected an integer"),
        (lambda t: changed(t, ("LAGRANGE", "LINEAR"), ("DEGREE = 8", "DEGREE = 1")),
         "it is wrong, samples are too far apart"),
        (lambda t: changed(t, ("META_STOP", "REF_FRAME_EPOCH = 2000-01-01\nMETA_STOP")),
         "time '2000-01-01': expected one such as 2018"),
        (lambda t: changed(t, ("META_STOP", "REF_FRAME_EPOCH = 2000-01-01T12:00:00\nMETA_STOP"),
                           ("= TEME", "= ITRF")),
         "REF_FRAME_EPOCH: expected none for a frame that turns with the Earth"),
        (lambda t: changed(t, ("= TEME", "= TEMEOFEPOCH")),
         "REF_FRAME = TEMEOFEPOCH: expected its REF_FRAME_EPOCH, too"),
        (lambda t: changed(t, ("META_STOP", "USEABLE_STOP_TIME = 2008-09-20T14:00:00\nMETA_STOP")),
         "to 2008-09-20T14:00:00.000Z"),
        (lambda t: swapped(t, 6), "T14:07:40.104192 after 2008-09-20T14:10:40.104192: expected "
         "times in order"),
        (lambda t: without(t, 10, 20), "expected samples in this gap of 3780 s"),
        (lambda t: without(t, 0, 6), "12:25:40.104Z to 2008-09-20T14:07:40.104Z"),
        (lambda t: changed(t, ("T12:46:40", "T12:61:40")), "time '2008-09-20T12:61:40.104192': e"),
        (lambda t: changed(t, ("2699.420566", "2699.x")), "line 24: '2699.x 6161.301305 155.26019"),
        (lambda t: changed(t, (" 2699.420566", "")), "line 24: '6161.301305 155.260192 -4.316915"),
        (lambda t: changed(t, ("2699.420566", "inf")), "expected finite numbers"),
        (lambda t: changed(t, ("2699.420566", "26.99")), "expected a position above ground"),
        (lambda t: changed(t, ("2699.420566", "2729.42")), "within 1000 m of what those around"),
    ],
)  # fmt: skip
def test_messages_that_are_refused(
    tmp_path: Path, change: Callable[[str], str], expected: str
) -> None:
    path = tmp_path / "iss.oem"
    path.write_text(change(ISS.read_text()))
    with pytest.raises(InvalidValue) as caught:
        OrbitFile(file=str(path)).for_run(ISS_EPOCH, 5400.0)
    assert str(caught.value).startswith(f"file = '{path}': ")
    assert expected in str(caught.value)


def test_segments_that_share_an_instant(tmp_path: Path) -> None:
    """A run may be in one of them, or go on from the first to the second."""
    lines = ISS.read_text().splitlines()
    head, rows = lines[4:16], lines[16:]
    path = tmp_path / "two.oem"
    path.write_text("\n".join([*lines[:4], *head, *rows[:21], *head, *rows[20:]]))
    early, late = ISS_EPOCH, datetime(2008, 9, 20, 13, 30, tzinfo=UTC)
    file = OrbitFile(file=str(path))
    meeting = pytest.approx(45.0 * 60.0 + 40.104192)
    assert file.for_run(early, 2700.0).times[-1] == meeting
    assert file.for_run(late, 3000.0).times[0] == pytest.approx(-4.0 * 60.0 - 19.895808)
    whole = file.for_run(early, 5400.0)
    assert [t for t, after in pairwise(whole.times) if t == after] == [meeting]
    with pytest.raises(InvalidValue, match=r"; found from .*:25:40.104Z to .* and from "):
        file.for_run(early, 9000.0)


def test_two_objects_that_both_cover_the_run(tmp_path: Path) -> None:
    head, _, rest = ISS.read_text().partition("META_START")
    path = tmp_path / "two.oem"
    path.write_text(f"{head}META_START{rest}META_START{rest.replace('ISS (ZARYA)', 'MIR')}")
    with pytest.raises(InvalidValue, match=r"2 objects: expected object, a name, of ISS .* MIR "):
        OrbitFile(file=str(path)).for_run(ISS_EPOCH, 5400.0)
    for wanted in ("MIR", "mir 1998-067A"):
        orbit = OrbitFile(file=str(path), object=wanted).for_run(ISS_EPOCH, 5400.0)
        assert orbit.source is not None
        assert orbit.source.startswith("two.oem, MIR 1998-067A, SHA-256 ")


@pytest.mark.parametrize(
    ("text", "keys", "expected"),
    [
        ("", {}, "expected a header, which names the columns, and rows below it"),
        ("time_s,x_m,y_m,z\n0", {}, "columns 'time_s,x_m,y_m,z': expected time_utc or time_s, with "
         "x_m,y_m,z_m or x_km,y_km,z_km, and perhaps vx_m_s,vy_m_s,vz_m_s or vx_km_s,vy_km_s,vz_k"),
        ("time_s,x_m,y_m,z_m,z_m\n0", {}, "columns 'time_s,x_m,y_m,z_m,z_m': expected"),
        ("time_s,x_m,y_m,z_m,x_km,y_km,z_km\n0", {}, "columns 'time_s,x_m,y_m,z_m,x_km,"),
        ("time_s,x_m,y_m,z_m\n0,7e6,0\n", {}, "line 2: 3 cells: expected 4, as its header"),
        ("time_s,x_m,y_m,z_m\n0,7e6,0,a\n", {}, "line 2: '7e6 0 a': expected finite numbers"),
        ("time_s,x_m,y_m,z_m\nnan,7e6,0,0\n", {}, "line 2: 'nan': expected finite numbers"),
        ("time_s,x_m,y_m,z_m\n", {}, "expected a header, which names the columns, and rows"),
        ("time_s,x_m,y_m,z_m\n0,7e6,0,0", {}, "expected samples for the whole run"),
        ("time_s,x_m,y_m,z_m\n0,7e6,0,0\n0,7e6,0,0\n0,7e6,0,0", {},
         "time 0 after 0: expected times in order, the same at most twice"),
        ("time_s,x_m,y_m,z_m\n-1,7e6,0,0\n9999,7e6,0,0", {"interpolation": "hermite"},
         "interpolation = 'hermite': expected a table with velocities"),
    ],
)  # fmt: skip
def test_tables_that_are_refused(
    tmp_path: Path, text: str, keys: dict[str, Any], expected: str
) -> None:
    with pytest.raises(InvalidValue) as caught:
        read(tmp_path, "a.csv", text, frame="GCRF", **keys)
    assert str(caught.value).startswith(f"orbit.file = '{tmp_path / 'a.csv'}': ")
    assert expected in str(caught.value)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"file": "none.oem"}, "file = 'none.oem': expected a file, and there is none"),
        ({"file": "."}, "file = '.': expected a file, and there is none"),
        ({"file": "a.csv"}, "frame = '': reference frame '': expected GCRF (ICRF, GCRS), EME2000"),
        (
            {"file": "a.csv", "frame": "GCRF", "object": "ISS"},
            "object = 'ISS': expected none: only",
        ),
        ({"file": "a.oem", "frame": "ITRF"}, "frame = 'ITRF': expected none: only a table .csv"),
        ({"file": "a.tle", "degree": 3}, "degree = 3: expected none: only an ephemeris needs one"),
        ({"file": "a.oem", "degree": 0}, "degree = 0: expected nothing or an integer in [1, 15]"),
        (
            {"file": "a.oem", "interpolation": "cubic"},
            "interpolation = 'cubic': expected nothing or",
        ),
    ],
)
def test_files_that_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, keys: dict[str, Any], expected: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in (("a.csv", ""), ("a.oem", ISS.read_text()), ("a.tle", f"{ISS_1}\n{ISS_2}")):
        Path(name).write_text(text)
    with pytest.raises(InvalidValue) as caught:
        OrbitFile(**keys).for_run(ISS_EPOCH, 5400.0)
    assert str(caught.value).startswith(expected)


def test_a_file_that_is_too_large(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mgeo_attitude.environment.orbit._MOST_BYTES", 100)
    packed = tmp_path / "iss.oem.gz"
    packed.write_bytes(gzip.compress(bytes(1000)))
    assert packed.stat().st_size < 100
    for file in (ISS, packed):
        with pytest.raises(InvalidValue, match="expected at most 100 bytes, and there are more"):
            OrbitFile(file=str(file)).for_run(ISS_EPOCH, 5400.0)


def test_an_ephemeris_that_speaks_of_elements(tmp_path: Path) -> None:
    path = tmp_path / "iss.oem"
    text = ISS.read_text().replace("META_STOP", "META_STOP\nCOMMENT MEAN_MOTION = 15.7", 1)
    path.write_text(text)
    assert isinstance(OrbitFile(file=str(path)).for_run(ISS_EPOCH, 5400.0), EphemerisOrbit)


def test_a_compressed_file_is_the_same(tmp_path: Path) -> None:
    packed = tmp_path / "iss.oem.gz"
    packed.write_bytes(gzip.compress(ISS.read_bytes()))
    found, expected = (OrbitFile(file=str(f)).for_run(ISS_EPOCH, 5400.0) for f in (packed, ISS))
    assert (found.times, found.position) == (expected.times, expected.position)
    packed.write_bytes(packed.read_bytes()[:-100])
    with pytest.raises(InvalidValue, match=r"expected a sound \.gz: "):
        OrbitFile(file=str(packed)).for_run(ISS_EPOCH, 5400.0)


def test_axes_of_date_and_of_one_instant(tmp_path: Path) -> None:
    """TOD as by the sidereal angle from ITRF; what is of one instant differs by precession."""
    start = SCENARIO.epoch
    at = instants(start, TIMES)
    itrf = np.array([state for _, state in states("ITRF2000", start)])[:, :3]
    angle = erfa.gst06a(at.midnight, at.ut, at.midnight, at.tt)
    tod = rotate(np.swapaxes(erfa.rz(angle, np.eye(3)), -1, -2), itrf)
    gcrs, _ = SCENARIO.orbit.propagate(start, TIMES)
    j2000 = rotate(np.broadcast_to(erfa.pnm06a(2451545.0, 0.0), (len(gcrs), 3, 3)), gcrs)
    for frame, positions, instant in (
        ("TOD", tod, ""),
        ("TOD", j2000, "REF_FRAME_EPOCH = 2000-01-01T11:58:55.816\n"),
        ("GCRF", gcrs, "REF_FRAME_EPOCH = 2000-01-01T12:00:00\n"),  # it has no other
    ):
        lines = [
            " ".join([(start + timedelta(seconds=t)).strftime("%Y-%m-%dT%H:%M:%S"), *map(repr, r)])
            + " 0 0 0"
            for t, r in zip(TIMES.tolist(), (1e-3 * positions).tolist(), strict=True)
        ]
        text = (
            "CCSDS_OEM_VERS = 2.0\nMETA_START\nOBJECT_NAME = A\nOBJECT_ID = B\n"
            f"CENTER_NAME = EARTH\nREF_FRAME = {frame}\n{instant}TIME_SYSTEM = UTC\n"
            "INTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 7\nMETA_STOP\n"
        )
        found = read(tmp_path, "a.oem", text + "\n".join(lines))
        assert miss(found)[0] < 2e-3  # the chord of the nutation is 2e-10 rad from its arc
