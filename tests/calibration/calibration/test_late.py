"""Readings that are older than their time, by a simulation of its own."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario, StarTracker
from mgeo_calibration import calibrate

from .flights import PLAN, short
from .independent import Craft, fly, steady

SCENARIOS = {
    "paper": short(Scenario.paper(), 3000.0),
    "cubesat_6u": short(Scenario.cubesat_6u(), 3000.0),
}


def with_delays(scenario, sigma=0.5):
    sensors = tuple(dataclasses.replace(each, initial_latency_s=sigma) for each in scenario.sensors)
    return dataclasses.replace(scenario, sensors=sensors)


def off(calibration, block, true):
    """Errors of a state in 1-sigmas."""
    first = 3 * calibration.suite.blocks.index(block)
    own = slice(first, first + 3)
    return (calibration.states[own] - true) / np.sqrt(np.diag(calibration.covariance)[own])


def found(name, delays, seed):
    """Errors of all constants of sensors in 1-sigmas."""
    telemetry = fly(SCENARIOS[name], steady(PLAN), seed, Craft(late=delays))
    calibration = calibrate(with_delays(SCENARIOS[name]), telemetry)
    assert calibration.is_consistent
    assert not any("may be off" in note for note in calibration.notes)
    first = 3 * calibration.suite.blocks.index("mag.latency")
    told = calibration.compute_corrections()["mag"]["latency_s"]
    np.testing.assert_allclose(calibration.states[first : first + 3], told, atol=0.01)
    true = dict(zip(("sun.misalignment", "sun.bias", "mag.misalignment", "mag.bias"),
                    telemetry.truth.states[-1, 6:].reshape(4, 3), strict=True))  # fmt: skip
    true |= {f"{sensor}.latency": delay for sensor, delay in delays.items()}
    return {block: off(calibration, block, value) for block, value in true.items()}


@pytest.mark.slow
def test_delays_of_two_sensors_are_found_beside_all_else():
    for block, each in found("cubesat_6u", {"sun": 0.25, "mag": 0.5}, 1).items():
        assert np.abs(each).max() < (3.0 if "latency" in block else 4.0)


TURNS = [0.5, 0.3, -0.2, 90.0, -0.3, 0.6, 0.2, 120.0, 0.2, -0.4, 0.7, 110.0, -0.5, 0.2, -0.3, 80.0]


def beside_a_noisy_gyro(late, noise_arcsec, seed):
    """Errors of the delay of a tracker over its 1-sigmas; a step of the gyro is 9 arcsec."""
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
    craft = Craft(late={"tracker": late})
    telemetry = fly(scenario, steady(TURNS), seed, craft, duration=400.0)
    calibration = calibrate(scenario, telemetry)
    assert calibration.is_consistent, calibration.conclusion
    assert not calibration.notes
    return off(calibration, "tracker.latency", late)


@pytest.mark.parametrize("late", [0.1, 0.5])
def test_the_delay_of_a_tracker_that_is_better_than_the_gyro_is_right(late):
    """What is read is between two samples: it was off by 2 to 11 sigma, or not supported."""
    assert np.abs(beside_a_noisy_gyro(late, 1.0, 1)).max() < 3.0
