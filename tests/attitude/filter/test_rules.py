"""Rules of convergence that a whole run tells: what the kernel finds, against the reference."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, evaluate, run_reference_filter

from .agreement import assert_agrees, assert_same_history, designs

REQUIRED = {"gyro.bias_deg_h": 20.0, "attitude_deg": 1.5}


def ruled(short, rule, **more):
    convergence = dataclasses.replace(short.convergence, rule=rule, **more)
    scenario = dataclasses.replace(short, convergence=convergence, required_sigma=REQUIRED)
    return FilterModel.from_scenario(scenario)


@pytest.fixture(scope="module")
def X():
    return designs(np.random.default_rng(21), 16, max_duration=300.0)


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["required", "settling", "end"])
def test_the_kernel_ends_where_the_reference_does(short, rule, X):
    model = ruled(short, rule)
    assert_agrees(model, X)
    result = evaluate(model, X, covariance=True)
    assert len(set(result.t_end)) > 4
    for x, covariance in zip(X[:3], result.covariance, strict=False):
        expected = run_reference_filter(model, x).covariance
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(covariance / scale, expected / scale, atol=1e-9)
    assert_same_history(model, X[0])


def test_required_is_the_time_from_which_on_all_is_met(short, X):
    model = ruled(short, "required")
    result, whole = evaluate(model, X), evaluate(model.full_duration_model, X)
    longest = model.step * model.n_steps
    over = model.step * np.minimum(model.build_schedule(X).maneuver_end_steps, model.n_steps)
    np.testing.assert_array_equal(
        result.t_end, np.clip(np.maximum(whole.t_required, over), 0.0, longest)
    )
    met = np.isfinite(whole.t_required)
    assert 0 < met.sum() < len(X)
    for x in X[~met]:
        history = run_reference_filter(model, x)
        assert (history.t_end, history.converged) == (longest, False)


def test_a_plan_ends_with_its_last_maneuver_or_with_the_run(short, X):
    model = ruled(short, "end")
    X = np.vstack([X, 0.0 * X[0]])
    X[0, 3::4], X[1, 3::4] = [600.0, 600.0, 50.0], [99.0, 0.5, 0.5]
    result = evaluate(model, X)
    expected = np.ceil(X[:, 3::4].sum(axis=1) / model.step) * model.step
    np.testing.assert_array_equal(result.t_end, np.clip(expected, model.step, model.duration))
    assert (result.t_end[[0, 1, -1]] == [model.duration, 100.0, model.step]).all()


def test_a_run_until_a_step_is_the_beginning_of_the_whole_one(short, X):
    model = ruled(short, "trace")
    whole = evaluate(model.full_duration_model, X, history=True)
    until = np.r_[1, 7, 300, 600, np.arange(40, 40 + 12 * 37, 37)]
    result = evaluate(model, X, covariance=True, end_steps=until)
    np.testing.assert_array_equal(result.t_end, model.step * until)
    variances = whole.variances[np.arange(len(X)), until]
    np.testing.assert_array_equal(np.diagonal(result.covariance, axis1=1, axis2=2), variances)
    np.testing.assert_allclose(result.trace, variances @ model.weights, rtol=1e-14)


def test_one_plan_may_end_at_several_steps(short, X):
    model = ruled(short, "trace")
    until = np.array([500, 20, 90, 500, 600])
    together = evaluate(model, np.repeat(X[:1], 5, axis=0), end_steps=until)
    alone = [evaluate(model, X[0], end_steps=each).trace[0] for each in until]
    np.testing.assert_array_equal(together.trace, alone)
