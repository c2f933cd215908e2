"""Innovations and their derivatives, compared with finite differences and declared measurement
matrices.
"""

import numpy as np
import pytest
from mgeo_attitude import Gyro, Suite, SunSensor
from mgeo_attitude.geometry.rotation import dot, rotate, rotation_matrix, tangent_vectors
from mgeo_attitude.sensors.direction_sensors import rotate_tangents
from mgeo_attitude.sensors.measurements import apply_latency, stack_measurement, unstack_measurement
from mgeo_calibration.estimation.innovation import (
    Estimate,
    compute_innovation,
    compute_jacobian,
    compute_second_order_moments,
)
from pydantic.dataclasses import dataclass
from scipy.spatial.transform import Rotation

from ...attitude.filter.suites import SUITES, every_suite
from ...attitude.geometry.test_rotation import as_scipy

V = np.array([0.3, -0.5, 0.9])
CHANGE = np.array([[0.02, 0.03, -0.01]])
RATE = np.array([0.3, -0.1, 0.2])
GRADIENT = np.array([[0.5, 0.1, -0.3], [0.1, -0.9, 0.2], [-0.3, 0.2, 0.4]])


@dataclass(frozen=True)
class NonlinearSensor(SunSensor):
    """Sensor model with products of states, quotients, and the rotation of a sum."""

    def predict_measurement(self, x, v):
        u = rotate(x.misalignment, v + 0.3 * x.bias)
        return (u * x.bias - np.array([0.1, 0.2, 0.3])) / (2.0 + dot(u, x.bias)) + 1.0 / (
            2.0 - x.bias
        )


NONLINEAR = Suite(Gyro(), (NonlinearSensor(),))
CASES = [
    (NONLINEAR, 0),
    (SUITES["late"], 2),
    (SUITES["two angles"], 0),
    (SUITES["star tracker"], 0),
    (SUITES["orbit error"], 2),
    (SUITES["soft iron"], 1),
]


def get_vectors(suite, sensor):
    """Return the vector in GCRS that a sensor observes, and its gradients."""
    by_latency = CHANGE[: len(sensor.latency_states())]
    if sensor.has_unit_length:
        v = V / np.linalg.norm(V)
        by_orbit = GRADIENT[: suite.count_gradient_vectors(sensor) - 2 - len(by_latency)]
        return v, np.vstack([*tangent_vectors(v), *by_orbit, *by_latency])
    return V, np.vstack(
        [GRADIENT[: suite.count_gradient_vectors(sensor) - len(by_latency)], by_latency]
    )


def build_estimate(suite, C, x):
    """Return the estimate of one run from attitude C and states x with rotation vectors."""
    places = np.arange(3)[:, None] + np.array(suite.rotation_indices)
    rotations, states = rotation_matrix(x[places])[..., None], x[:, None].copy()
    rotations[:, :, 0, 0] = C.T
    states[places] = 0.0
    return Estimate(places, rotations, states, np.zeros((len(x), len(x), 1)))


def draw_states(suite, seed):
    """Return a random attitude matrix, and random states and errors that are not small."""
    rng = np.random.default_rng(seed)
    C = Rotation.random(random_state=seed).as_matrix()
    return C, 0.2 * rng.standard_normal(suite.n_states), 0.1 * rng.standard_normal(suite.n_states)


def apply_errors(suite, C, x, e):
    """Return attitude and states whose errors relative to C and x are e, computed with SciPy."""
    true = x + e
    for first in suite.rotation_indices[1:]:
        block = slice(first, first + 3)
        if not e[block].any():
            true[block] = x[block]
            continue
        quaternion = (as_scipy(x[block]) * as_scipy(e[block])).as_quat()
        true[block] = 2.0 * quaternion[:3] / quaternion[3]
    attitude = as_scipy(-e[:3]).as_matrix() @ C if e[:3].any() else C
    return attitude, true


def measure(suite, sensor, C, x):
    """Return the noise-free reading of a sensor, shape (1, k, 3)."""

    def to_body(vector):
        return C @ vector

    own = {state: x[first : first + 3] for state, first in suite.get_first_indices(sensor).items()}
    v, further = get_vectors(suite, sensor)
    report = sensor.predict_measurement(*apply_latency(sensor, own, [v, *further], to_body, RATE))
    return stack_measurement(report)[None]


def get_channel_values(sensor):
    """Return values of the channels of a sensor's bias sensitivities."""
    return (1.5, -0.7)[: len(sensor.bias_sensitivities)]


