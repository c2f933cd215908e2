"""Many runs at once against one run at a time, written differently."""

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


def short(scenario):
    return dataclasses.replace(
        scenario, duration=float(STEPS), convergence=Convergence(window=float(STEPS))
    )


@pytest.fixture(
    scope="module", params=["paper", pytest.param("cubesat_6u", marks=pytest.mark.slow)]
)
def flown(request):
    """A model, and flights in which the Sun passes the Sun sensor's view, not in all at once."""
    scenario = short(getattr(Scenario, request.param)())
    wide = FilterModel.from_scenario(scenario)
    ahead = Motion.from_design(wide, PLAN, STEPS).attitude[30] @ wide.references[30, 0]
    sun, *others = scenario.sensors
    narrow = dataclasses.replace(sun, boresight=tuple(ahead), half_angle_deg=20.0)
    model = FilterModel.from_scenario(dataclasses.replace(scenario, sensors=(narrow, *others)))
    generators = np.random.default_rng(8).spawn(RUNS)
    flights = [
        runs.simulate_motion(model, PLAN, draw_errors(model, STEPS, generator))
        for generator in generators
    ]
    return model, [flight.readings for flight in flights], flights[0].motion.rates


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    "estimator",
    [
        FilterSettings(),
        FilterSettings.build_textbook(),
        FilterSettings(second_order=False),
    ],
)
def test_runs_side_by_side_are_those_one_by_one(flown, estimator):
    model, readings, rates = flown
    seen = ~np.isnan([run.sensors[0][1:, 0, 0] for run in readings]).T
    assert 0 < seen.sum() < seen.size
    assert (seen.any(axis=1) & ~seen.all(axis=1)).any()
    filter_ = ErrorStateFilter(model.suite, estimator)
    start = Estimate.from_model(model, RUNS)
    run = filter_.run(start, readings, rates, model.references)
    found = [after for _, after, _ in run]
    sigma = model.initial_sigma
    for run in range(RUNS):
        expected = naive.estimates(model, readings[run], rates, estimator)
        for estimate, (C, x, P) in zip(found, expected, strict=True):
            error = estimate.compute_errors(
                C[:, :, None].repeat(RUNS, 2), x[:, None].repeat(RUNS, 1)
            )
            np.testing.assert_allclose(error[:, run] / sigma, 0.0, atol=1e-10)
            scaled = (estimate.covariance[:, :, run] - P) / np.outer(sigma, sigma)
            np.testing.assert_allclose(scaled, 0.0, atol=1e-11)
