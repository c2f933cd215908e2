"""Convergence rules that need a complete run."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, evaluate, run_reference_filter

from .agreement import assert_agrees, assert_same_history, designs

REQUIRED = {"gyro.bias_deg_h": 20.0, "attitude_deg": 1.5}


def build_model(short, rule, **more):
    convergence = dataclasses.replace(short.convergence, rule=rule, **more)
    scenario = dataclasses.replace(short, convergence=convergence, required_sigma=REQUIRED)
    return FilterModel.from_scenario(scenario)


@pytest.fixture(scope="module")
def X():
    return designs(np.random.default_rng(21), 16, max_duration=300.0)


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["required", "settling", "end"])
def test_filters_agree_on_end_for_each_rule(short, rule, X):
    model = build_model(short, rule)
    assert_agrees(model, X)
    result = evaluate(model, X, covariance=True)
    assert len(set(result.t_end)) > 4
    for x, covariance in zip(X[:3], result.covariance, strict=False):
        expected = run_reference_filter(model, x).covariance
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(covariance / scale, expected / scale, atol=1e-9)
    assert_same_history(model, X[0])


def test_rule_required_ends_when_all_sigmas_stay_satisfied(short, X):
    model = build_model(short, "required")
    result, complete = evaluate(model, X), evaluate(model.full_duration_model, X)
    longest = model.step * model.n_steps
    maneuver_end = model.step * np.minimum(
        model.build_schedule(X).maneuver_end_steps, model.n_steps
    )
    np.testing.assert_array_equal(
        result.t_end, np.clip(np.maximum(complete.t_required, maneuver_end), 0.0, longest)
    )
    is_satisfied = np.isfinite(complete.t_required)
    assert 0 < is_satisfied.sum() < len(X)
    for x in X[~is_satisfied]:
        history = run_reference_filter(model, x)
        assert (history.t_end, history.converged) == (longest, False)


def test_rule_end_stops_with_last_maneuver(short, X):
    model = build_model(short, "end")
    X = np.vstack([X, 0.0 * X[0]])
    X[0, 3::4], X[1, 3::4] = [600.0, 600.0, 50.0], [99.0, 0.5, 0.5]
    result = evaluate(model, X)
    expected = np.ceil(X[:, 3::4].sum(axis=1) / model.step) * model.step
    np.testing.assert_array_equal(result.t_end, np.clip(expected, model.step, model.duration))
    assert (result.t_end[[0, 1, -1]] == [model.duration, 100.0, model.step]).all()


def test_run_until_step_equals_start_of_complete_run(short, X):
    model = build_model(short, "trace")
    complete = evaluate(model.full_duration_model, X, history=True)
    until = np.r_[1, 7, 300, 600, np.arange(40, 40 + 12 * 37, 37)]
    result = evaluate(model, X, covariance=True, end_steps=until)
    np.testing.assert_array_equal(result.t_end, model.step * until)
    variances = complete.variances[np.arange(len(X)), until]
    np.testing.assert_array_equal(np.diagonal(result.covariance, axis1=1, axis2=2), variances)
    np.testing.assert_allclose(result.trace, variances @ model.weights, rtol=1e-14)


def test_equal_plans_may_have_different_end_steps(short, X):
    model = build_model(short, "trace")
    until = np.array([500, 20, 90, 500, 600])
    together = evaluate(model, np.repeat(X[:1], 5, axis=0), end_steps=until)
    separate = [evaluate(model, X[0], end_steps=each).trace[0] for each in until]
    np.testing.assert_array_equal(together.trace, separate)
