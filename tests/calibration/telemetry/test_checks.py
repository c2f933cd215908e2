"""Checks of telemetry: each contradiction of a declaration or of physics is found with row, value
and key.
"""

import dataclasses
import re

import numpy as np
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_calibration import Telemetry, TelemetryMapping, read_telemetry, simulate_telemetry
from mgeo_calibration.telemetry.checks import describe_findings
from mgeo_calibration.telemetry.mapping import PositionChannels

from ..calibration.runs import PLAN, short

PAPER = short(Scenario.paper(), 600.0)
POSITION = ["position_x", "position_y", "position_z"]


@pytest.fixture(scope="module")
def telemetry():
    return simulate_telemetry(PAPER, PLAN, 1)


@pytest.fixture(scope="module")
def frame(telemetry):
    return telemetry.to_frame()


def change_columns(frame, **columns):
    own = frame.copy()
    for name, (rows, value) in columns.items():
        if isinstance(value, str):
            own[name] = own[name].astype(object)
        own.loc[rows, name] = value
    return own


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda f: f.drop(columns=["mag_y", "mag_z"]), "missing columns mag_y, mag_z: the table "),
        (lambda f: change_columns(f, mag_x=(7, "abc")), "row 8, mag_x = 'abc': expected a number"),
        (lambda f: change_columns(f, gyro_y=(7, np.nan)),
         r"gyro at row 8, time 7 s = .*all components"),
        (lambda f: change_columns(f, time=(7, "noon")), "row 8, time = 'noon': expected a number"),
        (lambda f: f.assign(time=["noon", *["2018-06-05T00:00:00Z"] * (len(f) - 1)]),
         "row 1, time = 'noon': expected .*time_epoch"),
        (lambda f: change_columns(f, time=(slice(200, 300), 5e5)),
         r"^gyro_x at time 500000.* in row 2\d\d and .* in row .*time_fraction"),
        (lambda f: f.assign(time=f["time"] + 1e6 * (f["time"] > 200)),
         r"^time at row 201, time 200 s: 1000001.0+ s until .* Declare time_epoch"),
        (lambda f: f.assign(time=f["time"] + 1.5e9), "^time at row 1, .*IGRF.* Declare time_epoch"),
        (lambda f: f.assign(time=f["time"] - 1.5e9), "^time at row 1, .*within a year"),
        (lambda f: f.assign(time=f["time"] / 86400.0), r"^time at row 1, .*1.16e-05.*time_unit"),
        (lambda f: f.assign(mag_z=f["mag_z"] * 0.0 + 5.0),
         r"^mag_z at row 2, time 1 s: 5.0 in all 600 samples, .* mag.columns"),
        (lambda f: f.assign(gyro_x=f["gyro_x"].clip(upper=float(f["gyro_x"].median()))),
         r"^gyro_x at row \d+, .* deg/s in \d+ samples in a row, .* gyro.range_deg_s"),
        (lambda f: f.assign(**{c: np.nan for c in f if c[:3] in ("sun", "mag")}),
         "sun, mag: no samples. Expected samples of at least one sensor"),
        (lambda f: f.assign(**{c: 1e-3 * f[c] for c in f if c[:3] == "mag"}),
         r"^mag at row 2, .* nT \(median\), expected about 3\d+ nT.* unit = 'uT' of mag"),
        (lambda f: f.assign(**dict.fromkeys(POSITION, 6800.0)),
         r"^position at row 1, time 0 s: a radius of 11777.9 m, expected .* position.unit"),
    ],
)  # fmt: skip
def test_fatal_finding_states_row_value_and_key(frame, change, message, tmp_path):
    wrong = change(frame)
    with pytest.raises(ValueError, match=message):
        read_telemetry(wrong, PAPER)
    wrong.to_csv(tmp_path / "t.csv", index=False)
    with pytest.raises(ValueError, match=r"t\.csv: ") as caught:
        read_telemetry(tmp_path / "t.csv", PAPER)
    assert "\n" not in str(caught.value)


def simulate_with_bias(offset, sigma):
    """Return a scenario with a prior 1-sigma of the magnetometer bias, and telemetry with a bias
    along z [nT].
    """
    sun, mag = PAPER.sensors
    scenario = dataclasses.replace(
        PAPER, sensors=(sun, dataclasses.replace(mag, initial_bias_nt=sigma))
    )
    frame = simulate_telemetry(PAPER, PLAN, 1).to_frame()
    return scenario, frame.assign(mag_z=frame["mag_z"] + offset)


def test_declared_magnetometer_bias_is_not_reported_as_wrong_unit():
    scenario, frame = simulate_with_bias(160e3, 1e5)
    assert read_telemetry(frame, scenario).sensors["mag"].shape == (601, 3)
    with pytest.raises(ValueError, match=r"mag at row 2.* initial_bias_nt"):
        read_telemetry(frame, PAPER)


def test_declared_gyro_bias_is_not_reported_as_wrong_unit(frame):
    offset = frame.assign(gyro_x=frame["gyro_x"] + 4.0)
    wide = dataclasses.replace(PAPER, gyro=dataclasses.replace(PAPER.gyro, initial_bias_deg_s=5.0))
    assert describe_findings(wide, read_telemetry(offset, wide))["rates against vectors"] == ()
    words = describe_findings(PAPER, read_telemetry(offset, PAPER))["rates against vectors"][0]
    assert "gyro.unit" in words
    assert "initial_bias_deg_s" in words


