"""Text formats of ground systems give the same telemetry as the default format."""

import gzip
from datetime import UTC, datetime, timedelta

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_calibration import TelemetryMapping, read_telemetry, simulate_telemetry
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.telemetry.mapping import GyroChannels, SensorChannels

from ..calibration.runs import PLAN, short

PAPER = short(Scenario.paper(), 120.0)


@pytest.fixture(scope="module")
def telemetry():
    return simulate_telemetry(PAPER, PLAN, 1)


@pytest.fixture(scope="module")
def frame(telemetry):
    return telemetry.to_frame()


def use_decimal_commas(text):
    return text.replace(",", ";").replace(".", ",")


def add_unit_row(text, units="s,deg/s,deg/s,deg/s,-,-,-,nT,nT,nT"):
    header, _, rest = text.partition("\n")
    return f"{header}\n{units}\n{rest}"


WRITERS = {
    "semicolons": lambda t: t.replace(",", ";").encode(),
    "decimal commas": lambda t: use_decimal_commas(t).encode(),
    "columns apart by spaces": lambda t: "\n".join(
        "  ".join(cell or "nan" for cell in line.split(",")) for line in t.splitlines()
    ).encode(),
    "gzip": lambda t: gzip.compress(t.encode()),
    "UTF-8 with a mark": lambda t: t.encode("utf-8-sig"),
    "comments": lambda t: f"# from a ground station\n{t}# the end\n".encode(),
    "a row of units": lambda t: add_unit_row(t).encode(),
    "units in brackets": lambda t: t.replace("mag_x", "mag_x [nT]", 1).replace("time", "time (s)")
    .replace("mag_y", "Mag_Y [nT]", 1).replace("mag_z", "mag_z[nT]", 1).encode(),
    "other columns": lambda t: "\n".join(
        f"{line},{more}" for line, more in zip(
            t.splitlines(), ["wheel_x,mag2_x,mode", *["1.5,7,safe"] * 200], strict=False
        )
    ).encode(),
}  # fmt: skip


@pytest.mark.parametrize("name", WRITERS)
def test_text_format_preserves_telemetry(telemetry, frame, tmp_path, name):
    path = tmp_path / "t.txt"
    path.write_bytes(WRITERS[name](frame.to_csv(index=False)))
    found = read_telemetry(path, PAPER)
    pd.testing.assert_frame_equal(found.to_frame(), telemetry.to_frame(), check_exact=True)


def test_unit_row_applies_unless_mapping_declares_unit(telemetry, frame, tmp_path):
    own, path = frame.copy(), tmp_path / "t.csv"
    own[["mag_x", "mag_y", "mag_z"]] *= 1e-3
    own[["gyro_x", "gyro_y", "gyro_z"]] = np.radians(own[["gyro_x", "gyro_y", "gyro_z"]])
    text = own.to_csv(index=False)
    path.write_bytes(add_unit_row(text, "s,rad/s,rad/s,rad/s,-,-,-,µT,µT,µT").encode())
    found = read_telemetry(path, PAPER)
    np.testing.assert_allclose(found.sensors["mag"], telemetry.sensors["mag"], rtol=1e-14)
    np.testing.assert_allclose(found.gyro_deg_s, telemetry.gyro_deg_s, rtol=1e-14)
    for units, message in (
        ("s,rad/s,rad/s,rad/s,-,-,-,V,V,V", "mag.unit = 'V': unknown unit"),
        ("s,rad/s,deg/s,rad/s,-,-,-,uT,uT,uT", "gyro: columns in deg/s, rad/s: expected one unit"),
    ):
        path.write_text(add_unit_row(text, units))
        with pytest.raises(ValueError, match=message):
            read_telemetry(path, PAPER)
    path.write_text(add_unit_row(text, "s,rad/s,rad/s,rad/s,-,-,-,V,V,V"))
    mapping = TelemetryMapping(sensors=(SensorChannels(name="mag", unit="uT"),))
    same = read_telemetry(path, PAPER, mapping)
    np.testing.assert_array_equal(same.sensors["mag"], found.sensors["mag"])


def format_stamps(times, form):
    return [(PAPER.epoch + timedelta(seconds=t)).strftime(form) for t in times]


