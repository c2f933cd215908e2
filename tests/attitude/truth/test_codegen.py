"""The generated innovation against scipy's rotations, the declared H and differences of itself."""

import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest
from mgeo_attitude import Gyro, StarTracker, SunSensor
from mgeo_attitude.truth.codegen import module_source
from mgeo_attitude.vector import Vec3
from scipy.spatial.transform import Rotation

from ..filter.suites import SUITES
from .test_rotation import as_scipy

CASES = [(name, i) for name in ("paper", "star tracker") for i in range(2)]


def plain(suite, truth=None):
    """The generated functions as plain Python, without what calls them."""
    text = module_source(suite, truth or suite, cache=False)
    functions = text.partition('"""What corrects an estimate')[0]
    source = functions.replace("from numba import njit", "njit = lambda **_: lambda f: f")
    namespace = {}
    exec(source, namespace)
    return namespace


def estimate(suite, seed):
    """A random attitude matrix, state and error, none of them small."""
    rng = np.random.default_rng(seed)
    C = Rotation.random(random_state=seed).as_matrix()
    return C, 0.2 * rng.standard_normal(suite.n_states), 0.1 * rng.standard_normal(suite.n_states)


def perturbed(suite, rotations, C, x, e):
    """The attitude and states whose error from an estimate is e, by scipy."""
    true = x + e
    for first in rotations[1:]:
        block = slice(first, first + 3)
        if not e[block].any():
            true[block] = x[block]
            continue
        quaternion = (as_scipy(x[block]) * as_scipy(e[block])).as_quat()
        true[block] = 2.0 * quaternion[:3] / quaternion[3]
    turned = as_scipy(-e[:3]).as_matrix() @ C if e[:3].any() else C
    return turned, true


@pytest.mark.parametrize(("name", "index"), CASES)
def test_derivatives_of_the_innovation_are_those_of_finite_differences(name, index):
    suite = SUITES[name]
    made = plain(suite)
    C, x, e = estimate(suite, seed=3)
    v, local = np.array([0.3, -0.5, 0.9]), made["LOCAL"][index][: made["N_LOCAL"][index]]
    curved = made["CURVED"][index][: made["N_CURVED"][index]]
    true_C, true_x = perturbed(suite, made["ROTATIONS"], C, x, e)
    y = np.empty(made["N_READINGS"])
    made["measured"](index, true_C @ v, true_C, true_x, y)

    def innovation(errors):
        at_C, at_x = perturbed(suite, made["ROTATIONS"], C, x, errors)
        r, H, B = np.empty(3), np.zeros((3, len(local))), np.zeros((3, len(curved), len(curved)))
        made["innovation"](index, y, at_C @ v, at_C, at_x, r, H, B)
        return r, H, B

    def unit(j, size):
        error = np.zeros(suite.n_states)
        error[local[j]] = size
        return error

    r, H, B = innovation(np.zeros(suite.n_states))
    h = 1e-4
    for j in range(len(local)):
        ahead, behind = innovation(unit(j, h))[0], innovation(unit(j, -h))[0]
        np.testing.assert_allclose(H[:, j], -(ahead - behind) / (2 * h), rtol=0, atol=1e-7)
        if j in curved:
            a = list(curved).index(j)
            second = (ahead - 2 * r + behind) / h**2
            np.testing.assert_allclose(B[:, a, a], second, rtol=0, atol=1e-6)
    for a, i in enumerate(curved):
        for b, j in enumerate(curved[a + 1 :], start=a + 1):
            corners = [
                innovation(unit(i, p * h) + unit(j, q * h))[0] * p * q
                for p in (1, -1)
                for q in (1, -1)
            ]
            np.testing.assert_allclose(B[:, a, b], sum(corners) / (4 * h**2), rtol=0, atol=1e-6)
    # and where the estimate is the truth there is nothing left
    np.testing.assert_allclose(innovation(e)[0], 0.0, atol=1e-14)


@pytest.mark.parametrize("name", SUITES)
def test_at_zero_the_derivative_is_the_declared_H(name):
    suite = SUITES[name]
    made = plain(suite)
    v, x = np.array([0.3, -0.5, 0.9]), np.zeros(suite.n_states)
    for index, sensor in enumerate(suite.sensors):
        local = made["LOCAL"][index][: made["N_LOCAL"][index]]
        y, r, H = np.empty(made["N_READINGS"]), np.empty(3), np.zeros((3, len(local)))
        made["measured"](index, v, np.eye(3), x, y)
        made["innovation"](index, y, v, np.eye(3), x, r, H, np.zeros((3, 9, 9)))
        dense = np.zeros((3, suite.n_states))
        dense[:, local] = H
        np.testing.assert_allclose(dense, suite.measurement_matrix(sensor, v), atol=1e-15)


def test_star_tracker_reports_a_rotation():
    """Its innovation is the rotation from the predicted to the measured axes, of any size."""
    A = Rotation.random(random_state=1)
    g = np.array([0.4, -0.7, 1.1])
    measured = (as_scipy(-g) * A).as_matrix().T
    y = StarTracker().innovation(
        tuple(Vec3(*axis) for axis in measured), tuple(Vec3(*axis) for axis in A.as_matrix().T)
    )
    np.testing.assert_allclose([*y], g, rtol=1e-13)


@dataclass(frozen=True)
class Squinting(SunSensor):
    """A Sun sensor that sees everything at twice the distance from its x axis."""

    def measured(self, x, v):
        seen = super().measured(x, v)
        return Vec3(seen.x, 2.0 * seen.y, 2.0 * seen.z)


@dataclass(frozen=True)
class Doubling(Gyro):
    """A gyro that reports twice the rate."""

    def measured(self, x, omega):
        return super().measured(x, 2.0 * omega)


def test_the_truth_reports_and_the_estimator_predicts():
    believed = SUITES["paper"]
    truth = dataclasses.replace(
        believed, gyro=Doubling(), sensors=(Squinting(), *believed.sensors[1:])
    )
    made, x, C = plain(believed, truth), np.zeros(believed.n_states), np.eye(3)
    v, y, r = np.array([0.3, -0.5, 0.9]), np.empty(3), np.empty(3)
    made["measured"](0, v, C, x, y)
    np.testing.assert_array_equal(y, [0.3, -1.0, 1.8])
    made["innovation"](0, y, v, C, x, r, np.empty((3, 9)), np.empty((3, 9, 9)))
    np.testing.assert_allclose(r, [0.0, -0.5, 0.9], atol=1e-15)
    reported, corrected = np.empty(3), np.empty(3)
    made["gyro_measured"](v, x, reported)
    np.testing.assert_array_equal(reported, 2.0 * v)
    made["gyro_corrected"](v, x, corrected)
    np.testing.assert_array_equal(corrected, v)


def test_gyro_is_corrected_by_what_it_measures():
    suite = SUITES["full gyro"]
    made, rng = plain(suite), np.random.default_rng(2)
    x, omega = 0.1 * rng.standard_normal(suite.n_states), rng.standard_normal(3)
    reported, corrected = np.empty(3), np.empty(3)
    made["gyro_measured"](omega, x, reported)
    bias, k, mu = x[3:6], x[6:9], x[9:12]
    np.testing.assert_allclose(reported, as_scipy(mu).apply((1 + k) * omega) + bias, rtol=1e-14)
    made["gyro_corrected"](reported, x, corrected)
    np.testing.assert_allclose(corrected, omega, rtol=1e-13)
    assert Gyro.rotations == ("misalignment",)