@pytest.mark.parametrize("factor", [np.pi / 180.0, 180.0 / np.pi, 3600.0, 1e-3])
def test_rates_in_another_unit_contradict_observed_vectors(telemetry, factor):
    wrong = dataclasses.replace(telemetry, gyro_deg_s=factor * telemetry.gyro_deg_s)
    assert "Declare gyro.unit" in describe_findings(PAPER, wrong)["rates against vectors"][0]


def test_healthy_telemetry_has_no_findings(telemetry):
    assert not any(describe_findings(PAPER, telemetry).values())


def test_repeated_and_frozen_samples_are_found():
    rng, times = np.random.default_rng(1), np.arange(400.0)
    vectors = 2.4e4 + rng.standard_normal((400, 3))
    frozen = vectors.copy()
    frozen[100:150] = frozen[100]
    for rows, words in (
        (np.repeat(vectors[:200], 2, axis=0), "mag at time 0 s: each sample 2 times"),
        (frozen, r"mag at time 100 s: 50 equal samples, until time 149 s"),
    ):
        sensors = {"mag": rows, "sun": vectors / 4e4}
        read = Telemetry(times=times, gyro_deg_s=rng.standard_normal((400, 3)), sensors=sensors)
        (found,) = describe_findings(PAPER, read)["repeated samples"]
        assert found.startswith(words)


def test_fill_values_and_clipped_channels_are_found(telemetry):
    mag = telemetry.sensors["mag"]
    filled, clipped = mag.copy(), mag.copy()
    filled[50:80, 0] = -99999.0
    clipped[:, 1] = np.minimum(mag[:, 1], np.nanquantile(mag[:, 1], 0.8))
    for rows, words in (
        (filled, "mag_x at time 50 s: -99999 in 30 of 600 samples, expected a measured"),
        (clipped, "never above, expected a channel that is not clipped"),
    ):
        wrong = dataclasses.replace(telemetry, sensors=telemetry.sensors | {"mag": rows})
        (found,) = describe_findings(PAPER, wrong)["repeated numbers"]
        assert words in found


def test_field_at_another_time_is_found_with_worst_sample(telemetry):
    later = dataclasses.replace(telemetry, times=telemetry.times + 1500.0)
    (found,) = describe_findings(PAPER, later)["field strength against time"]
    assert found.startswith("mag at time ")
    assert "time_system" in found


def test_scale_factor_of_all_axes_is_distinguished_from_field_at_another_time():
    sun, mag = PAPER.sensors
    mag = dataclasses.replace(mag, noise_nt=50.0, initial_bias_nt=200.0)
    precise = dataclasses.replace(PAPER, sensors=(sun, mag))
    read = simulate_telemetry(precise, [0.8, 0.3, -0.2, 300.0, -0.3, 0.9, 0.5, 300.0], 1)
    scaled = dataclasses.replace(read, sensors=read.sensors | {"mag": 1.03 * read.sensors["mag"]})
    (found,) = describe_findings(precise, scaled)["field strength against time"]
    assert re.search(r"Set mag\.initial_scale_factor .* 3\.0 % too large", found)
    later = dataclasses.replace(read, times=read.times + 1500.0)
    (found,) = describe_findings(precise, later)["field strength against time"]
    assert "initial_scale_factor" not in found


def test_positions_in_another_frame_or_time_scale_are_identified(frame):
    """The satellite is 2 km ahead of the scenario's orbit, as after some days with an old element
    set.
    """
    where = Environment.from_times(PAPER, frame["time"].to_numpy() + 0.3).position
    astropy = pytest.importorskip("astropy.coordinates")
    from astropy.time import Time, TimeDelta

    when = Time(PAPER.epoch.replace(tzinfo=None)) + TimeDelta(
        frame["time"].to_numpy(), format="sec"
    )
    gcrs = astropy.GCRS(astropy.CartesianRepresentation(*where.T, unit="m"), obstime=when)
    frames = {"TEME": astropy.TEME(obstime=when), "ITRF": astropy.ITRS(obstime=when)}
    for name, there in frames.items():
        own = frame.copy()
        own[POSITION] = gcrs.transform_to(there).cartesian.xyz.to_value("m").T
        with pytest.raises(ValueError, match=rf"row 1, .* look like (TOD or )?{name}. Declare pos"):
            read_telemetry(own, PAPER)
        declared = TelemetryMapping(position=PositionChannels(frame=name))
        found = read_telemetry(own, PAPER, declared).position
        assert np.abs(found - where).max() < 250.0  # ITRF depends on UT1 and polar motion.
        asserted = TelemetryMapping(position=PositionChannels(frame="GCRF"))
        assert read_telemetry(own, PAPER, asserted).position is not None
    late = frame.assign(time=frame["time"] + 18.0)
    late[POSITION] = where
    with pytest.raises(ValueError, match=r"look like GPS time: 18 s\. Declare time_system"):
        read_telemetry(late, PAPER)
    assert read_telemetry(late, PAPER, TelemetryMapping(time_system="UTC")).position is not None