def expand_innovation(suite, index, y, C, x):
    """Return innovation, dense Jacobian H and dense matrices of second derivatives."""
    v, gradient = get_vectors(suite, suite.sensors[index])
    at = build_estimate(suite, C, x)
    further = {
        "gradient": gradient,
        "rate": RATE,
        "channel_values": get_channel_values(suite.sensors[index]),
    }
    r = compute_innovation(suite, index, unstack_measurement(y), v, at, **further)
    states, H = compute_jacobian(r)
    m, n = len(r.value), suite.n_states
    dense, second = np.zeros((m, n)), np.zeros((m, n, n))
    dense[:, states] = H[..., 0]
    for (i, j), part in ((term, part) for term, part in r.terms.items() if len(term) == 2):
        block = part[..., 0].reshape(m, 3, 3)
        second[:, 3 * i : 3 * i + 3, 3 * j : 3 * j + 3] += block
        second[:, 3 * j : 3 * j + 3, 3 * i : 3 * i + 3] += block.swapaxes(1, 2)
    return r.value[:, 0], dense, second


def expand_in_fixed_axes(suite, index, y, C, x):
    """Return the result of `expand_innovation` in three axes that do not depend on the estimate."""
    sensor, expansion = suite.sensors[index], expand_innovation(suite, index, y, C, x)
    if not sensor.has_unit_length:
        return expansion
    axes = rotate_tangents(measure(suite, sensor, C, x)[:, 0], y[:, 0])[0]
    return tuple(np.tensordot(axes, each, 1) for each in expansion)


@pytest.mark.cases(3)
@pytest.mark.parametrize(("suite", "index"), CASES)
def test_innovation_derivatives_equal_finite_differences(suite, index):
    sensor = suite.sensors[index]
    C, x, e = draw_states(suite, seed=3)
    y = measure(suite, sensor, *apply_errors(suite, C, x, e))

    def at(errors):
        return expand_in_fixed_axes(suite, index, y, *apply_errors(suite, C, x, errors))

    def unit(j, size):
        error = np.zeros(suite.n_states)
        error[j] = size
        return error

    r, H, B = at(np.zeros(suite.n_states))
    h, local = 1e-4, [0, 1, 2]
    for first in suite.get_first_indices(sensor).values():
        local += range(first, first + 3)
    others = [j for j in range(suite.n_states) if j not in local]
    assert not H[:, others].any()
    assert not B[:, others].any()
    for place, i in enumerate(local):
        ahead, behind = at(unit(i, h))[0], at(unit(i, -h))[0]
        np.testing.assert_allclose(H[:, i], -(ahead - behind) / (2 * h), rtol=0, atol=1e-7)
        second = (ahead - 2 * r + behind) / h**2
        np.testing.assert_allclose(B[:, i, i], second, rtol=0, atol=1e-6)
        for j in local[place + 1 :]:
            corners = [
                at(unit(i, p * h) + unit(j, q * h))[0] * p * q for p in (1, -1) for q in (1, -1)
            ]
            np.testing.assert_allclose(B[:, i, j], sum(corners) / (4 * h**2), rtol=0, atol=1e-6)
            np.testing.assert_array_equal(B[:, i, j], B[:, j, i])
    # The innovation is zero if the estimate is the truth.
    np.testing.assert_allclose(at(e)[0], 0.0, atol=1e-14)


@pytest.mark.cases(3)
@pytest.mark.parametrize(("suite", "index"), CASES)
def test_second_order_moments_equal_traces_of_dense_matrices(suite, index):
    C, x, e = draw_states(suite, seed=4)
    y = measure(suite, suite.sensors[index], *apply_errors(suite, C, x, e))
    at, (v, gradient) = build_estimate(suite, C, x), get_vectors(suite, suite.sensors[index])
    found = compute_innovation(
        suite, index, unstack_measurement(y), v, at, gradient=gradient, rate=RATE
    )
    B = expand_innovation(suite, index, y, C, x)[2]
    root = np.random.default_rng(5).standard_normal((suite.n_states, suite.n_states))
    P = root @ root.T
    mean, covariance = compute_second_order_moments(found, P[..., None])
    np.testing.assert_allclose(mean[:, 0], 0.5 * np.trace(B @ P, axis1=1, axis2=2), rtol=1e-12)
    expected = [[0.5 * np.trace(b @ P @ c @ P) for c in B] for b in B]
    np.testing.assert_allclose(covariance[..., 0], expected, rtol=1e-11)


@every_suite
def test_jacobian_at_zero_states_equals_measurement_matrix(name):
    suite = SUITES[name]
    x = np.zeros(suite.n_states)
    for index, sensor in enumerate(suite.sensors):
        for C in (np.eye(3), Rotation.random(random_state=6).as_matrix()):
            y = measure(suite, sensor, C, x)
            H = expand_in_fixed_axes(suite, index, y, C, x)[1]
            v, gradient = get_vectors(suite, sensor)
            declared = suite.measurement_matrix(
                sensor, C @ v, C, gradient @ C.T, RATE, get_channel_values(sensor)
            )
            if sensor.has_unit_length:
                declared = (gradient[:2] @ C.T).T @ declared
            np.testing.assert_allclose(H, declared, atol=1e-15)
