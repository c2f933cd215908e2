"""Telemetry tables: written tables read back, and invalid input raises."""

import dataclasses
import gzip

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import Scenario, StarTracker
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_calibration import Telemetry, TelemetryMapping, read_telemetry, simulate_telemetry
from mgeo_calibration.telemetry.mapping import GyroChannels, MountedChannels, SensorChannels
from scipy.spatial.transform import Rotation

from ..calibration.runs import PLAN, short

PAPER = short(Scenario.paper(), 300.0)


@pytest.fixture(scope="module")
def scenario():
    """The preset of the paper with a star tracker."""
    return dataclasses.replace(PAPER, sensors=(*PAPER.sensors, StarTracker()))


@pytest.fixture(scope="module")
def telemetry(scenario):
    return simulate_telemetry(scenario, PLAN, 1)


@pytest.fixture(scope="module")
def frame(telemetry):
    return telemetry.to_frame()


def assert_equal_telemetry(one, other):
    pd.testing.assert_frame_equal(one.to_frame(), other.to_frame(), check_exact=True)


def test_cells_between_samples_are_empty():
    """The Sun sensor reports every 4 s, the magnetometer every 6 s, and no sensor at the start."""
    sun, mag = PAPER.sensors
    sensors = (
        dataclasses.replace(sun, sample_interval=4.0),
        dataclasses.replace(mag, sample_interval=6.0),
    )
    of = dataclasses.replace(PAPER, sensors=sensors, step=2.0)
    telemetry = simulate_telemetry(of, PLAN, 1)
    for name, every in (("sun", 4.0), ("mag", 6.0)):
        seen = telemetry.times[np.isfinite(telemetry.sensors[name][:, 0])]
        np.testing.assert_array_equal(seen, np.arange(every, 301.0, every))
        assert telemetry.to_frame()[f"{name}_x"].isna().sum() == 151 - len(seen)
    assert_equal_telemetry(read_telemetry(telemetry.to_frame(), of), telemetry)


def test_rows_are_sorted_and_merged_by_time(scenario, frame, telemetry):
    parts = [
        frame[["time", *(c for c in frame if c.startswith(name))]]
        for name in ("gyro", "sun", "mag", "tracker")
    ]
    mixed = pd.concat([*parts, frame[40:90]]).sample(frac=1.0, random_state=3)
    assert_equal_telemetry(read_telemetry(mixed, scenario), telemetry)


def test_mapping_declares_names_units_and_mountings(scenario, telemetry, tmp_path):
    mounted = Rotation.from_euler("xyz", [30.0, -50.0, 120.0], degrees=True)  # Sensor to body.
    t, there = telemetry, slice(1, None)
    to_sensor = mounted.inv().apply
    table = {"UTC": t.times}
    table |= dict(zip(("p", "q", "r"), np.radians(to_sensor(t.gyro_deg_s)).T, strict=True))
    table |= dict(zip(("b1", "b2", "b3"), to_sensor(t.sensors["mag"]).T * 1e-9, strict=True))
    table |= dict(zip(("sun_x", "sun_y", "sun_z"), t.sensors["sun"].T, strict=True))
    q = np.full((301, 4), np.nan)
    # From GCRF to body, then to the axes of the mounted tracker.
    q[there] = (Rotation.from_quat(t.sensors["tracker"][there]) * mounted).as_quat()
    table |= dict(zip(("s1", "s2", "s3", "s4"), q.T, strict=True))
    table |= {"temperature_K": np.full(301, 293.0)}
    dcm = mounted.as_matrix().tolist()
    path = tmp_path / "columns.toml"
    path.write_text(
        f"""
time = "UTC"
[gyro]
columns = ["p", "q", "r"]
unit = "rad/s"
quaternion = {mounted.inv().as_quat().tolist()}
rotation = "sensor-to-body"
[[sensors]]
name = "mag"
columns = ["b1", "b2", "b3"]
unit = "T"
dcm = {dcm}
rotation = "sensor-to-body"
[[sensors]]
name = "tracker"
columns = ["s1", "s2", "s3", "s4"]
dcm = {dcm}
rotation = "sensor-to-body"
"""
    )
    found = read_telemetry(pd.DataFrame(table), scenario, TelemetryMapping.from_toml(path))
    np.testing.assert_allclose(found.gyro_deg_s[there], t.gyro_deg_s[there], rtol=0, atol=1e-14)
    np.testing.assert_allclose(found.sensors["mag"][there], t.sensors["mag"][there], rtol=1e-12)
    turn = Rotation.from_quat(found.sensors["tracker"][there]).inv() * Rotation.from_quat(
        t.sensors["tracker"][there]
    )
    assert turn.magnitude().max() < 1e-14


