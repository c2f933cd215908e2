"""Runs that continue after an earlier calibration."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from mgeo_attitude import (
    AttitudeManeuverProblem,
    FilterModel,
    Scenario,
    evaluate,
    run_reference_filter,
)
from mgeo_attitude.criteria.objectives import OBJECTIVES
from mgeo_attitude.scenario import Prior
from scipy.spatial.transform import Rotation

from .agreement import assert_agrees, designs


def scenario(**changes):
    """Return a scenario with ramps and a field of view, which depend on the attitude."""
    table = {
        "preset": "cubesat_6u",
        "duration": 1200.0,
        "step": 2.0,
        "convergence": {"rule": "trace", "window": 60.0, "relative_decrease": 0.05},
        "maneuvers": {"count": 3, "max_acceleration_deg_s2": 0.05},
        "sensors": [{"kind": "sun-sensor", "half_angle_deg": 80.0}, {"kind": "magnetometer"}],
    }
    return Scenario.from_dict(table | changes)


def add_prior(base, rng, share=0.3):
    """Return the scenario with a prior of reduced and correlated uncertainty."""
    n = base.suite.n_states
    sigma = share * FilterModel.from_scenario(base).initial_sigma
    factor = rng.standard_normal((n, n)) + 2.0 * np.eye(n)
    correlation = factor @ factor.T
    scale = sigma / np.sqrt(np.diag(correlation))
    covariance = scale[:, None] * correlation * scale
    prior = Prior(
        quaternion=Rotation.random(rng=rng).as_quat().tolist(),
        rate_deg_s=(0.3, -0.2, 0.4),
        states=(sigma * rng.standard_normal(n))[3:].reshape(-1, 3).tolist(),
        covariance=(0.5 * (covariance + covariance.T)).tolist(),
    )
    return dataclasses.replace(base, prior=prior)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {
            "maneuvers": {"count": 3},
            "gyro": {"initial_scale_factor": 1e-3, "initial_misalignment_deg": 0.1},
        },
        {
            "sensors": [
                {"kind": "sun-sensor", "sample_interval": 4.0},
                {
                    "kind": "magnetometer",
                    "initial_scale_factor": 0.02,
                    "considered": ["scale_factor"],
                },
            ],
            "environment_errors": {
                "albedo": 0.05,
                "field_error_nt": 100.0,
                "orbit_error_m": [1000.0, 100.0, 100.0],
                "considered": ["orbit_error"],
            },
        },
    ],
    ids=["full gyro", "varying and considered"],
)
def test_filters_agree_after_calibration(changes):
    rng = np.random.default_rng(3)
    scenario_with_prior = add_prior(scenario(**changes), rng)
    model = FilterModel.from_scenario(scenario_with_prior)
    assert np.abs(model.initial_correlation - np.eye(model.suite.n_states)).max() > 0.3
    np.testing.assert_allclose(
        model.initial_covariance,
        np.array(scenario_with_prior.prior.covariance),
        rtol=1e-12,
        atol=1e-30,
    )
    assert_agrees(model, designs(rng, 5, max_duration=300.0))
    uncorrelated = dataclasses.replace(model, initial_correlation=np.eye(model.suite.n_states))
    X = designs(rng, 3, max_duration=300.0)
    assert not np.allclose(evaluate(uncorrelated, X).trace, evaluate(model, X).trace, rtol=1e-3)


def test_final_covariance_equals_reference():
    rng = np.random.default_rng(4)
    model = FilterModel.from_scenario(add_prior(scenario(), rng))
    X = designs(rng, 3, max_duration=300.0)
    for x, P in zip(X, evaluate(model, X, covariance=True).covariance, strict=True):
        expected = run_reference_filter(model, x).covariance
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(P / scale, expected / scale, rtol=0, atol=1e-9)


def test_split_run_equals_complete_run():
    """The second part starts from the covariance and attitude at the end of the first part."""
    base = scenario(maneuvers={"count": 3}, convergence={"rule": "trace", "window": 1200.0})
    model = FilterModel.from_scenario(base)
    x = np.array([0.5, 0.3, -0.2, 200.0, -0.3, 0.6, 0.2, 250.0, 0.2, -0.4, 0.7, 300.0])
    complete = evaluate(model, x[None], covariance=True).covariance[0]
    k = 225  # end of the first two maneuvers, in steps of 2 s
    tables = ("references", "available", "directions", "radii")
    until = {name: getattr(model, name)[: k + 1] for name in tables}
    since = {name: getattr(model, name)[k:] for name in tables}
    first = run_reference_filter(dataclasses.replace(model, **until), x)
    assert first.times[-1] == 450.0
    sigma = first.sigma[-1]
    second_model = dataclasses.replace(
        model,
        **since,
        initial_sigma=sigma,
        initial_correlation=first.covariance / np.outer(sigma, sigma),
        initial_attitude=first.attitude[-1],
        window_steps=600 - k,
    )
    second_design = np.array([0.2, -0.4, 0.7, 300.0])
    second_covariance = evaluate(second_model, second_design[None], covariance=True).covariance[0]
    scale = np.sqrt(np.outer(np.diag(complete), np.diag(complete)))
    np.testing.assert_allclose(second_covariance / scale, complete / scale, rtol=0, atol=1e-9)


def test_normalized_objectives_are_relative_to_prior():
    rng = np.random.default_rng(5)
    names = ("normalized_trace", "log_det", "max_eigenvalue")
    scenario_with_prior = dataclasses.replace(add_prior(scenario(), rng), objectives=names)
    problem = AttitudeManeuverProblem(scenario_with_prior)
    model = problem.model
    P = model.initial_covariance[None]
    start = SimpleNamespace(covariance=P)
    assert OBJECTIVES["log_det"].value(model, start)[0] == pytest.approx(0.0, abs=1e-12)
    assert OBJECTIVES["normalized_trace"].value(model, start)[0] == pytest.approx(1.0)
