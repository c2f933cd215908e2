"""The compiled filter's history is filterpy's, and `agreement` tells when it is not."""

import dataclasses

import numpy as np
from mgeo_attitude import FilterModel, compare_filters, evaluate, run_filter
from mgeo_attitude.scenario import Convergence

from .agreement import assert_same_history, designs


def test_a_run_that_does_not_converge_says_so(short):
    model = FilterModel.from_scenario(
        dataclasses.replace(short, convergence=Convergence(window=short.duration))
    )
    history = run_filter(model, [0.1] * 12)
    assert not history.converged
    assert history.t_end == short.duration
    assert_same_history(model, [0.1] * 12)


def test_filters_of_other_models_do_not_agree(short, monkeypatch):
    """What `agreement` finds is real: another noise is another covariance, and another end."""
    model = FilterModel.from_scenario(short)
    X = designs(np.random.default_rng(6), 2, 300.0)
    found = compare_filters(model, X)
    assert found.has_equal_ends
    assert found.max_difference < 1e-9
    assert found.n_samples > 2 * 60
    noisy = dataclasses.replace(
        short.gyro,
        angle_random_walk_deg_per_sqrt_h=9.0 * short.gyro.angle_random_walk_deg_per_sqrt_h,
    )
    other = FilterModel.from_scenario(dataclasses.replace(short, gyro=noisy))
    monkeypatch.setattr(
        "mgeo_attitude.filter.reference.evaluate", lambda _, *a, **k: evaluate(other, *a, **k)
    )
    found = compare_filters(model, X)
    assert not found.has_equal_ends
    assert found.max_difference > 0.01
