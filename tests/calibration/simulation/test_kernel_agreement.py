"""Covariance of the filter in a simulation without errors, compared with the covariance of the
kernel.
"""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario, evaluate
from mgeo_attitude.maneuvers.actuation import SlewLimits
from mgeo_attitude.scenario import Convergence
from mgeo_calibration import FilterSettings

from ...attitude.filter.suites import SUITES
from ..simulators.runs import build_zero_errors, run_filter

PLAN = np.array([0.5, -0.3, 0.8, 80.3, -0.7, 0.9, 0.1, 60.0, 0.2, 0.4, -0.9, 500.0])
STEPS = 160  # steps of 1 s, until the third maneuver has begun


@pytest.fixture(scope="module", params=["every constant", "orbit error", "considered"])
def model(request):
    scenario = dataclasses.replace(
        Scenario.cubesat_6u(), duration=STEPS, convergence=Convergence(window=STEPS)
    )
    suite = SUITES[request.param]
    scenario = dataclasses.replace(
        scenario,
        gyro=suite.gyro,
        sensors=suite.sensors,
        environment_errors=suite.environment_errors,
    )
    return FilterModel.from_scenario(scenario)


@pytest.mark.cases(1)
def test_variances_without_errors_equal_kernel(model):
    statistics = run_filter(
        model,
        PLAN,
        np.arange(STEPS + 1),
        build_zero_errors(model, STEPS),
        FilterSettings.build_textbook(),
    )
    kernel = evaluate(model, PLAN, history=True).variances[0]
    np.testing.assert_allclose(statistics.sigma[0] ** 2, kernel, rtol=1e-9)
    np.testing.assert_allclose(statistics.errors, 0.0, atol=1e-12)


@pytest.mark.cases(1)
def test_variances_with_ramps_shorter_than_a_step_equal_kernel(model):
    ramped = dataclasses.replace(model, slew_limits=SlewLimits(np.radians(1.7), np.inf, np.eye(3)))
    statistics = run_filter(
        ramped,
        PLAN,
        np.arange(STEPS + 1),
        build_zero_errors(ramped, STEPS),
        FilterSettings.build_textbook(),
    )
    kernel = evaluate(ramped, PLAN, history=True).variances[0]
    np.testing.assert_allclose(statistics.sigma[0] ** 2, kernel, rtol=1e-9)
    assert not np.allclose(
        statistics.sigma[0] ** 2, evaluate(model, PLAN, history=True).variances[0]
    )
