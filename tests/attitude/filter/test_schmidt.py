"""The text of predict, update and last pivot, run as Python, against dense matrix algebra."""

from functools import partial

import numpy as np
import pytest
from mgeo_attitude.filter.covariance import last_pivot, predict, update
from mgeo_attitude.filter.layout import transition_pattern
from mgeo_attitude.filter.reference import schmidt
from mgeo_attitude.filter.symbols import Code, Triangle, slots_of, triangle
from mgeo_attitude.geometry.vector import Vec3
from scipy.linalg import expm

from .suites import SUITES, every_suite


def run(P, write):
    """P after what `write` says of it as text, and the number it names."""
    n = len(P)
    code, scratch = Code(), slots_of(n)
    named = write(Triangle(code, scratch))
    W = np.concatenate([P[triangle(n)], np.full(scratch + 1, np.nan)])
    if named is not None:
        code.store(2 * scratch, named)
    exec(code.text, {"W": W, "sqrt": np.sqrt})
    result = np.empty((n, n))
    result[triangle(n)] = result.T[triangle(n)] = W[:scratch]
    return result, W[-1]


def random_covariance(rng, n):
    root = rng.standard_normal((n, n))
    return root @ root.T


@every_suite
@pytest.mark.parametrize("seed", range(3))
def test_predict_is_equation_3(name, seed):
    suite, rng = SUITES[name], np.random.default_rng(seed)
    n, m = suite.n_states, suite.n_dynamic
    P = random_covariance(rng, n)
    F, Q = np.eye(n), np.zeros((n, n))
    F[:m, :m] = expm(suite.dynamics_matrix(rng.standard_normal(3)))
    pattern = [*transition_pattern(suite), *((i, i) for i in range(suite.n_kinematic, m))]
    sparse_F = {(i, j): F[i, j] for i, j in pattern}
    noisy = np.isin(np.arange(m), [i for i, _ in sparse_F])
    kinematic = np.arange(m) < suite.n_kinematic  # a process has noise of its own alone
    common = np.outer(kinematic, kinematic) | np.eye(m, dtype=bool)
    Q[:m, :m] = random_covariance(rng, m) * np.outer(noisy, noisy) * common
    sparse_Q = {(i, j): Q[i, j] for i in range(m) for j in range(i + 1)}
    predicted, _ = run(P, lambda text: predict(text, n, sparse_F, sparse_Q))
    np.testing.assert_allclose(predicted, F @ P @ F.T + Q, rtol=1e-12, atol=1e-12)


@every_suite
@pytest.mark.parametrize("seed", range(3))
def test_update_is_equation_4(name, seed):
    suite, rng = SUITES[name], np.random.default_rng(seed)
    P = random_covariance(rng, suite.n_states)
    for sensor in suite.sensors:
        v, R = rng.standard_normal(3), np.diag(rng.uniform(0.1, 1.0, len(sensor.noise())))
        gradient = rng.standard_normal((suite.n_gradient(sensor), 3))
        rate = rng.standard_normal(3)
        follows = rng.standard_normal(len(sensor.influences)).tolist()
        more = {"influences": follows}
        H = suite.measurement_matrix(sensor, v, gradient=gradient, rate=rate, **more)
        K = P @ H.T @ np.linalg.inv(R + H @ P @ H.T)
        columns = [Vec3(*column) for column in gradient]
        measure = partial(
            suite.measure, sensor, Vec3(*v), gradient=columns, rate=Vec3(*rate), **more
        )
        step = partial(update, n=suite.n_states, measure=measure, variances=np.diag(R))
        np.testing.assert_allclose(run(P, step)[0], P - K @ H @ P, rtol=1e-10, atol=1e-10)
        np.testing.assert_array_equal(run(P, partial(step, gate=0.0))[0], P)


@pytest.mark.parametrize("name", ["considered", "every constant"])
@pytest.mark.parametrize("seed", range(3))
def test_an_update_with_considered_states_is_that_of_any_gain(name, seed):
    """Joseph's form with the optimal gain, whose rows of considered states are zero."""
    suite, rng = SUITES[name], np.random.default_rng(seed)
    P = random_covariance(rng, suite.n_states)
    considered = suite.considered if suite.considered.size else np.array([3, 4, 5, 18, 19, 20])
    for sensor in suite.sensors:
        v, R = rng.standard_normal(3), np.diag(rng.uniform(0.1, 1.0, 3))
        gradient = [Vec3(*row) for row in rng.standard_normal((3, 3))]
        measure = partial(suite.measure, sensor, Vec3(*v), gradient=gradient)
        H = np.array([list(measure(list(unit))) for unit in np.eye(suite.n_states)]).T
        K = P @ H.T @ np.linalg.inv(R + H @ P @ H.T)
        K[considered] = 0.0
        rest = np.eye(len(P)) - K @ H
        step = partial(update, n=suite.n_states, measure=measure, variances=np.diag(R))
        updated, _ = run(P, partial(step, considered=considered.tolist()))
        expected = rest @ P @ rest.T + K @ R @ K.T
        np.testing.assert_allclose(updated, expected, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(schmidt(P, H, R, considered), expected, rtol=1e-10, atol=1e-10)
        kept = np.ix_(considered, considered)
        np.testing.assert_array_equal(updated[kept], P[kept])


@every_suite
def test_transition_pattern_holds_every_entry_that_is_not_the_identitys(name):
    suite, rng = SUITES[name], np.random.default_rng(7)
    pattern = set(transition_pattern(suite))
    for _ in range(5):
        k = suite.n_kinematic
        F = expm(suite.dynamics_matrix(rng.standard_normal(3))[:k, :k])
        differs = {(int(i), int(j)) for i, j in np.argwhere(np.eye(len(F)) != F)}
        assert differs <= pattern
        assert pattern <= {(int(i), int(j)) for i, j in np.argwhere(F != 0.0)}
    constant = set(range(suite.n_kinematic)) - {i for i, _ in pattern}
    assert not suite.diffusion()[list(constant)].any()


@pytest.mark.parametrize("seed", range(5))
def test_last_pivot_tells_positive_matrices_from_others(seed):
    rng = np.random.default_rng(seed)
    P = random_covariance(rng, 9)
    expected = np.linalg.cholesky(P)[-1, -1]
    assert run(P, partial(last_pivot, n=9))[1] == pytest.approx(expected, rel=1e-10)
    values, vectors = np.linalg.eigh(P)
    values[3] *= -1e-3
    with np.errstate(invalid="ignore"):
        broken = vectors @ np.diag(values) @ vectors.T
        assert np.isnan(run(broken, partial(last_pivot, n=9))[1])
