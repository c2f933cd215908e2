"""Convergence curves against runs of filterpy."""

import numpy as np
import pytest
from mgeo_attitude import run_reference_filter
from mgeo_attitude.view.figures.style import PlottedSolutions
from mgeo_attitude.view.figures.time_series import compute_convergence_curves

DEG = 180.0 / np.pi
FACTORS = [DEG, DEG * 3600.0, DEG, DEG * 60.0, DEG, 50e3]


@pytest.fixture(scope="module")
def solutions(problem, X):
    return PlottedSolutions.from_plans(problem.view(X[:2]))


def test_curves_equal_those_of_the_reference_filter(problem, solutions):
    for x, (times, values) in zip(
        solutions.X, compute_convergence_curves(problem, solutions), strict=True
    ):
        history = run_reference_filter(problem.model, x)
        steps = times.astype(int)
        np.testing.assert_array_equal(times, history.times[steps])
        assert times[-1] == history.t_end
        np.testing.assert_allclose(values[0], history.trace[steps], rtol=1e-9)
        worst = history.sigma[steps].reshape(-1, 6, 3).max(axis=2)
        np.testing.assert_allclose(values[1:].T, worst * FACTORS, rtol=1e-9)
