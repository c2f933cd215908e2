"""Tables with declared conventions give the same telemetry as tables with the default
conventions.
"""

import dataclasses
from datetime import UTC, datetime

import numpy as np
import pytest
from astropy import coordinates
from astropy.time import Time, TimeDelta
from mgeo_attitude import Environment, Photodiode, Scenario, StarTracker
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_calibration import TelemetryMapping, read_telemetry, simulate_telemetry
from mgeo_calibration.telemetry.mapping import GyroChannels, MountedChannels, SensorChannels
from scipy.spatial.transform import Rotation

from ..calibration.runs import PLAN, short

PAPER = short(Scenario.paper(), 120.0)
TRACKED = dataclasses.replace(PAPER, sensors=(*PAPER.sensors, StarTracker()))
Q = ["tracker_q1", "tracker_q2", "tracker_q3", "tracker_q4"]
HALF = float(np.sqrt(0.5))


@pytest.fixture(scope="module")
def telemetry():
    return simulate_telemetry(TRACKED, PLAN, 1)


@pytest.fixture(scope="module")
def frame(telemetry):
    return telemetry.to_frame()


def declare_tracker(**declared):
    return TelemetryMapping(sensors=(SensorChannels(name="tracker", **declared),))


def compute_largest_angle(one, other):
    """Return the largest angle between two attitude histories [rad]."""
    there = np.isfinite(one[:, 0])
    turns = Rotation.from_quat(one[there]).inv() * Rotation.from_quat(other[there])
    return turns.magnitude().max()


@pytest.mark.parametrize(
    "declared",
    [
        {"rotation": "sensor-to-body", "quaternion": (0.0, 0.0, -HALF, HALF)},
        {"rotation": "body-to-sensor", "quaternion": (0.0, 0.0, HALF, HALF)},
        {"rotation": "sensor-to-body", "quaternion": (HALF, 0.0, 0.0, -HALF), "scalar": "first"},
        {"rotation": "sensor-to-body", "dcm": ((0, -1, 0), (1, 0, 0), (0, 0, 1))},
        {"rotation": "body-to-sensor", "dcm": ((0, 1, 0), (-1, 0, 0), (0, 0, 1))},
    ],
)
def test_mounting_of_rotated_sensor_gives_body_axes(frame, telemetry, declared):
    """Quaternions follow CCSDS: they rotate the axes of the first to the axes of the second."""
    mounted = frame.assign(mag_x=frame["mag_y"], mag_y=-frame["mag_x"])
    mapping = TelemetryMapping(sensors=(SensorChannels(name="mag", **declared),))
    found = read_telemetry(mounted, TRACKED, mapping).sensors["mag"]
    np.testing.assert_allclose(found, telemetry.sensors["mag"], rtol=1e-12, atol=1e-9)


def test_mounting_without_direction_raises():
    for mounting in ({"quaternion": (0.0, 0.0, 0.0, 1.0)}, {"dcm": np.eye(3).tolist()}):
        with pytest.raises(InvalidValue, match=r"rotation = None: expected 'sensor-to-body' or"):
            MountedChannels(**mounting)


def test_quaternions_with_scalar_first_or_inverse_direction(frame, telemetry):
    q = frame[Q].to_numpy()
    for rows, declared in (
        (np.roll(q, 1, axis=1), {"scalar": "first"}),
        (q * [-1, -1, -1, 1], {"attitude": "sensor-to-frame"}),
        (np.roll(q * [-1, -1, -1, 1], 1, axis=1),
         {"attitude": "sensor-to-frame", "scalar": "first"}),
    ):  # fmt: skip
        found = read_telemetry(frame.assign(**dict(zip(Q, rows.T, strict=True))), TRACKED,
                               declare_tracker(**declared))  # fmt: skip
        assert compute_largest_angle(found.sensors["tracker"], telemetry.sensors["tracker"]) < 1e-12


