"""Quaternions in an undeclared convention are reported, not an error of another sensor."""

import dataclasses

import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.sensors import StarTracker
from mgeo_calibration import simulate_telemetry
from mgeo_calibration.calibration.calibrate import calibrate
from mgeo_calibration.estimation.axis_mistakes import QUATERNION_CONVENTIONS, find_axis_mistakes
from mgeo_calibration.estimation.batch import build_batch

DESIGN = (0.3, -0.2, 0.1, 200.0, -0.2, 0.3, 0.2, 200.0, 0.1, 0.2, -0.3, 200.0)
#: Conversion of declared quaternions, scalar last and from GCRF to the body, to each convention.
CONVERSIONS = {
    "scalar first": lambda q: q[:, [3, 0, 1, 2]],
    "from the body to GCRF": lambda q: q * [-1.0, -1.0, -1.0, 1.0],
    "scalar first, from the body to GCRF": lambda q: (q * [-1.0, -1.0, -1.0, 1.0])[:, [3, 0, 1, 2]],
}


def simulate(scenario, seed=1):
    return simulate_telemetry(scenario, DESIGN, seed)


@pytest.fixture(scope="module")
def scenario():
    cubesat = Scenario.cubesat_6u()
    return dataclasses.replace(
        cubesat,
        duration=900.0,
        sensors=(*cubesat.sensors, StarTracker(initial_misalignment_deg=1.0)),
    )


def convert_quaternions(telemetry, convention):
    sensors = dict(telemetry.sensors)
    sensors["tracker"] = CONVERSIONS[convention](sensors["tracker"])
    return dataclasses.replace(telemetry, sensors=sensors)


def test_failed_calibration_reports_quaternion_convention(scenario):
    convention = "from the body to GCRF"
    message = (
        rf"^tracker: its quaternions agree .* as {convention}: expected scalar last, from GCRF"
    )
    with pytest.raises(ValueError, match=message):
        calibrate(scenario, convert_quaternions(simulate(scenario), convention))


@pytest.mark.parametrize("convention", [name for name, *_ in QUATERNION_CONVENTIONS])
def test_convention_is_found_from_star_tracker_and_gyro(scenario, convention):
    tracker_only = dataclasses.replace(scenario, sensors=scenario.sensors[-1:])
    batch = build_batch(tracker_only, convert_quaternions(simulate(tracker_only), convention))
    (cause,) = find_axis_mistakes(batch)
    assert f"read as {convention}: " in cause


def test_large_gyro_bias_is_not_reported_as_quaternion_convention(scenario):
    large_bias = dataclasses.replace(
        scenario, gyro=dataclasses.replace(scenario.gyro, initial_bias_deg_s=1.0)
    )
    telemetry = simulate(large_bias)
    assert calibrate(large_bias, telemetry).is_consistent
    with pytest.raises(ValueError, match="read as scalar first: "):
        calibrate(large_bias, convert_quaternions(telemetry, "scalar first"))