@pytest.mark.parametrize(
    ("times", "mapping"),
    [
        (lambda t: format_stamps(t, "%Y-%jT%H:%M:%S.%fZ"), {}),
        (lambda t: format_stamps(t - 3600.0, "%Y-%m-%dT%H:%M:%S-01:00"), {}),
        (lambda t: np.int64(1000) * (t + PAPER.epoch.timestamp()).astype(int),
         {"time_epoch": "Unix", "time_unit": "ms"}),
        (lambda t: pd.to_datetime(format_stamps(t, "%Y-%m-%d %H:%M:%S")), {}),
    ],
)  # fmt: skip
def test_time_formats_are_equivalent(telemetry, frame, tmp_path, times, mapping):
    own = frame.assign(time=times(frame["time"].to_numpy()))
    own.to_csv(tmp_path / "t.csv", index=False)
    for source in (own, tmp_path / "t.csv"):
        found = read_telemetry(source, PAPER, TelemetryMapping(**mapping))
        np.testing.assert_array_equal(found.times, telemetry.times)


def test_leap_second_is_second_60(frame):
    of = short(Scenario.paper(), 60.0, epoch=datetime(2016, 12, 31, 23, 59, 50, tzinfo=UTC))
    own = frame.iloc[1:5].assign(
        time=[
            "2016-12-31T23:59:59Z",
            "2016-12-31 23:59:60.5",
            "2017-001T00:00:00",
            "2017-01-01T00:00:01Z",
        ]
    )
    assert read_telemetry(own, of).times.tolist() == [9.0, 10.5, 11.0, 12.0]
    unix = frame.iloc[1:3].assign(time=[1483228799.0, 1483228801.0])
    found = read_telemetry(unix, of, TelemetryMapping(time_epoch="Unix"))
    assert found.times.tolist() == [9.0, 12.0]


def test_minus_before_column_mirrors_axis(telemetry, frame):
    own = frame.assign(mag_y=-frame["mag_y"])
    mapping = TelemetryMapping(
        sensors=(SensorChannels(name="mag", columns=("mag_x", "-mag_y", "mag_z")),)
    )
    found = read_telemetry(own, PAPER, mapping)
    np.testing.assert_array_equal(found.sensors["mag"], telemetry.sensors["mag"])


def test_reference_axes_determine_rate_without_gyro(telemetry, frame):
    own = frame.drop(columns=["gyro_x", "gyro_y", "gyro_z"])
    with pytest.raises(ValueError, match="missing columns gyro_x"):
        read_telemetry(own, PAPER)
    at_rest = read_telemetry(
        own, PAPER, TelemetryMapping(gyro=GyroChannels(reference_axes="inertial"))
    )
    assert not at_rest.gyro_deg_s.any()
    # Expected: rotation of LVLH between consecutive samples, from orbit positions.
    turned = ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    of_lvlh = GyroChannels(reference_axes="lvlh", dcm=turned, rotation="sensor-to-body")
    found = read_telemetry(own, PAPER, TelemetryMapping(gyro=of_lvlh)).gyro_deg_s
    r = np.array(Environment.from_times(PAPER, telemetry.times).position)
    r /= np.linalg.norm(r, axis=1)[:, None]
    steps = np.degrees(2.0 * np.arcsin(0.5 * np.linalg.norm(np.diff(r, axis=0), axis=1)))
    np.testing.assert_allclose(found[1:, 0], -steps, rtol=1e-6)
    assert not found[:, 1:].any()
    with pytest.raises(InvalidValue, match="reference_axes declares that there is no gyro"):
        GyroChannels(reference_axes="lvlh", unit="rad/s")


def test_sparse_positions_with_gap_are_interpolated():
    """The interpolated positions agree with the orbit, and the field agrees to a nanotesla."""
    of = short(Scenario.paper(), 1200.0)
    flown = simulate_telemetry(of, PLAN, 1)
    truth = Environment.from_times(of, flown.times).position
    own = flown.to_frame()
    own[["position_x", "position_y", "position_z"]] = truth
    known = np.arange(1201) % 60 == 0
    known[300:380] = False
    own.loc[~known, ["position_x", "position_y", "position_z"]] = np.nan
    found = read_telemetry(own, of)
    off = np.linalg.norm(found.interpolate_positions(flown.times) - truth, axis=1)
    assert off.max() < 50.0
    vectors = build_batch(of, found).vectors
    expected = build_batch(of, flown).vectors
    np.testing.assert_allclose(vectors[:, 1], expected[:, 1], rtol=0, atol=1.0)
    own.loc[200:700, "position_x":] = np.nan
    with pytest.raises(ValueError, match=r"position: no sample near time (181|200).0+ s: exp"):
        build_batch(of, read_telemetry(own, of))