@pytest.mark.parametrize("name", ["sun", "tracker"])
def test_zero_vectors_and_quaternions_are_missing_samples(scenario, frame, name):
    own = frame.copy()
    own.loc[50:80, [c for c in frame if c.startswith(name)]] = 0.0
    found = read_telemetry(own, scenario).sensors[name]
    assert np.flatnonzero(np.isnan(found[:, 0])).tolist() == [0, *range(50, 81)]


def test_invalid_files_and_mappings_raise(frame, tmp_path):
    path = tmp_path / "t.csv"
    for content, message in (
        (b"", "expected CSV with a header"),
        (
            f"{frame.to_csv(index=False)}{',1' * 20}\n".encode(),
            "Expected 14 fields in line 303, saw 21",
        ),
        (gzip.compress(b"time,gyro_x")[:20], "expected CSV in UTF-8, uncompressed or gzip"),
    ):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=message):
            read_telemetry(path, PAPER)
    with pytest.raises(FileNotFoundError):
        read_telemetry(tmp_path / "none.csv", PAPER)
    own = frame[[c for c in frame if not c.startswith("tracker")]]
    for mapping, message in (
        ({"sensors": (SensorChannels(name="star"),)}, "unknown sensor.*known: 'sun', 'mag'"),
        ({"sensors": (SensorChannels(name="mag", unit="V"),)}, "mag.unit = 'V': unknown unit"),
        ({"gyro": GyroChannels(range_deg_s=0.45)}, "expected less than range_deg_s, 0.45 deg/s"),
        (
            {"gyro": GyroChannels(columns=("sun_x", "sun_y", "sun_z"))},
            "is declared, more than once",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            read_telemetry(own, PAPER, TelemetryMapping(**mapping))
    for wrong, message in (
        ({"quaternion": (1.0, 1.0, 0.0, 0.0)}, "unit length"),
        ({"dcm": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))}, "a rotation matrix"),
    ):
        with pytest.raises(InvalidValue, match=message):
            MountedChannels(**wrong)
    toml = tmp_path / "m.toml"
    toml.write_text("[gyro]\nunits = 'rad/s'\n")
    with pytest.raises(ValueError, match=r"m.toml: gyro.units: unknown key; did you mean 'unit'"):
        TelemetryMapping.from_toml(toml)


def test_invalid_arrays_raise():
    for wrong, message in (
        ({"times": [0.0, 0.0]}, "increasing order"),
        ({"gyro_deg_s": [[1.0, 2.0]]}, r"gyro: expected an array of shape \(2, 3\)"),
        ({"sensors": {"mag": [[1.0, np.nan, 2.0], [1.0, 2.0, 3.0]]}}, "all components or none"),
        ({"housekeeping": {"temp": [1.0, np.nan]}}, "temp: expected 2 finite numbers"),
        ({"sensors": {"mag": [[np.inf, 1.0, 2.0], [1.0, 2.0, 3.0]]}}, "finite"),
    ):
        good = {"times": [0.0, 1.0], "gyro_deg_s": np.zeros((2, 3))}
        with pytest.raises(ValueError, match=message):
            Telemetry(**good | wrong)
