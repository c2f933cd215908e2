"""Keys that a calibration suggests make the calibration of the same telemetry consistent."""

import dataclasses
import re

import numpy as np
import pytest
from mgeo_calibration import calibrate
from mgeo_calibration.calibration.recalibration import recalibrate

from .faults import (
    MOTION,
    SCENARIO,
    add_drift,
    add_nonorthogonality,
    add_random_walk,
    add_scale_error,
    add_step,
    add_temperature_bias,
    change_gyro,
    change_sensor,
    temperature,
)
from .independent_simulator import TrueErrors, simulate_readings

pytestmark = pytest.mark.slow

#: Faults: true errors, change of telemetry, suggested key, and added state.
ADDED = {
    "magnetometer late": ({"late": {"mag": 0.4}}, None, "mag.initial_latency_s", "mag.latency"),
    "Sun sensor late": ({"late": {"sun": 0.5}}, None, "sun.initial_latency_s", "sun.latency"),
    "scale of the magnetometer": (
        {},
        change_sensor("mag", add_scale_error(0.01)),
        "mag.initial_scale_factor",
        "mag.scale_factor",
    ),
    "soft iron": (
        {},
        change_sensor("mag", add_nonorthogonality(0.5)),
        "mag.initial_nonorthogonality_deg",
        "mag.nonorthogonality",
    ),
    "scale of the gyro": (
        {},
        change_gyro(add_scale_error(0.01)),
        "gyro.initial_scale_factor",
        "gyro.scale_factor",
    ),
    "axes of the gyro": (
        {},
        change_gyro(add_nonorthogonality(0.5)),
        "gyro.initial_nonorthogonality_deg",
        "gyro.nonorthogonality",
    ),
    "magnetometer and temperature": (
        {},
        change_sensor("mag", add_temperature_bias(1000.0)),
        "mag.bias_sensitivities",
        "mag.temperature",
    ),
    "gyro and temperature": (
        {},
        change_gyro(add_temperature_bias(0.01)),
        "gyro.bias_sensitivities",
        "gyro.temperature",
    ),
}


def simulate_with_fault(craft, spoil, seed=4):
    flown = simulate_readings(SCENARIO, MOTION, seed, TrueErrors(**craft))
    flown = dataclasses.replace(flown, housekeeping={"temperature": temperature(flown.times)})
    return spoil(flown, np.random.default_rng(seed)) if spoil else flown


@pytest.mark.parametrize("name", ADDED)
def test_suggested_state_makes_calibration_consistent(name):
    craft, spoil, key, state = ADDED[name]
    telemetry = simulate_with_fault(craft, spoil)
    first = calibrate(SCENARIO, telemetry)
    assert re.search(rf"set {re.escape(key)}\b.*--fit {state}\b", first.failures[0].action)
    found = recalibrate(first, telemetry, [state])
    assert found.is_consistent, found.conclusion


@pytest.mark.parametrize("change", [add_drift(0.01), add_random_walk(0.003)])
def test_suggested_random_walk_makes_calibration_consistent(change):
    telemetry = simulate_with_fault({}, change_gyro(change))
    first = calibrate(SCENARIO, telemetry)
    said = re.match(
        r"gyro\.bias drifts by .* random walk of about ([0-9.e-]+) rad", first.failures[0].cause
    )
    assert said, first.failures
    more = dataclasses.replace(SCENARIO.gyro, rate_random_walk=float(said[1]))
    found = calibrate(dataclasses.replace(SCENARIO, gyro=more), telemetry)
    assert found.is_consistent, found.conclusion


def test_suggested_gyro_noise_makes_calibration_consistent():
    noisy = dataclasses.replace(SCENARIO.gyro, angle_random_walk_deg_per_sqrt_h=1.2)
    telemetry = simulate_readings(dataclasses.replace(SCENARIO, gyro=noisy), MOTION, 4)
    first = calibrate(SCENARIO, telemetry)
    said = re.match(
        r"gyro is noisier than declared, about ([0-9.]+) deg/sqrt", first.failures[0].cause
    )
    assert said, first.failures
    more = dataclasses.replace(SCENARIO.gyro, angle_random_walk_deg_per_sqrt_h=float(said[1]))
    found = calibrate(dataclasses.replace(SCENARIO, gyro=more), telemetry)
    assert found.is_consistent, found.conclusion


def test_data_before_suggested_step_time_are_consistent():
    telemetry = simulate_with_fault({}, change_sensor("mag", add_step(500.0)))
    first = calibrate(SCENARIO, telemetry)
    said = re.match(r"mag\.bias changes by .* at about ([0-9]+) s", first.failures[0].cause)
    assert said, first.failures
    found = calibrate(SCENARIO, telemetry.truncate(float(said[1]) - 3000.0 / 16.0))
    assert found.is_consistent, found.conclusion
