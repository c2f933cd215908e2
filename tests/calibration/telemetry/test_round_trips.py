"""Attitudes and mountings in written files have the meaning that the readers expect."""

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import Scenario, StarTracker
from mgeo_attitude.plan import ManeuverPlan, format_aem, format_stk, to_csv
from mgeo_calibration import TelemetryMapping, calibrate, read_telemetry, simulate_telemetry
from mgeo_calibration.calibration.corrections import compute_corrections
from mgeo_calibration.calibration.document import from_json, to_json
from mgeo_calibration.telemetry.mapping import SensorChannels
from scipy.spatial.transform import Rotation

from ..calibration.runs import PLAN, short

ATTITUDE = tuple(Rotation.from_euler("xyz", [40.0, -70.0, 130.0], degrees=True).as_quat().tolist())
SCENARIO = short(Scenario.cubesat_6u(), 600.0)
SCENARIO = dataclasses.replace(
    SCENARIO, initial=dataclasses.replace(SCENARIO.initial, quaternion=ATTITUDE)
)
TRACKED = dataclasses.replace(SCENARIO, sensors=(*SCENARIO.sensors, StarTracker()))
Q = ["tracker_q1", "tracker_q2", "tracker_q3", "tracker_q4"]


@pytest.fixture(scope="module")
def telemetry():
    return simulate_telemetry(TRACKED, PLAN, 1)


@pytest.fixture(scope="module")
def calibration(telemetry):
    return calibrate(TRACKED, telemetry)


def read_as_tracker(telemetry, rows):
    """Return the attitudes from GCRS to body of quaternion rows that are read as star tracker
    samples.
    """
    frame = telemetry.to_frame().assign(**dict(zip(Q, np.asarray(rows).T, strict=True)))
    q = read_telemetry(frame, TRACKED).sensors["tracker"]
    q = np.where(np.isnan(q), (0.0, 0.0, 0.0, 1.0), q)
    return Rotation.from_quat(q).inv().as_matrix()


def compute_largest_angle(one, other):
    return Rotation.from_matrix(one @ np.swapaxes(other, -1, -2)).magnitude().max()


@pytest.mark.parametrize("mounting", ["dcm", "quaternion"])
def test_corrections_work_as_mapping(telemetry, mounting):
    """With its corrections as mapping, a sensor with errors is read without these errors."""
    suite, rng = TRACKED.suite, np.random.default_rng(2)
    states = 0.1 * rng.standard_normal(suite.n_states)
    entry = json.loads(json.dumps(compute_corrections(suite, states)))["mag"]
    frame, true = telemetry.to_frame(), telemetry.sensors["mag"]
    frame[["mag_x", "mag_y", "mag_z"]] = true @ np.array(entry["dcm"]).T + entry["bias"]
    back = Rotation.from_matrix(entry["dcm"]).inv().apply(-np.array(entry["bias"]))
    declared = {mounting: entry[mounting], "rotation": entry["rotation"], "unit": entry["unit"]}
    declared["offset"] = tuple(-np.array(entry["bias"]))
    mapping = TelemetryMapping(sensors=(SensorChannels(name="mag", **declared),))
    assert np.linalg.norm(back) > 1e3
    found = read_telemetry(frame, TRACKED, mapping).sensors["mag"]
    np.testing.assert_allclose(found, true, rtol=0, atol=1e-6)


def test_star_tracker_telemetry_contains_true_attitude(telemetry):
    found = read_telemetry(telemetry.to_frame(), TRACKED)
    pd.testing.assert_frame_equal(found.to_frame(), telemetry.to_frame(), check_exact=True)
    q = found.sensors["tracker"][1:]
    reported = Rotation.from_quat(q).inv().as_matrix()
    assert compute_largest_angle(reported, telemetry.truth.attitude[1:]) < np.radians(
        1.0
    )  # The tracker is misaligned.


def test_calibrated_attitude_reads_as_star_tracker_attitude(telemetry, calibration):
    rows = calibration.attitude[["q1", "q2", "q3", "q4"]].to_numpy()
    known = np.searchsorted(telemetry.times, calibration.attitude["time"])
    padded = np.full((len(telemetry.times), 4), np.nan)
    padded[known] = rows
    found = read_as_tracker(telemetry, padded)[known]
    assert compute_largest_angle(found, telemetry.truth.attitude[known]) < np.radians(0.5)


def test_followup_scenario_starts_at_calibrated_attitude(telemetry, calibration):
    read = from_json(to_json(calibration))
    after = read.build_followup_scenario({"accept_inconsistent": True})
    assert compute_largest_angle(after.prior.attitude, telemetry.truth.attitude[-1]) < np.radians(
        0.5
    )


def parse_first_quaternion(text, name):
    """Return the first quaternion of an exported plan."""
    if name == "CSV":
        row = pd.read_csv(pd.io.common.StringIO(text), comment="#").iloc[0]
        return [row[f"start q{part}"] for part in "123c"]
    lines = text.splitlines()
    first = {"AEM": "DATA_START", "STK": "AttitudeTimeQuaternions"}[name]
    return [float(part) for part in lines[lines.index(first) + 1].split()[1:5]]


@pytest.mark.parametrize(
    ("name", "write"),
    [("CSV", to_csv), ("STK", format_stk), ("AEM", format_aem)],
)
def test_exported_attitude_reads_as_telemetry_and_as_scenario(telemetry, name, write):
    plan = ManeuverPlan(SCENARIO, PLAN)
    q = parse_first_quaternion(write(plan), name)
    tolerance = 1e-6 if name == "AEM" else 1e-9  # An AEM uses EME2000.
    rows = np.full((len(telemetry.times), 4), np.nan)
    rows[0] = q
    read = read_as_tracker(telemetry, rows)
    assert compute_largest_angle(read[:1], plan.attitude[:1]) < tolerance
    initial = dataclasses.replace(SCENARIO.initial, quaternion=tuple(q))
    started = ManeuverPlan(dataclasses.replace(SCENARIO, initial=initial), PLAN)
    assert compute_largest_angle(started.attitude[:1], plan.attitude[:1]) < tolerance
