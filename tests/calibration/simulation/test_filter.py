"""Many runs at once against one run at a time, written differently."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.geometry.rotation import matrix
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario import Convergence
from mgeo_attitude.sensors.readings import Readings
from mgeo_calibration import Estimator
from mgeo_calibration.estimation.innovation import Estimate
from mgeo_calibration.flight.flight import draw
from mgeo_calibration.simulation.filter import ErrorStateFilter, whiten

from ..flight import runs
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
    ahead = Motion.of(wide, PLAN, STEPS).attitude[30] @ wide.references[30, 0]
    sun, *others = scenario.sensors
    narrow = dataclasses.replace(sun, boresight=tuple(ahead), half_angle_deg=20.0)
    model = FilterModel.from_scenario(dataclasses.replace(scenario, sensors=(narrow, *others)))
    generators = np.random.default_rng(8).spawn(RUNS)
    flights = [runs.flown(model, PLAN, draw(model, STEPS, generator)) for generator in generators]
    return model, [flight.readings for flight in flights], flights[0].motion.rates


@pytest.mark.cases(1, 3)
@pytest.mark.parametrize(
    "estimator",
    [
        Estimator(),
        Estimator.plain(),
        Estimator(second_order=False),
        Estimator(reset=False),
    ],
)
def test_runs_side_by_side_are_those_one_by_one(flown, estimator):
    model, readings, rates = flown
    seen = ~np.isnan([run.sensors[0][1:, 0, 0] for run in readings]).T
    assert 0 < seen.sum() < seen.size
    assert (seen.any(axis=1) & ~seen.all(axis=1)).any()
    filter_ = ErrorStateFilter(model.suite, estimator)
    start = Estimate.at_start(model, RUNS)
    run = filter_.run(start, readings, rates, model.references)
    found = [after for _, after, _ in run]
    sigma = model.initial_sigma
    for run in range(RUNS):
        expected = naive.estimates(model, readings[run], rates, estimator)
        for estimate, (C, x, P) in zip(found, expected, strict=True):
            error = estimate.error(C[:, :, None].repeat(RUNS, 2), x[:, None].repeat(RUNS, 1))
            np.testing.assert_allclose(error[:, run] / sigma, 0.0, atol=1e-10)
            scaled = (estimate.covariance[:, :, run] - P) / np.outer(sigma, sigma)
            np.testing.assert_allclose(scaled, 0.0, atol=1e-11)


def test_steps_may_be_of_any_length_and_the_start_any_attitude():
    """Readings of nobody's simulation: every third sample and where rates change, axes turned."""
    model = FilterModel.from_scenario(short(Scenario.paper()))
    flight = runs.flown(model, PLAN, runs.none(model, STEPS))
    kept = np.array(sorted({*range(0, STEPS + 1, 3), 21, 41}))
    left_out = np.setdiff1d(np.arange(STEPS + 1), kept)
    every, rates = flight.readings, flight.motion.rates
    for sensor in every.sensors:
        sensor[left_out] = np.nan
    few = Readings(
        np.diff(kept) * model.step, every.gyro[kept[:-1]], tuple(s[kept] for s in every.sensors)
    )
    turn = matrix(np.array([0.7, -1.9, 0.4]))
    filter_ = ErrorStateFilter(model.suite, Estimator.plain())
    start = Estimate.at_start(model)
    turned = Estimate.at_start(dataclasses.replace(model, initial_attitude=turn))
    fine = [e for _, e, _ in filter_.run(start, [every], rates, model.references)]
    coarse = filter_.run(turned, [few], rates[kept[:-1]], model.references[kept] @ turn)
    for k, (_, estimate, _) in zip(kept, coarse, strict=True):
        scale = np.sqrt(np.einsum("ii...->i...", fine[k].covariance))
        difference = estimate.covariance - fine[k].covariance
        np.testing.assert_allclose(difference / scale / scale[:, None], 0.0, atol=1e-11)
        attitude = estimate.rotations[:, :, 0, 0].T @ turn.T
        np.testing.assert_allclose(attitude, flight.motion.attitude[k], rtol=0, atol=1e-12)


def test_an_estimate_without_its_error_is_the_truth(flown):
    model, readings, rates = flown
    filter_ = ErrorStateFilter(model.suite, Estimator())
    start = Estimate.at_start(model, RUNS)
    *_, (_, after, _) = filter_.run(start, readings, rates, model.references)
    rng = np.random.default_rng(0)
    attitude, states = matrix(rng.standard_normal((3, RUNS))), rng.standard_normal((18, RUNS))
    states[:3] = 0.0
    true = after.corrected(after.error(attitude, states), after.covariance)
    np.testing.assert_allclose(true.error(attitude, states), 0.0, atol=1e-13)


def test_whitening_is_by_the_cholesky_factor():
    rng = np.random.default_rng(1)
    root, HP, z = (
        rng.standard_normal((3, 3)),
        rng.standard_normal((3, 5, 1)),
        rng.standard_normal((3, 1)),
    )
    S = root @ root.T
    G, w = whiten(S[..., None], HP, z)
    L = np.linalg.cholesky(S)
    np.testing.assert_allclose(L @ G[..., 0], HP[..., 0], rtol=1e-12)
    np.testing.assert_allclose(L @ w[:, 0], z[:, 0], rtol=1e-12)
    assert np.isnan(whiten(-S[..., None], HP, z)[1]).all()
