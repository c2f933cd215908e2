"""Errors that depend on channels or on the sense of rotation are identified, and their states can
be added.
"""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate
from mgeo_calibration.calibration.recalibration import recalibrate
from scipy.spatial.transform import Rotation

from .faults import names_cause, temperature
from .independent_simulator import constant_rates, simulate_readings
from .runs import PLAN, short

SCENARIO = short(Scenario.cubesat_6u(), 3000.0)
MOTION = constant_rates(
    [*PLAN, -0.5, -0.3, 0.2, 400.0, 0.3, -0.6, -0.2, 500.0, -0.2, 0.4, -0.7, 600.0]
)
COMMON = {f"{name}.{state}": slice(3 * k, 3 * k + 3) for k, (name, state) in enumerate(
    [("attitude", ""), ("gyro", "bias"), ("sun", "misalignment"), ("sun", "bias"),
     ("mag", "misalignment"), ("mag", "bias")])}  # fmt: skip


def add_scale_asymmetry(telemetry):
    rates = telemetry.gyro_deg_s
    rates = rates + np.array([0.005, -0.004, 0.003]) * np.abs(rates)
    return dataclasses.replace(telemetry, gyro_deg_s=rates)


def add_temperature_misalignment(telemetry):
    """Rotate the magnetometer by up to 0.5 deg with the temperature."""
    warm = temperature(telemetry.times)
    turn = 0.06 * (warm - warm.mean())[:, None] * np.array([0.6, -0.6, 0.5])
    field = Rotation.from_rotvec(turn, degrees=True).apply(telemetry.sensors["mag"])
    sensors = {**telemetry.sensors, "mag": field}
    return dataclasses.replace(telemetry, sensors=sensors, housekeeping={"temp": warm})


def add_torquer_field(telemetry):
    """Add the field of two torquers with duty cycles and of a solar panel current."""
    t = telemetry.times
    duty = {
        "duty_x": 0.5 + 0.5 * np.sign(np.sin(2.0 * np.pi * t / 70.0)),
        "duty_y": np.clip(np.sin(2.0 * np.pi * t / 333.0), 0.0, 1.0),
        "panel": 0.4 + 0.3 * np.sin(2.0 * np.pi * t / 1500.0),
    }
    per_unit = np.array([[300.0, 100.0, -50.0], [0.0, 250.0, 80.0], [-60.0, 40.0, 200.0]])
    field = telemetry.sensors["mag"] + np.column_stack(list(duty.values())) @ per_unit
    sensors = {**telemetry.sensors, "mag": field}
    return dataclasses.replace(telemetry, sensors=sensors, housekeeping=duty)


FAULTS = {
    "asymmetry": (add_scale_asymmetry, r"gyro\.scale_asymmetry is ", ["gyro.scale_asymmetry"]),
    "misalignment": (
        add_temperature_misalignment,
        r"mag\.misalignment depends on temp by ",
        ["mag.misalignment.temp"],
    ),
    "torquers": (
        add_torquer_field,
        r"mag\.bias depends on (duty_x|duty_y|panel) by ",
        ["mag.duty_x", "mag.duty_y", "mag.panel"],
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_error_is_identified_and_added_state_is_consistent(name):
    spoil, cause, keys = FAULTS[name]
    telemetry = spoil(simulate_readings(SCENARIO, MOTION, 3))
    first = calibrate(SCENARIO, telemetry)
    assert not first.is_consistent
    assert names_cause(cause, str(first.failures[0])), first.failures
    found = recalibrate(first, telemetry, keys)
    assert found.is_consistent, found.conclusion
    for block in ("gyro.bias", "sun.misalignment", "sun.bias", "mag.misalignment"):
        place = 3 * found.suite.blocks.index(block)
        true = telemetry.truth.states[-1, COMMON[block]]
        error = found.states[place : place + 3] - true
        sigma = np.sqrt(np.diag(found.covariance)[place : place + 3])
        assert (np.abs(error) < 4.0 * sigma).all(), block
