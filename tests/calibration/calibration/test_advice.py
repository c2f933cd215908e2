"""Each key that a calibration suggests is tried on the flight that provoked it."""

import dataclasses
import re

import numpy as np
import pytest
from mgeo_calibration import calibrate
from mgeo_calibration.calibration.recalibration import recalibrate

from .faults import (
    MOTION,
    SCENARIO,
    gyro,
    ramp,
    scaled,
    sensor,
    sheared,
    stepped,
    temperature,
    walk,
    warmed,
)
from .independent import Craft, fly

pytestmark = pytest.mark.slow

#: What is wrong: the flight, how its telemetry is spoiled, the key, and the state that is added.
ADDED = {
    "magnetometer late": ({"late": {"mag": 0.4}}, None, "mag.initial_latency_s", "mag.latency"),
    "Sun sensor late": ({"late": {"sun": 0.5}}, None, "sun.initial_latency_s", "sun.latency"),
    "scale of the magnetometer": (
        {},
        sensor("mag", scaled(0.01)),
        "mag.initial_scale_factor",
        "mag.scale_factor",
    ),
    "soft iron": (
        {},
        sensor("mag", sheared(0.5)),
        "mag.initial_nonorthogonality_deg",
        "mag.nonorthogonality",
    ),
    "scale of the gyro": ({}, gyro(scaled(0.01)), "gyro.initial_scale_factor", "gyro.scale_factor"),
    "axes of the gyro": (
        {},
        gyro(sheared(0.5)),
        "gyro.initial_nonorthogonality_deg",
        "gyro.nonorthogonality",
    ),
    "magnetometer and temperature": (
        {},
        sensor("mag", warmed(1000.0)),
        "mag.bias_sensitivities",
        "mag.temperature",
    ),
    "gyro and temperature": ({}, gyro(warmed(0.01)), "gyro.bias_sensitivities", "gyro.temperature"),
}


def spoiled(craft, spoil, seed=4):
    flown = fly(SCENARIO, MOTION, seed, Craft(**craft))
    flown = dataclasses.replace(flown, housekeeping={"temperature": temperature(flown.times)})
    return spoil(flown, np.random.default_rng(seed)) if spoil else flown


@pytest.mark.parametrize("name", ADDED)
def test_the_state_of_the_key_that_is_suggested_fits(name):
    craft, spoil, key, state = ADDED[name]
    telemetry = spoiled(craft, spoil)
    first = calibrate(SCENARIO, telemetry)
    assert re.search(rf": {re.escape(key)}\b", first.failures[0]), first.failures
    found = recalibrate(first, telemetry, [state])
    assert found.is_consistent, found.conclusion


@pytest.mark.parametrize("change", [ramp(0.01), walk(0.003)])
def test_the_random_walk_that_is_suggested_fits(change):
    telemetry = spoiled({}, gyro(change))
    first = calibrate(SCENARIO, telemetry)
    said = re.match(
        r"(?:either )?gyro\.bias drifts by .* random walk of about ([0-9.e-]+), ", first.failures[0]
    )
    assert said, first.failures
    more = dataclasses.replace(SCENARIO.gyro, rate_random_walk=float(said[1]))
    found = calibrate(dataclasses.replace(SCENARIO, gyro=more), telemetry)
    assert found.is_consistent, found.conclusion


def test_the_noise_of_the_gyro_that_is_suggested_fits():
    noisy = dataclasses.replace(SCENARIO.gyro, angle_random_walk_deg_per_sqrt_h=1.2)
    telemetry = fly(dataclasses.replace(SCENARIO, gyro=noisy), MOTION, 4)
    first = calibrate(SCENARIO, telemetry)
    said = re.match(r"gyro is noisier than declared, about ([0-9.]+) deg/sqrt", first.failures[0])
    assert said, first.failures
    more = dataclasses.replace(SCENARIO.gyro, angle_random_walk_deg_per_sqrt_h=float(said[1]))
    found = calibrate(dataclasses.replace(SCENARIO, gyro=more), telemetry)
    assert found.is_consistent, found.conclusion


def test_what_is_before_a_step_fits():
    telemetry = spoiled({}, sensor("mag", stepped(500.0)))
    first = calibrate(SCENARIO, telemetry)
    said = re.match(r"(?:either )?mag\.bias changes by .* at about ([0-9]+) s", first.failures[0])
    assert said, first.failures
    found = calibrate(SCENARIO, telemetry.truncate(float(said[1]) - 3000.0 / 16.0))
    assert found.is_consistent, found.conclusion
