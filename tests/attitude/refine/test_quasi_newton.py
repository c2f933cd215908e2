"""Methods that ask for points: quasi-Newton within bounds, scipy's SLSQP within limits."""

import threading

import numpy as np
import pytest
from mgeo_attitude.refine.minimizers import minimize_bounded, minimize_constrained
from scipy.optimize import minimize, rosen, rosen_der

BOUNDS = np.array([(-2.0, 2.0)] * 4)


def minimized(known, *given, method=minimize_bounded):
    way = method(*given)
    z = next(way)
    while True:
        try:
            z = way.send(known(z))
        except StopIteration as end:
            return end.value


@pytest.mark.parametrize("high", [2.0, 0.7])
def test_it_finds_what_scipy_finds(high):
    bounds = np.array([(-2.0, high)] * 6)
    start = np.linspace(-1.5, 0.5, 6)
    found = minimized(lambda z: (rosen(z), rosen_der(z)), start, bounds, 300, 1e-14)
    expected = minimize(rosen, start, jac=rosen_der, bounds=bounds, method="L-BFGS-B", tol=1e-14)
    assert rosen(found) == pytest.approx(expected.fun, abs=1e-8)
    assert (found <= bounds[:, 1]).all()


def test_no_value_is_above_the_first_and_a_flat_function_ends_at_once():
    bounds, asked = np.array([(0.0, 1.0)] * 3), []

    def rough(z):
        asked.append(z)
        return float(np.sin(40.0 * z).sum()), 40.0 * np.cos(40.0 * z)

    start = np.array([0.1, 0.9, 0.4])
    assert rough(minimized(rough, start, bounds, 5, 1e-9))[0] <= rough(start)[0]
    flat = minimized(lambda z: (1.0, np.zeros(3)), start, bounds, 5, 1e-9)
    np.testing.assert_array_equal(flat, start)
    held = minimized(lambda z: (z.sum(), np.ones(3)), np.zeros(3), bounds, 5, 1e-9)
    np.testing.assert_array_equal(held, np.zeros(3))


def in_ball(z):
    """Rosenbrock's function and what is left of a radius of 1, with slopes."""
    return np.array([rosen(z), 1.0 - z @ z]), np.array([rosen_der(z), -2.0 * z])


def test_within_limits_it_goes_as_scipy_does_each_of_several_by_itself():
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
    ways = {k: minimize_constrained(start, BOUNDS, 30, 1e-10) for k, start in enumerate(starts)}
    asked, found = {k: next(way) for k, way in ways.items()}, {}
    while asked:
        for k, z in list(asked.items()):
            try:
                asked[k] = ways[k].send(in_ball(z))
            except StopIteration as end:
                found[k] = end.value
                del asked[k]
    np.testing.assert_array_equal([found[k] for k in range(3)], expected)


def test_a_way_that_is_left_leaves_no_thread_and_what_goes_wrong_is_told():
    before = threading.active_count()
    way = minimize_constrained(np.zeros(4), BOUNDS, 30, 1e-10)
    way.send(None)
    assert threading.active_count() == before + 1
    way.close()
    assert threading.active_count() == before
    with pytest.raises(ValueError, match="broadcast"):
        minimized(
            lambda z: (np.ones(2), np.ones((2, 3))),
            *(np.zeros(4), BOUNDS, 5, 1e-9),
            method=minimize_constrained,
        )
    assert threading.active_count() == before
