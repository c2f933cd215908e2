"""Errors that all sensors share: what is promised of several of a kind is achieved."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import EnvironmentErrors, Scenario
from mgeo_attitude.scenario import Convergence
from mgeo_calibration import simulate

PLAN = np.array([0.5, -0.3, 0.8, 300.0, -0.7, 0.9, 0.1, 300.0, 0.2, 0.4, -0.9, 400.0])


def with_magnetometers(number, world, duration=1500.0):
    base = Scenario.cubesat_6u()
    sun, mag = base.sensors
    more = tuple(dataclasses.replace(mag, name=f"mag{i}") for i in range(number))
    return dataclasses.replace(
        base,
        sensors=(sun, *more),
        environment_errors=world,
        duration=duration,
        convergence=Convergence(window=duration),
    )


@pytest.mark.slow
def test_more_magnetometers_promise_no_more_than_they_achieve():
    """Where each had a field error of its own, four promised 0.083 deg and achieved 0.138."""
    scenario = with_magnetometers(4, EnvironmentErrors(field_error_nt=150.0))
    found = simulate(scenario, PLAN, 240, seed=11)
    late = found.times >= 600.0
    achieved = np.sqrt(np.mean(found.errors[:, late, :3] ** 2))
    promised = np.sqrt(np.mean(found.predicted_sigma[late, :3] ** 2))
    assert achieved / promised == pytest.approx(1.0, abs=0.05)
