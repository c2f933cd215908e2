"""Healthy satellites have consistent calibrations: at rest, without gyro, and with overestimated
errors.
"""

import dataclasses
import re

import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.sensors.base import scale_noise
from mgeo_calibration import TelemetryMapping, calibrate, simulate_telemetry
from mgeo_calibration.telemetry.mapping import GyroChannels

from .runs import PLAN

GYRO_ERRORS = [f"gyro.{name}" for name in ("scale_factor", "misalignment", "nonorthogonality")]


def build_cubesat(duration, **changes):
    return Scenario.from_dict({"preset": "cubesat_6u", "duration": duration} | changes)


@pytest.mark.cases(2)
@pytest.mark.parametrize(("rate", "seed"), [(0.0, 1), (0.06, 2), (0.0, 3), (0.5, 4), (0.06, 5)])
def test_slow_rotation_gives_no_false_scale_factor(rate, seed):
    """The gyro noise is in its rates and in the residuals."""
    scenario = build_cubesat(3000.0)
    found = calibrate(scenario, simulate_telemetry(scenario, [0.0, rate, 0.0, 3000.0], seed))
    assert found.is_consistent, found.conclusion


def test_unobservable_errors_are_not_tested():
    scenario = build_cubesat(1500.0)
    found = calibrate(scenario, simulate_telemetry(scenario, [0.0, 0.0, 0.0, 1500.0], 1))
    table = found.build_model_test_table().loc[GYRO_ERRORS]
    assert (table["degrees_of_freedom"] == 0).all()
    assert (table["description"] == "not observable without rotations").all()
    assert found.list_uncalibrated().keys() >= set(GYRO_ERRORS)


def test_satellite_without_gyro_has_no_gyro_tests():
    scenario = build_cubesat(1500.0)
    flown = simulate_telemetry(scenario, [0.0, 0.0, 0.0, 1500.0], 1).to_frame()
    without = flown.drop(columns=["gyro_x", "gyro_y", "gyro_z"])
    mapping = TelemetryMapping(gyro=GyroChannels(reference_axes="inertial"))
    found = calibrate(scenario, without, mapping)
    assert found.is_consistent, found.conclusion
    assert not any(name.startswith("gyro.") for name in found.build_model_test_table().index)


@pytest.mark.parametrize(
    ("key", "declared", "measured"),
    [("field_error_nt", 300.0, (5.0, 60.0)), ("albedo", 0.03, (2.0, 25.0))],
)
def test_overestimated_error_gives_note_with_size(key, declared, measured):
    flown = dataclasses.replace(simulate_telemetry(build_cubesat(1500.0), PLAN, 1), truth=None)
    found = calibrate(build_cubesat(1500.0, environment_errors={key: declared}), flown)
    assert found.is_consistent, found.conclusion
    (note,) = (note for note in found.notes if "correlate negatively" in note)
    said = re.search(
        r"environment_errors\.(\w+) is declared with .*, but telemetry shows at most ([0-9.]+)",
        note,
    )
    assert said[1] in key
    assert measured[0] < float(said[2]) < measured[1]


@pytest.mark.parametrize("factor", [3.0, 10.0])
def test_overestimated_noise_is_consistent(factor):
    scenario = build_cubesat(1500.0)
    careful = tuple(scale_noise(sensor, factor) for sensor in scenario.sensors)
    found = calibrate(
        dataclasses.replace(scenario, sensors=careful), simulate_telemetry(scenario, PLAN, 2)
    )
    assert found.is_consistent, found.conclusion
    assert any(note.startswith("sun: the declared noise of ") for note in found.notes)


def test_underestimated_error_is_inconsistent():
    true = build_cubesat(1500.0, environment_errors={"field_error_nt": 200.0})
    flown = dataclasses.replace(simulate_telemetry(true, PLAN, 1), truth=None)
    assert not calibrate(build_cubesat(1500.0), flown).is_consistent


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 5])
def test_fit_converges_with_large_gyro_random_walk(seed):
    """Propagated over a longer interval, the attitude was wrong by more than a radian."""
    gyro = {"rate_random_walk": 2e-5, "initial_bias_deg_s": 0.05}
    scenario = build_cubesat(6000.0, gyro=gyro)
    found = calibrate(scenario, simulate_telemetry(scenario, PLAN, seed))
    assert found.is_consistent, found.conclusion
