"""Error model of a suite, compared with explicit matrices."""

import numpy as np
import pytest

from .suites import SUITES

OMEGA = np.array([0.3, -0.2, 0.5])
V = np.array([0.6, -0.48, 0.64])


def skew(v):
    """Return the cross-product matrix [v×]."""
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def test_paper_suite_has_state_of_the_paper():
    suite = SUITES["paper"]
    assert suite.blocks == (
        "attitude",
        "gyro.bias",
        "sun.misalignment",
        "sun.bias",
        "mag.misalignment",
        "mag.bias",
    )
    assert (suite.n_states, suite.n_dynamic) == (18, 6)


def test_paper_dynamics_equal_equation_2():
    A = SUITES["paper"].dynamics_matrix(OMEGA)
    expected = np.block([[-skew(OMEGA), -np.eye(3)], [np.zeros((3, 3)), -1e-5 * np.eye(3)]])
    np.testing.assert_array_equal(A, expected)


@pytest.mark.parametrize(("index", "first"), [(0, 6), (1, 12)])
def test_paper_measurements_equal_equation_2(index, first):
    suite = SUITES["paper"]
    H = suite.measurement_matrix(suite.sensors[index], V)
    expected = np.zeros((3, 18))
    expected[:, 0:3] = skew(V)
    expected[:, first : first + 3] = -skew(V)
    expected[:, first + 3 : first + 6] = np.eye(3)
    np.testing.assert_array_equal(H, expected)


def test_soft_iron_error_is_symmetric_matrix():
    """The measured field is (I + [ψ×] + diag(k) + N(η)) B."""
    suite = SUITES["every constant"]
    H = suite.measurement_matrix(suite.sensors[1], V)
    own = suite.get_first_indices(suite.sensors[1])
    for axis, unit in enumerate(np.eye(3)):
        np.testing.assert_array_equal(H[:, own["misalignment"] + axis], skew(unit) @ V)
        np.testing.assert_array_equal(H[:, own["scale_factor"] + axis], np.diag(unit) @ V)
        np.testing.assert_array_equal(
            H[:, own["nonorthogonality"] + axis], build_symmetric(unit) @ V
        )


def test_star_tracker_measures_the_attitude():
    suite = SUITES["star tracker"]
    H = suite.measurement_matrix(suite.sensors[0], V)
    np.testing.assert_array_equal(H[:, 0:3], np.eye(3))
    np.testing.assert_array_equal(H[:, 6:9], -np.eye(3))
    assert not H[:, 3:6].any()
    assert not H[:, 9:].any()


def build_symmetric(e):
    """Return the symmetric matrix N(e) with e beside the zero diagonal."""
    return np.array([[0, e[2], e[1]], [e[2], 0, e[0]], [e[1], e[0], 0]])


def test_gyro_dynamics_are_derivative_of_rate_error():
    """The attitude error changes by -(ω_m - ω) for ω_m = (I + diag(k) + [μ×] + N(η)) ω + b."""
    suite = SUITES["every constant"]
    A = suite.dynamics_matrix(OMEGA)

    def rate_error(b, k, mu, eta):
        return -((np.diag(k) + skew(mu) + build_symmetric(eta)) @ OMEGA + b)

    names = ["b", "k", "mu", "eta"]
    for block, argument in enumerate(names, start=1):
        for axis in range(3):
            arguments = dict.fromkeys(names, np.zeros(3)) | {argument: np.eye(3)[axis]}
            np.testing.assert_allclose(
                A[:3, 3 * block + axis], rate_error(**arguments), rtol=0, atol=1e-15
            )


def test_small_angle_signs_agree_with_rotations():
    """The exact model is s_true = (I - [θ×]) s_c and s_meas = (I + [φ×]) s_true + δ."""
    suite = SUITES["paper"]
    rng = np.random.default_rng(0)
    theta, phi, delta = 1e-6 * rng.standard_normal((3, 3))
    measured = (np.eye(3) + skew(phi)) @ (np.eye(3) - skew(theta)) @ V + delta
    x = np.zeros(18)
    x[0:3], x[6:9], x[9:12] = theta, phi, delta
    H = suite.measurement_matrix(suite.sensors[0], V)
    np.testing.assert_allclose(H @ x, measured - V, rtol=0, atol=1e-11)


def test_initial_sigma_is_in_si():
    sigma = SUITES["paper"].initial_sigma(np.radians(5.0))
    expected = [np.radians(5), np.radians(0.01), np.radians(1), 0.02, np.radians(1), 2000 / 50000]
    np.testing.assert_allclose(sigma, np.repeat(expected, 3), rtol=1e-15)


def test_noise_densities_are_in_si():
    """0.01 deg/sqrt(h) is 2.9089e-6 rad/sqrt(s)."""
    np.testing.assert_allclose(
        SUITES["paper"].compute_noise_density(),
        np.repeat([2.908882086657216e-6**2, 9e-16], 3),
        rtol=1e-12,
    )
