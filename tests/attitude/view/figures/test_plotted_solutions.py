"""Selection of the plans that figures show."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.view.figures.style import PlottedSolutions

from mgeo.runs.summary import find_knee


def build_solutions(F):
    F = np.asarray(F, dtype=float)
    n = len(F)
    labels = tuple(f"plan {i}" for i in range(n))
    return PlottedSolutions(np.arange(n), np.arange(12.0 * n).reshape(n, 12), F, F[:, 0], labels)


def test_min_time_knee_and_min_trace_are_selected():
    # The knee (2, 3) lies farthest below the line from (0, 10) to (10, 0).
    F = [[10, 0], [8, 1], [0, 10], [9, 9], [2, 3], [5, 2], [1, 6]]
    selected = build_solutions(F).select_representative(find_knee(np.array(F, dtype=float)))
    assert selected.labels == ("plan 2, min-time", "plan 4, knee", "plan 0, min-trace")
    np.testing.assert_array_equal(selected.numbers, [2, 4, 0])
    np.testing.assert_array_equal(selected.F, [[0, 10], [2, 3], [10, 0]])
    np.testing.assert_array_equal(selected.X[:, 0], [24, 48, 0])


def test_plans_with_lost_covariance_are_left_out():
    problem = AttitudeManeuverProblem()
    sigma = problem.model.initial_sigma * 1e6
    problem.__dict__["model"] = dataclasses.replace(problem.model, initial_sigma=sigma)
    designs = np.random.default_rng(10).uniform(problem.xl, problem.xu, (8, 12))[::-1]
    with pytest.warns(RuntimeWarning, match="lost positive definiteness"):
        solutions = PlottedSolutions.from_plans(problem.view(designs))
    with pytest.warns(RuntimeWarning, match="lost positive definiteness"):
        expected = np.flatnonzero(np.isfinite(problem.evaluate(designs)[:, 0]))
    assert 0 < len(expected) < 8
    assert expected[0] != 0  # Otherwise rows and numbers could not be distinguished.
    np.testing.assert_array_equal(solutions.numbers, expected)
    np.testing.assert_array_equal(solutions.X, designs[expected])
    lost = np.setdiff1d(np.arange(8), expected)
    with (
        pytest.warns(RuntimeWarning, match="lost positive definiteness"),
        pytest.raises(ValueError, match="expected at least one design with finite objectives"),
    ):
        PlottedSolutions.from_plans(problem.view(designs[lost]))
