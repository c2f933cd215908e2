"""predict and update on floats against dense matrix algebra."""

from functools import partial

import numpy as np
import pytest
from mgeo_attitude.filter.covariance import last_pivot, predict, update
from mgeo_attitude.filter.layout import transition_pattern
from mgeo_attitude.vector import Vec3
from scipy.linalg import expm

from .suites import SUITES


class Lower(dict):
    """A lower triangle that refuses to be read or written above its diagonal twice over."""

    def __init__(self, matrix):
        super().__init__({(i, j): matrix[i, j] for i in range(len(matrix)) for j in range(i + 1)})

    def __getitem__(self, index):
        return super().__getitem__((max(index), min(index)))

    def __setitem__(self, index, value):
        super().__setitem__((max(index), min(index)), value)

    def dense(self):
        n = max(i for i, _ in self) + 1
        return np.array([[self[i, j] for j in range(n)] for i in range(n)])


def random_covariance(rng, n):
    root = rng.standard_normal((n, n))
    return root @ root.T


@pytest.mark.parametrize("name", SUITES)
@pytest.mark.parametrize("seed", range(3))
def test_predict_is_equation_3(name, seed):
    suite, rng = SUITES[name], np.random.default_rng(seed)
    n, m = suite.n_states, suite.n_dynamic
    P = random_covariance(rng, n)
    F, Q = np.eye(n), np.zeros((n, n))
    F[:m, :m] = expm(suite.dynamics_matrix(rng.standard_normal(3)))
    sparse_F = {(i, j): F[i, j] for i, j in transition_pattern(suite)}
    noisy = np.isin(np.arange(m), [i for i, _ in sparse_F])
    Q[:m, :m] = random_covariance(rng, m) * np.outer(noisy, noisy)
    lower = Lower(P)
    sparse_Q = {(i, j): Q[i, j] for i in range(m) for j in range(i + 1)}
    predict(lower, n, sparse_F, sparse_Q)
    np.testing.assert_allclose(lower.dense(), F @ P @ F.T + Q, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", SUITES)
@pytest.mark.parametrize("seed", range(3))
def test_update_is_equation_4(name, seed):
    suite, rng = SUITES[name], np.random.default_rng(seed)
    P = random_covariance(rng, suite.n_states)
    for sensor in suite.sensors:
        v, R = rng.standard_normal(3), np.diag(rng.uniform(0.1, 1.0, 3))
        H = suite.measurement_matrix(sensor, v)
        K = P @ H.T @ np.linalg.inv(R + H @ P @ H.T)
        lower, closed = Lower(P), Lower(P)

        measure = partial(suite.measure, sensor, Vec3(*v))
        update(lower, suite.n_states, measure, np.diag(R))
        np.testing.assert_allclose(lower.dense(), P - K @ H @ P, rtol=1e-10, atol=1e-10)
        update(closed, suite.n_states, measure, np.diag(R), gate=0.0)
        np.testing.assert_array_equal(closed.dense(), Lower(P).dense())


@pytest.mark.parametrize("name", SUITES)
def test_transition_pattern_holds_every_entry_that_is_not_the_identitys(name):
    suite, rng = SUITES[name], np.random.default_rng(7)
    pattern = set(transition_pattern(suite))
    for _ in range(5):
        F = expm(suite.dynamics_matrix(rng.standard_normal(3)))
        differs = {(int(i), int(j)) for i, j in np.argwhere(np.eye(len(F)) != F)}
        assert differs <= pattern
        assert pattern <= {(int(i), int(j)) for i, j in np.argwhere(F != 0.0)}
    constant = set(range(suite.n_dynamic)) - {i for i, _ in pattern}
    assert not suite.diffusion()[list(constant)].any()


@pytest.mark.parametrize("seed", range(5))
def test_last_pivot_tells_positive_matrices_from_others(seed):
    rng = np.random.default_rng(seed)
    P = random_covariance(rng, 9)
    expected = np.linalg.cholesky(P)[-1, -1]
    assert last_pivot(Lower(P), 9) == pytest.approx(expected, rel=1e-10)
    values, vectors = np.linalg.eigh(P)
    values[3] *= -1e-3
    with np.errstate(invalid="ignore"):
        assert np.isnan(last_pivot(Lower(vectors @ np.diag(values) @ vectors.T), 9))
