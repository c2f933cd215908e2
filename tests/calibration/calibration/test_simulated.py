"""Flights and their calibrations, many at once: those of `calibrate`, and consistent."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate, consistency, fly, simulate_calibrations

from ...attitude.filter.suites import SUITES
from .flights import PLAN, error, short

CASES = {"paper": None, "considered": "considered", "star tracker": "star tracker"}


@pytest.mark.cases(0, 2)
@pytest.mark.parametrize("name", CASES)
def test_the_estimates_are_those_of_calibrate(name):
    scenario = short(Scenario.paper(), 1200.0)
    if CASES[name]:
        suite = SUITES[CASES[name]]
        scenario = dataclasses.replace(
            scenario, gyro=suite.gyro, sensors=suite.sensors, world=suite.world
        )
    found = simulate_calibrations(scenario, PLAN, 3, seed=5)
    assert found.times.tolist() == [1200.0]
    for run, generator in enumerate(np.random.default_rng(5).spawn(3)):
        telemetry = fly(scenario, PLAN, generator)
        one = calibrate(scenario, telemetry)
        sigma = np.sqrt(np.diag(one.covariance))
        off = found.errors[run, 0] - error(one, telemetry)
        np.testing.assert_allclose(off / sigma, 0.0, atol=0.02)
        np.testing.assert_allclose(found.sigma[run, 0], sigma, rtol=0.01)
        for index, test in enumerate(one.tests):
            count = found.updates[run, 0, index]
            assert count == test.readings - test.rejected
            assert found.nis[run, 0, index] / (3 * count) == pytest.approx(test.nis, rel=1e-3)


@pytest.mark.slow
def test_another_truth_is_found_out(scenario):
    """A Sun sensor of twice the noise: innovations too large, and estimates."""
    sun, *others = scenario.sensors
    loud = dataclasses.replace(sun, noise_deg=2.0 * sun.noise_deg)
    truth = dataclasses.replace(scenario, sensors=(loud, *others))
    report = consistency(simulate_calibrations(scenario, PLAN, 8, seed=1, truth=truth), since=0.0)
    assert report["nis sun"].value > 3.0  # 4, but for those beyond the gate
    assert report["nis mag"].passed
    assert not report["nees"].passed


@pytest.mark.cases(0, 1)
@pytest.mark.parametrize("preset", ["paper", "cubesat_6u"])
def test_many_are_consistent(preset):
    scenario = short(getattr(Scenario, preset)(), 3000.0)
    report = consistency(simulate_calibrations(scenario, PLAN, 100, seed=1), since=0.0)
    for name in ("nees", "nis sun", "nis mag", "beyond 3 sigma"):
        assert report[name].passed, report.table()
