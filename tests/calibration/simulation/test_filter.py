"""Filter of many simultaneous runs, compared with an independent filter of one run at a time."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario import Convergence
from mgeo_calibration import FilterSettings
from mgeo_calibration.estimation.innovation import Estimate
from mgeo_calibration.simulation.filter import ErrorStateFilter
from mgeo_calibration.simulators.simulated_run import draw_errors

from ..simulators import runs
from . import naive

PLAN = np.array([0.5, -0.3, 0.8, 20.3, -0.7, 0.9, 0.1, 20.0, 0.2, 0.4, -0.9, 500.0])
STEPS, RUNS = 60, 2


def shorten(scenario):
    return dataclasses.replace(
        scenario, duration=float(STEPS), convergence=Convergence(window=float(STEPS))
    )


@pytest.fixture(
    scope="module", params=["paper", pytest.param("cubesat_6u", marks=pytest.mark.slow)]
)
def simulated_runs(request):
    """Model, measurements and rates of runs in which the Sun passes the field of view at different
    times.
    """
    scenario = shorten(getattr(Scenario, request.param)())
    wide_model = FilterModel.from_scenario(scenario)
    boresight = (
        Motion.from_design(wide_model, PLAN, STEPS).attitude[30] @ wide_model.references[30, 0]
    )
    sun, *others = scenario.sensors
    narrow_sensor = dataclasses.replace(sun, boresight=tuple(boresight), half_angle_deg=20.0)
    model = FilterModel.from_scenario(
        dataclasses.replace(scenario, sensors=(narrow_sensor, *others))
    )
    generators = np.random.default_rng(8).spawn(RUNS)
    flown_runs = [
        runs.simulate_motion(model, PLAN, draw_errors(model, STEPS, generator))
        for generator in generators
    ]
    return model, [flight.readings for flight in flown_runs], flown_runs[0].motion.rates


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    "estimator",
    [
        FilterSettings(),
        FilterSettings.build_textbook(),
        FilterSettings(second_order=False),
    ],
)
def test_simultaneous_runs_equal_single_runs(simulated_runs, estimator):
    model, readings, rates = simulated_runs
    has_reading = ~np.isnan([run.sensors[0][1:, 0, 0] for run in readings]).T
    assert 0 < has_reading.sum() < has_reading.size
    assert (has_reading.any(axis=1) & ~has_reading.all(axis=1)).any()
    filter_ = ErrorStateFilter(model.suite, estimator)
    start = Estimate.from_model(model, RUNS)
    run = filter_.run(start, readings, rates, model.references)
    estimates = [after for _, after, _ in run]
    sigma = model.initial_sigma
    for run in range(RUNS):
        expected = naive.run_filter(model, readings[run], rates, estimator)
        for estimate, (C, x, P) in zip(estimates, expected, strict=True):
            error = estimate.compute_errors(
                C[:, :, None].repeat(RUNS, 2), x[:, None].repeat(RUNS, 1)
            )
            np.testing.assert_allclose(error[:, run] / sigma, 0.0, atol=1e-10)
            scaled = (estimate.covariance[:, :, run] - P) / np.outer(sigma, sigma)
            np.testing.assert_allclose(scaled, 0.0, atol=1e-11)
