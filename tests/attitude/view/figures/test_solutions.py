"""Which solutions are shown, and which are looked at closely."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.view.figures.style import PlottedSolutions

from mgeo.runs.summary import find_knee


def made_up(F):
    F = np.asarray(F, dtype=float)
    n = len(F)
    labels = tuple(f"solution {i}" for i in range(n))
    return PlottedSolutions(np.arange(n), np.arange(12.0 * n).reshape(n, 12), F, F[:, 0], labels)


def test_fastest_knee_and_least_trace_are_chosen():
    # by distance below the line from (0, 10) to (10, 0), (2, 3) is the knee
    F = [[10, 0], [8, 1], [0, 10], [9, 9], [2, 3], [5, 2], [1, 6]]
    few = made_up(F).select_representative(find_knee(np.array(F, dtype=float)))
    assert few.labels == (
        "solution 2 (min-time)",
        "solution 4 (knee)",
        "solution 0 (min-trace)",
    )
    np.testing.assert_array_equal(few.numbers, [2, 4, 0])
    np.testing.assert_array_equal(few.F, [[0, 10], [2, 3], [10, 0]])
    np.testing.assert_array_equal(few.X[:, 0], [24, 48, 0])


def test_broken_covariances_are_left_out():
    problem = AttitudeManeuverProblem()
    sigma = problem.model.initial_sigma * 1e6
    problem.__dict__["model"] = dataclasses.replace(problem.model, initial_sigma=sigma)
    designs = np.random.default_rng(10).uniform(problem.xl, problem.xu, (8, 12))[::-1]
    with pytest.warns(RuntimeWarning, match="lost positivity"):
        solutions = PlottedSolutions.from_plans(problem.view(designs))
    with pytest.warns(RuntimeWarning, match="lost positivity"):
        expected = np.flatnonzero(np.isfinite(problem.evaluate(designs)[:, 0]))
    assert 0 < len(expected) < 8
    assert expected[0] != 0  # or the numbers would tell nothing
    np.testing.assert_array_equal(solutions.numbers, expected)
    np.testing.assert_array_equal(solutions.X, designs[expected])
    lost = np.setdiff1d(np.arange(8), expected)
    with (
        pytest.warns(RuntimeWarning, match="lost positivity"),
        pytest.raises(ValueError, match="expected at least one design with finite objectives"),
    ):
        PlottedSolutions.from_plans(problem.view(designs[lost]))
