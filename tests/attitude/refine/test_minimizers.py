"""Minimizers as generators: quasi-Newton within bounds, and SLSQP of scipy within constraints."""

import threading

import numpy as np
import pytest
from mgeo_attitude.refine.minimizers import minimize_bounded, minimize_constrained
from scipy.optimize import minimize, rosen, rosen_der

BOUNDS = np.array([(-2.0, 2.0)] * 4)


def run_minimizer(function, *arguments, method=minimize_bounded):
    minimizer = method(*arguments)
    z = next(minimizer)
    while True:
        try:
            z = minimizer.send(function(z))
        except StopIteration as end:
            return end.value


@pytest.mark.parametrize("high", [2.0, 0.7])
def test_bounded_minimizer_agrees_with_scipy(high):
    bounds = np.array([(-2.0, high)] * 6)
    start = np.linspace(-1.5, 0.5, 6)
    found = run_minimizer(lambda z: (rosen(z), rosen_der(z)), start, bounds, 300, 1e-14)
    expected = minimize(rosen, start, jac=rosen_der, bounds=bounds, method="L-BFGS-B", tol=1e-14)
    assert rosen(found) == pytest.approx(expected.fun, abs=1e-8)
    assert (found <= bounds[:, 1]).all()


def test_values_do_not_increase_and_flat_functions_end_at_once():
    bounds, points = np.array([(0.0, 1.0)] * 3), []

    def oscillating(z):
        points.append(z)
        return float(np.sin(40.0 * z).sum()), 40.0 * np.cos(40.0 * z)

    start = np.array([0.1, 0.9, 0.4])
    assert (
        oscillating(run_minimizer(oscillating, start, bounds, 5, 1e-9))[0] <= oscillating(start)[0]
    )
    flat = run_minimizer(lambda z: (1.0, np.zeros(3)), start, bounds, 5, 1e-9)
    np.testing.assert_array_equal(flat, start)
    at_bounds = run_minimizer(lambda z: (z.sum(), np.ones(3)), np.zeros(3), bounds, 5, 1e-9)
    np.testing.assert_array_equal(at_bounds, np.zeros(3))


def evaluate_in_ball(z):
    """Return Rosenbrock's function and the margin to a ball of radius 1, with gradients."""
    return np.array([rosen(z), 1.0 - z @ z]), np.array([rosen_der(z), -2.0 * z])


def test_interleaved_constrained_minimizers_equal_scipy():
    starts = np.random.default_rng(0).uniform(-0.4, 0.4, (3, 4))
    expected = [
        minimize(
            rosen,
            start,
            jac=rosen_der,
            bounds=BOUNDS,
            constraints=[{"type": "ineq", "fun": lambda z: 1.0 - z @ z, "jac": lambda z: -2.0 * z}],
            method="SLSQP",
            options={"maxiter": 30, "ftol": 1e-10},
        ).x
        for start in starts
    ]
    minimizers = {
        k: minimize_constrained(start, BOUNDS, 30, 1e-10) for k, start in enumerate(starts)
    }
    points, found = {k: next(minimizer) for k, minimizer in minimizers.items()}, {}
    while points:
        for k, z in list(points.items()):
            try:
                points[k] = minimizers[k].send(evaluate_in_ball(z))
            except StopIteration as end:
                found[k] = end.value
                del points[k]
    np.testing.assert_array_equal([found[k] for k in range(3)], expected)


def test_closed_minimizer_ends_its_thread_and_errors_are_raised():
    before = threading.active_count()
    minimizer = minimize_constrained(np.zeros(4), BOUNDS, 30, 1e-10)
    minimizer.send(None)
    assert threading.active_count() == before + 1
    minimizer.close()
    assert threading.active_count() == before
    with pytest.raises(ValueError, match="broadcast"):
        run_minimizer(
            lambda z: (np.ones(2), np.ones((2, 3))),
            *(np.zeros(4), BOUNDS, 5, 1e-9),
            method=minimize_constrained,
        )
    assert threading.active_count() == before
