"""Recalibration with additional states and estimated noise, and its comparison with the first
calibration.
"""

import dataclasses

import numpy as np
import pytest
from mgeo_calibration import calibrate
from mgeo_calibration.calibration.recalibration import (
    compare_calibrations,
    describe_noise,
    recalibrate,
)

from .faults import MOTION, SCENARIO
from .independent_simulator import simulate_readings

SCALE = np.array([0.01, -0.004, 0.002])


@pytest.fixture(scope="module")
def flight():
    telemetry = simulate_readings(SCENARIO, MOTION, 2)
    sensors = {**telemetry.sensors, "mag": telemetry.sensors["mag"] * (1.0 + SCALE)}
    return dataclasses.replace(telemetry, sensors=sensors)


@pytest.fixture(scope="module")
def first(flight):
    sun, mag = SCENARIO.sensors
    loud = dataclasses.replace(sun, noise_deg=1.5 * sun.noise_deg)
    return calibrate(dataclasses.replace(SCENARIO, sensors=(loud, mag)), flight)


@pytest.mark.slow
def test_scale_factors_and_noise_are_estimated_and_compared(flight, first):
    assert str(first.failures[0]).startswith("mag.scale_factor is ")
    found = recalibrate(first, flight, ["mag.scale_factor", "noise"])
    assert found.is_consistent, found.conclusion
    scale = found.build_table().set_index("block").loc["mag.scale_factor"]
    assert np.abs((scale["estimate"] - 1e6 * SCALE) / scale["sigma"]).max() < 4.0
    table = compare_calibrations(first, found).loc["mag.scale_factor"]
    assert table["sigma before"].isna().all()
    assert table["change / sigma [-]"].abs().max() > 20.0
    noise = found.scenario.sensors[0].noise_deg
    assert noise == pytest.approx(SCENARIO.sensors[0].noise_deg, rel=0.02)
    assert f"sun.noise_deg = {noise:.4g}" in describe_noise(found)
