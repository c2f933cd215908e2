"""Time history of the compiled filter, and detection of differences from filterpy."""

import dataclasses

import numpy as np
from mgeo_attitude import FilterModel, compare_filters, evaluate, run_filter
from mgeo_attitude.scenario import Convergence

from .agreement import assert_same_history, designs


def test_history_reports_missing_convergence(short):
    model = FilterModel.from_scenario(
        dataclasses.replace(short, convergence=Convergence(window=short.duration))
    )
    history = run_filter(model, [0.1] * 12)
    assert not history.converged
    assert history.t_end == short.duration
    assert_same_history(model, [0.1] * 12)


def test_comparison_detects_different_models(short, monkeypatch):
    model = FilterModel.from_scenario(short)
    X = designs(np.random.default_rng(6), 2, 300.0)
    agreement = compare_filters(model, X)
    assert agreement.has_equal_ends
    assert agreement.max_difference < 1e-9
    assert agreement.n_samples > 2 * 60
    noisy = dataclasses.replace(
        short.gyro,
        angle_random_walk_deg_per_sqrt_h=9.0 * short.gyro.angle_random_walk_deg_per_sqrt_h,
    )
    other = FilterModel.from_scenario(dataclasses.replace(short, gyro=noisy))
    monkeypatch.setattr(
        "mgeo_attitude.filter.reference.evaluate", lambda _, *a, **k: evaluate(other, *a, **k)
    )
    agreement = compare_filters(model, X)
    assert not agreement.has_equal_ends
    assert agreement.max_difference > 0.01