@pytest.mark.parametrize("name", ["TEME", "ITRF"])
def test_quaternions_from_other_frames_agree_with_astropy(frame, telemetry, name):
    when = Time(PAPER.epoch.replace(tzinfo=None)) + TimeDelta(telemetry.times, format="sec")
    there = {"TEME": coordinates.TEME, "ITRF": coordinates.ITRS}[name](obstime=when)
    axes = Rotation.from_quat(np.nan_to_num(telemetry.sensors["tracker"], nan=0.5)).as_matrix()
    in_frame = []
    for axis in np.moveaxis(axes, -1, 0):  # Body axes in GCRS.
        given = coordinates.CartesianRepresentation(*axis.T, unit="km")
        at = coordinates.GCRS(given, obstime=when).transform_to(there)
        in_frame.append(at.cartesian.xyz.to_value("km").T)
    rows = Rotation.from_matrix(np.stack(in_frame, axis=-1)).as_quat()
    rows[0] = np.nan
    own = frame.assign(**dict(zip(Q, rows.T, strict=True)))
    found = read_telemetry(own, TRACKED, declare_tracker(frame=name)).sensors["tracker"]
    assert (
        compute_largest_angle(found, telemetry.sensors["tracker"]) < 3e-5
    )  # ITRF depends on UT1 and polar motion.


def test_lvlh_quaternion_points_z_to_earth_and_x_forward(frame):
    noise = 1e-9 * np.random.default_rng(1).standard_normal((4, len(frame)))
    rows = np.array([[0.0], [0.0], [0.0], [1.0]]) + noise
    own = frame.assign(**dict(zip(Q, rows, strict=True)))
    found = read_telemetry(own, TRACKED, declare_tracker(frame="LVLH"))
    environment = Environment.from_times(TRACKED, found.times)
    to_body = Rotation.from_quat(found.sensors["tracker"]).inv()
    down = to_body.apply(-np.array(environment.position))
    np.testing.assert_allclose(down[:, :2], 0.0, atol=0.1)
    assert (down[:, 2] > 0.0).all()
    forward = to_body.apply(np.array(environment.velocity))
    assert (forward[:, 0] > 7e3).all()
    np.testing.assert_allclose(forward[:, 1], 0.0, atol=1e-3)


def test_attitude_keys_of_other_sensors_raise(frame):
    mapping = TelemetryMapping(sensors=(SensorChannels(name="mag", frame="LVLH"),))
    with pytest.raises(InvalidValue, match=r"mag\.frame = 'LVLH': .* not a star tracker"):
        read_telemetry(frame, TRACKED, mapping)


def test_counts_are_converted_by_scale_and_offset(frame, telemetry):
    """The magnetometer counts in 7 nT from 2048, the gyro in 1/8000 deg/s."""
    own = frame.copy()
    for axis, zero in zip("xyz", (2048, 2050, 2047), strict=True):
        own[f"mag_{axis}"] = np.round(frame[f"mag_{axis}"] / 7.0) + zero
        own[f"gyro_{axis}"] = np.round(8e3 * frame[f"gyro_{axis}"])
    offset = (-7.0 * 2048, -7.0 * 2050, -7.0 * 2047)
    mapping = TelemetryMapping(
        gyro=GyroChannels(scale=1.0 / 8e3),
        sensors=(SensorChannels(name="mag", scale=7.0, offset=offset),),
    )
    found = read_telemetry(own, TRACKED, mapping)
    np.testing.assert_allclose(found.sensors["mag"], telemetry.sensors["mag"], rtol=0, atol=3.51)
    np.testing.assert_allclose(found.gyro_deg_s, telemetry.gyro_deg_s, rtol=0, atol=0.51 / 8e3)
    np.testing.assert_allclose(found.find_quantization_steps("mag"), 7.0)
    wrong = TelemetryMapping(sensors=(SensorChannels(name="mag", scale=(1.0, 2.0)),))
    with pytest.raises(InvalidValue, match=r"mag\.scale = .*: expected one number, or 3 numbers"):
        read_telemetry(own, TRACKED, wrong)


