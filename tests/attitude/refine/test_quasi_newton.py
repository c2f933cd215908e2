"""The quasi-Newton method within bounds."""

import numpy as np
import pytest
from mgeo_attitude.refine import minimizing
from scipy.optimize import minimize, rosen, rosen_der


def minimized(known, *given):
    way = minimizing(*given)
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
