"""Runs that go on from a calibration: the kernel, its reference, and a run that is cut in two."""

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
    """Eclipses, ramps and a field of view: all that an attitude enters."""
    table = {
        "preset": "cubesat_6u",
        "duration": 1200.0,
        "step": 2.0,
        "convergence": {"rule": "trace", "window": 60.0, "relative_decrease": 0.05},
        "maneuvers": {"count": 3, "max_acceleration_deg_s2": 0.05},
        "sensors": [{"kind": "sun-sensor", "half_angle_deg": 80.0}, {"kind": "magnetometer"}],
    }
    return Scenario.from_dict(table | changes)


def known(of, rng, share=0.3):
    """The scenario after a calibration that left a share of 1-sigmas, all of them correlated."""
    n = of.suite.n_states
    sigma = share * FilterModel.from_scenario(of).initial_sigma
    mixed = rng.standard_normal((n, n)) + 2.0 * np.eye(n)
    correlation = mixed @ mixed.T
    scale = sigma / np.sqrt(np.diag(correlation))
    covariance = scale[:, None] * correlation * scale
    prior = Prior(
        quaternion=Rotation.random(rng=rng).as_quat().tolist(),
        rate_deg_s=(0.3, -0.2, 0.4),
        states=(sigma * rng.standard_normal(n))[3:].reshape(-1, 3).tolist(),
        covariance=(0.5 * (covariance + covariance.T)).tolist(),
    )
    return dataclasses.replace(of, prior=prior)


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
def test_kernel_and_reference_agree(changes):
    rng = np.random.default_rng(3)
    of = known(scenario(**changes), rng)
    model = FilterModel.from_scenario(of)
    assert np.abs(model.initial_correlation - np.eye(model.suite.n_states)).max() > 0.3
    np.testing.assert_allclose(
        model.initial_covariance, np.array(of.prior.covariance), rtol=1e-12, atol=1e-30
    )
    assert_agrees(model, designs(rng, 5, max_duration=300.0))
    alone = dataclasses.replace(model, initial_correlation=np.eye(model.suite.n_states))
    X = designs(rng, 3, max_duration=300.0)
    assert not np.allclose(evaluate(alone, X).trace, evaluate(model, X).trace, rtol=1e-3)


def test_covariance_at_the_end_is_the_reference_s():
    rng = np.random.default_rng(4)
    model = FilterModel.from_scenario(known(scenario(), rng))
    X = designs(rng, 3, max_duration=300.0)
    for x, P in zip(X, evaluate(model, X, covariance=True).covariance, strict=True):
        expected = run_reference_filter(model, x).covariance
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(P / scale, expected / scale, rtol=0, atol=1e-9)


def test_a_run_that_is_cut_in_two_is_the_whole_run():
    """The second part, from covariance and attitude where the first one ends, by the kernel."""
    of = scenario(maneuvers={"count": 3}, convergence={"rule": "trace", "window": 1200.0})
    model = FilterModel.from_scenario(of)
    x = np.array([0.5, 0.3, -0.2, 200.0, -0.3, 0.6, 0.2, 250.0, 0.2, -0.4, 0.7, 300.0])
    whole = evaluate(model, x[None], covariance=True).covariance[0]
    k = 225  # steps of 2 s: the first two maneuvers
    tables = ("references", "available", "directions", "radii")
    until = {name: getattr(model, name)[: k + 1] for name in tables}
    since = {name: getattr(model, name)[k:] for name in tables}
    first = run_reference_filter(dataclasses.replace(model, **until), x)
    assert first.times[-1] == 450.0
    sigma = first.sigma[-1]
    rest = dataclasses.replace(
        model,
        **since,
        initial_sigma=sigma,
        initial_correlation=first.covariance / np.outer(sigma, sigma),
        initial_attitude=first.attitude[-1],
        window_steps=600 - k,
    )
    later = np.array([0.2, -0.4, 0.7, 300.0])
    found = evaluate(rest, later[None], covariance=True).covariance[0]
    scale = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
    np.testing.assert_allclose(found / scale, whole / scale, rtol=0, atol=1e-9)


def test_objectives_count_from_what_is_known():
    """At the start all that is relative to it is 1, and the logarithm of 1."""
    rng = np.random.default_rng(5)
    names = ("normalized_trace", "log_det", "max_eigenvalue")
    of = dataclasses.replace(known(scenario(), rng), objectives=names)
    problem = AttitudeManeuverProblem(of)
    model = problem.model
    P = model.initial_covariance[None]
    start = SimpleNamespace(covariance=P)
    assert OBJECTIVES["log_det"].value(model, start)[0] == pytest.approx(0.0, abs=1e-12)
    assert OBJECTIVES["normalized_trace"].value(model, start)[0] == pytest.approx(1.0)
