"""The innovation and its derivatives against scipy's rotations, the declared H and differences."""

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
class Own(SunSensor):
    """Of everything that a model may do: products of states, quotients, a rotation of a sum."""

    def predict_measurement(self, x, v):
        u = rotate(x.misalignment, v + 0.3 * x.bias)
        return (u * x.bias - np.array([0.1, 0.2, 0.3])) / (2.0 + dot(u, x.bias)) + 1.0 / (
            2.0 - x.bias
        )


OWN = Suite(Gyro(), (Own(),))
CASES = [
    (OWN, 0),
    (SUITES["late"], 2),
    (SUITES["two angles"], 0),
    (SUITES["star tracker"], 0),
    (SUITES["orbit error"], 2),
    (SUITES["soft iron"], 1),
]


def look(suite, sensor):
    """What a sensor looks at, GCRS: the vector, and what else `Suite.looks` has."""
    change = CHANGE[: len(sensor.latency_states())]
    if sensor.has_unit_length:
        v = V / np.linalg.norm(V)
        by_orbit = GRADIENT[: suite.count_auxiliary_vectors(sensor) - 2 - len(change)]
        return v, np.vstack([*tangent_vectors(v), *by_orbit, *change])
    return V, np.vstack([GRADIENT[: suite.count_auxiliary_vectors(sensor) - len(change)], change])


def estimate(suite, C, x):
    """One run's estimate of attitude and states with the vectors of rotations."""
    places = np.arange(3)[:, None] + np.array(suite.rotation_indices)
    rotations, states = rotation_matrix(x[places])[..., None], x[:, None].copy()
    rotations[:, :, 0, 0] = C.T
    states[places] = 0.0
    return Estimate(places, rotations, states, np.zeros((len(x), len(x), 1)))


def random(suite, seed):
    """A random attitude matrix, state and error, none of them small."""
    rng = np.random.default_rng(seed)
    C = Rotation.random(random_state=seed).as_matrix()
    return C, 0.2 * rng.standard_normal(suite.n_states), 0.1 * rng.standard_normal(suite.n_states)


def perturbed(suite, C, x, e):
    """The attitude and states whose error from an estimate is e, by scipy."""
    true = x + e
    for first in suite.rotation_indices[1:]:
        block = slice(first, first + 3)
        if not e[block].any():
            true[block] = x[block]
            continue
        quaternion = (as_scipy(x[block]) * as_scipy(e[block])).as_quat()
        true[block] = 2.0 * quaternion[:3] / quaternion[3]
    turned = as_scipy(-e[:3]).as_matrix() @ C if e[:3].any() else C
    return turned, true


def measured(suite, sensor, C, x):
    """What a sensor of the suite reports in truth, shape (1, k, 3)."""

    def to_body(vector):
        return C @ vector

    own = {state: x[first : first + 3] for state, first in suite.get_first_indices(sensor).items()}
    v, further = look(suite, sensor)
    report = sensor.predict_measurement(*apply_latency(sensor, own, [v, *further], to_body, RATE))
    return stack_measurement(report)[None]


def channels(sensor):
    """What its influences are times."""
    return (1.5, -0.7)[: len(sensor.bias_sensitivities)]


def expanded(suite, index, y, C, x):
    """Innovation, dense H and dense matrices of second derivatives."""
    v, auxiliary_vectors = look(suite, suite.sensors[index])
    at = estimate(suite, C, x)
    further = {
        "auxiliary_vectors": auxiliary_vectors,
        "rate": RATE,
        "channel_values": channels(suite.sensors[index]),
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


def is_3d(suite, index, y, C, x):
    """The same along three axes that do not change with the estimate."""
    sensor, found = suite.sensors[index], expanded(suite, index, y, C, x)
    if not sensor.has_unit_length:
        return found
    axes = rotate_tangents(measured(suite, sensor, C, x)[:, 0], y[:, 0])[0]
    return tuple(np.tensordot(axes, each, 1) for each in found)


@pytest.mark.cases(3)
@pytest.mark.parametrize(("suite", "index"), CASES)
def test_derivatives_of_the_innovation_are_those_of_finite_differences(suite, index):
    sensor = suite.sensors[index]
    C, x, e = random(suite, seed=3)
    y = measured(suite, sensor, *perturbed(suite, C, x, e))

    def at(errors):
        return is_3d(suite, index, y, *perturbed(suite, C, x, errors))

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
    # and where the estimate is the truth there is nothing left
    np.testing.assert_allclose(at(e)[0], 0.0, atol=1e-14)


@pytest.mark.cases(3)
@pytest.mark.parametrize(("suite", "index"), CASES)
def test_moments_of_second_order_are_those_of_samples(suite, index):
    """Mean and covariance of ½ eᵀ B e by the traces of dense matrices."""
    C, x, e = random(suite, seed=4)
    y = measured(suite, suite.sensors[index], *perturbed(suite, C, x, e))
    at, (v, auxiliary_vectors) = estimate(suite, C, x), look(suite, suite.sensors[index])
    found = compute_innovation(
        suite, index, unstack_measurement(y), v, at, auxiliary_vectors=auxiliary_vectors, rate=RATE
    )
    B = expanded(suite, index, y, C, x)[2]
    root = np.random.default_rng(5).standard_normal((suite.n_states, suite.n_states))
    P = root @ root.T
    mean, covariance = compute_second_order_moments(found, P[..., None])
    np.testing.assert_allclose(mean[:, 0], 0.5 * np.trace(B @ P, axis1=1, axis2=2), rtol=1e-12)
    expected = [[0.5 * np.trace(b @ P @ c @ P) for c in B] for b in B]
    np.testing.assert_allclose(covariance[..., 0], expected, rtol=1e-11)


@every_suite
def test_at_zero_the_derivative_is_the_declared_H(name):
    suite = SUITES[name]
    x = np.zeros(suite.n_states)
    for index, sensor in enumerate(suite.sensors):
        for C in (np.eye(3), Rotation.random(random_state=6).as_matrix()):
            y = measured(suite, sensor, C, x)
            H = is_3d(suite, index, y, C, x)[1]
            v, auxiliary_vectors = look(suite, sensor)
            declared = suite.measurement_matrix(
                sensor, C @ v, C, auxiliary_vectors @ C.T, RATE, channels(sensor)
            )
            if sensor.has_unit_length:
                declared = (auxiliary_vectors[:2] @ C.T).T @ declared
            np.testing.assert_allclose(H, declared, atol=1e-15)