def test_photodiode_angles_become_cosines():
    sensors = tuple(
        Photodiode(name, normal=normal)
        for name, normal in (("px", (1.0, 0.0, 0.0)), ("py", (0.0, 1.0, 0.0)))
    )
    scenario = dataclasses.replace(PAPER, sensors=(*PAPER.sensors, *sensors))
    telemetry = simulate_telemetry(scenario, PLAN, 1)
    frame = telemetry.to_frame()
    for name in ("px", "py"):
        frame[name] = np.degrees(np.arccos(np.clip(frame[name], -1.0, 1.0)))
    mapping = TelemetryMapping(
        sensors=tuple(SensorChannels(name=name, unit="deg") for name in ("px", "py"))
    )
    found = read_telemetry(frame, scenario, mapping)
    for name in ("px", "py"):
        expected = np.clip(telemetry.sensors[name], -1.0, 1.0)
        np.testing.assert_allclose(found.sensors[name], expected, rtol=0, atol=1e-9)


def count_times(times, start, scale, unit):
    """Return times as numbers that count from a date in a time scale, computed by astropy."""
    utc = Time(PAPER.epoch.replace(tzinfo=None), scale="utc") + TimeDelta(times, format="sec")
    count = (utc - start).to_value("s") if scale != "utc" else utc.unix - start.unix
    return count / unit


@pytest.mark.parametrize(
    ("start", "scale", "unit", "declared"),
    [
        (Time("1970-01-01"), "utc", 1e-3, {"time_epoch": "Unix", "time_unit": "ms"}),
        (Time("1980-01-06"), "tai", 1.0, {"time_epoch": "GPS"}),
        (Time("2000-01-01T12:00:00", scale="tt"), "tai", 1.0, {"time_epoch": "J2000"}),
        (Time("2000-01-01"), "utc", 86400.0, {"time_epoch": "2000-01-01", "time_unit": "d"}),
        (Time("2000-01-01", scale="tai"), "tai", 1.0,
         {"time_epoch": "2000-01-01", "time_system": "TAI"}),
        (Time("2015-03-04T05:06:07"), "tai", 60.0,
         {"time_epoch": datetime(2015, 3, 4, 5, 6, 7, tzinfo=UTC), "time_system": "TT",
          "time_unit": "min"}),
    ],
)  # fmt: skip
def test_times_count_from_declared_epoch(frame, telemetry, start, scale, unit, declared):
    own = frame.assign(time=count_times(telemetry.times, start, scale, unit))
    found = read_telemetry(own, TRACKED, TelemetryMapping(**declared))
    np.testing.assert_allclose(found.times, telemetry.times, rtol=0, atol=2e-6)


@pytest.mark.parametrize("scale", ["GPS", "TAI", "TT"])
def test_time_stamps_in_other_time_scales(frame, telemetry, scale):
    ahead = {"GPS": 18.0, "TAI": 37.0, "TT": 69.184}[scale]  # Offset from UTC since 2017.
    stamps = Time(PAPER.epoch.replace(tzinfo=None)) + TimeDelta(
        telemetry.times + ahead, format="sec"
    )
    own = frame.assign(time=stamps.isot)
    found = read_telemetry(own, TRACKED, TelemetryMapping(time_system=scale))
    np.testing.assert_allclose(found.times, telemetry.times, rtol=0, atol=2e-6)


def test_second_time_column_is_added(frame, telemetry):
    gps = count_times(telemetry.times + 0.25, Time("1980-01-06"), "tai", 1.0)
    week, of_week = np.divmod(np.round(gps, 6), 604800.0)
    for own, declared in (
        ({"sec": np.floor(gps), "msec": np.round(1e3 * (gps % 1.0))},
         {"time": "sec", "time_fraction": "msec"}),
        ({"week": week, "tow": of_week},
         {"time": "week", "time_unit": "week", "time_fraction": "tow", "time_fraction_unit": "s"}),
    ):  # fmt: skip
        table = frame.drop(columns="time").assign(**own)
        found = read_telemetry(table, TRACKED, TelemetryMapping(time_epoch="GPS", **declared))
        np.testing.assert_allclose(found.times, telemetry.times + 0.25, rtol=0, atol=2e-6)


def test_toml_dates_declare_epoch(tmp_path):
    path = tmp_path / "columns.toml"
    for text, year in (("2000-01-01", 2000), ("2020-01-01T00:00:00Z", 2020)):
        path.write_text(f"time_epoch = {text}\n")
        start = TelemetryMapping.from_toml(path).count_start
        assert start == datetime(year, 1, 1, tzinfo=UTC)
