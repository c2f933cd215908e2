"""Environment model errors that several sensors of one kind share."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import EnvironmentErrors, Scenario
from mgeo_attitude.scenario import Convergence
from mgeo_calibration import simulate

PLAN = np.array([0.5, -0.3, 0.8, 300.0, -0.7, 0.9, 0.1, 300.0, 0.2, 0.4, -0.9, 400.0])


def build_scenario(n_magnetometers, environment_errors, duration=1500.0):
    base = Scenario.cubesat_6u()
    sun, mag = base.sensors
    magnetometers = tuple(dataclasses.replace(mag, name=f"mag{i}") for i in range(n_magnetometers))
    return dataclasses.replace(
        base,
        sensors=(sun, *magnetometers),
        environment_errors=environment_errors,
        duration=duration,
        convergence=Convergence(window=duration),
    )


@pytest.mark.slow
def test_predicted_attitude_error_with_four_magnetometers_is_achieved():
    """The magnetometers share one field error.

    With independent field errors, 0.083 deg would be predicted and 0.138 deg achieved.
    """
    scenario = build_scenario(4, EnvironmentErrors(field_error_nt=150.0))
    result = simulate(scenario, PLAN, 240, seed=11)
    is_converged = result.times >= 600.0
    achieved = np.sqrt(np.mean(result.errors[:, is_converged, :3] ** 2))
    predicted = np.sqrt(np.mean(result.predicted_sigma[is_converged, :3] ** 2))
    assert achieved / predicted == pytest.approx(1.0, abs=0.05)
