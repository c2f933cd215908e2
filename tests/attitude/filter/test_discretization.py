"""Compiled discretization compared with Van Loan's method, quadrature and scipy's rotations."""

import numpy as np
import pytest
from mgeo_attitude.filter.discretization import compute_step_rotation, discretize
from scipy.integrate import quad_vec
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from .suites import SUITES


@pytest.mark.parametrize("name", ["paper", "full gyro"])
@pytest.mark.parametrize("rate", [0.0, 1e-9, 0.0175, 0.3, 5.0])
@pytest.mark.parametrize("dt", [0.1, 1.0, 30.0])
def test_discretization_equals_matrix_exponential(name, rate, dt):
    suite = SUITES[name]
    A = suite.dynamics_matrix(rate * np.array([0.36, -0.48, 0.8]))
    density = suite.compute_noise_density()
    m = len(A)
    F, Q = discretize(A, density, dt)
    upper = np.block([[-A, np.diag(density)], [np.zeros((m, m)), A.T]])
    exponential = expm(upper * dt)
    expected_F = exponential[m:, m:].T
    np.testing.assert_allclose(F, expected_F, rtol=0, atol=1e-12 * np.abs(expected_F).max())
    if rate * dt < 10.0:  # At larger angles, exp(-A dt) in Van Loan's matrix loses digits.
        expected_Q = expected_F @ exponential[:m, m:]
        np.testing.assert_allclose(Q, expected_Q, rtol=0, atol=1e-12 * np.abs(expected_Q).max())


def test_process_noise_equals_quadrature():
    suite = SUITES["paper"]
    A, density, dt = (
        suite.dynamics_matrix(np.array([0.1, 0.2, -0.1])),
        suite.compute_noise_density(),
        20.0,
    )

    def integrand(s):
        F = expm(A * s)
        return F @ np.diag(density) @ F.T

    expected, _ = quad_vec(integrand, 0.0, dt, epsabs=0.0, epsrel=1e-12)
    _, Q = discretize(A, density, dt)
    np.testing.assert_allclose(Q, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("rate", [0.0, 1e-12, 9.9e-5, 1.01e-4, 0.0175, 3.0])
def test_step_rotation_is_rotation_by_minus_omega_dt(rate):
    omega, dt = rate * np.array([0.36, -0.48, 0.8]), 1.0
    np.testing.assert_allclose(
        compute_step_rotation(omega, dt),
        Rotation.from_rotvec(-omega * dt).as_matrix(),
        rtol=0,
        atol=1e-15,
    )


def test_fixed_star_moves_opposite_to_body_rotation():
    """A star on body x moves toward -y when the body rotates about +z."""
    star = compute_step_rotation(np.array([0.0, 0.0, 0.01]), 1.0) @ np.array([1.0, 0.0, 0.0])
    assert star[1] == pytest.approx(-0.01, rel=1e-4)
