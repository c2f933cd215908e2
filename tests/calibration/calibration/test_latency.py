"""Sensors with measurement latency, by the independent simulator."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario, StarTracker
from mgeo_calibration import calibrate

from .independent_simulator import TrueErrors, constant_rates, simulate_readings
from .runs import PLAN, short

SCENARIOS = {
    "paper": short(Scenario.paper(), 3000.0),
    "cubesat_6u": short(Scenario.cubesat_6u(), 3000.0),
}


def add_latency_states(scenario, sigma=0.5):
    sensors = tuple(dataclasses.replace(each, initial_latency_s=sigma) for each in scenario.sensors)
    return dataclasses.replace(scenario, sensors=sensors)


def normalize_error(calibration, block, true):
    """Return the error of a state in 1-sigmas."""
    first = 3 * calibration.suite.blocks.index(block)
    own = slice(first, first + 3)
    return (calibration.states[own] - true) / np.sqrt(np.diag(calibration.covariance)[own])


def normalize_errors(name, delays, seed):
    """Return the errors of all sensor parameters in 1-sigmas, as a dict by block."""
    telemetry = simulate_readings(
        SCENARIOS[name], constant_rates(PLAN), seed, TrueErrors(late=delays)
    )
    calibration = calibrate(add_latency_states(SCENARIOS[name]), telemetry)
    assert calibration.is_consistent
    assert not any("may be off" in note for note in calibration.notes)
    first = 3 * calibration.suite.blocks.index("mag.latency")
    told = calibration.compute_corrections()["mag"]["latency_s"]
    np.testing.assert_allclose(calibration.states[first : first + 3], told, atol=0.01)
    true = dict(zip(("sun.misalignment", "sun.bias", "mag.misalignment", "mag.bias"),
                    telemetry.truth.states[-1, 6:].reshape(4, 3), strict=True))  # fmt: skip
    true |= {f"{sensor}.latency": delay for sensor, delay in delays.items()}
    return {block: normalize_error(calibration, block, value) for block, value in true.items()}


@pytest.mark.slow
def test_latencies_of_two_sensors_are_estimated():
    for block, each in normalize_errors("cubesat_6u", {"sun": 0.25, "mag": 0.5}, 1).items():
        assert np.abs(each).max() < (3.0 if "latency" in block else 4.0)


TURNS = [0.5, 0.3, -0.2, 90.0, -0.3, 0.6, 0.2, 120.0, 0.2, -0.4, 0.7, 110.0, -0.5, 0.2, -0.3, 80.0]


def normalize_tracker_latency_error(late, noise_arcsec, seed):
    """Return the latency error of a star tracker in 1-sigmas; the gyro noise of a step is 9
    arcsec.
    """
    scenario = short(Scenario.cubesat_6u(), 400.0)
    tracker = StarTracker(
        noise_arcsec=noise_arcsec,
        roll_noise_arcsec=noise_arcsec,
        max_rate_deg_s=None,
        sun_exclusion_deg=None,
        earth_exclusion_deg=None,
        initial_misalignment_deg=0.0,
        initial_latency_s=0.3,
    )
    gyro = dataclasses.replace(scenario.gyro, rate_random_walk=1e-9)
    scenario = dataclasses.replace(scenario, gyro=gyro, sensors=(tracker,))
    craft = TrueErrors(late={"tracker": late})
    telemetry = simulate_readings(scenario, constant_rates(TURNS), seed, craft, duration=400.0)
    calibration = calibrate(scenario, telemetry)
    assert calibration.is_consistent, calibration.conclusion
    assert not calibration.notes
    return normalize_error(calibration, "tracker.latency", late)


@pytest.mark.parametrize("late", [0.1, 0.5])
def test_latency_of_accurate_star_tracker_is_estimated(late):
    """Readings between two samples had errors of 2 to 11 sigma before the step noise was
    modeled.
    """
    assert np.abs(normalize_tracker_latency_error(late, 1.0, 1)).max() < 3.0
