"""Batches with states that are considered, against one update that leaves them alone."""

import numpy as np
import pytest
from mgeo_attitude import Gyro, Magnetometer, Suite, SunSensor
from mgeo_attitude.estimation.considered import as_believed
from mgeo_attitude.estimation.linearization import Partition
from mgeo_attitude.estimation.smoother import (
    last_covariance,
    linear_solution,
    smoothed_covariances,
)
from mgeo_attitude.filter.reference import schmidt

from ..filter.suites import SUITES
from .test_smoother import MEMS, dense, near, scenario

CASES = {
    "considered": SUITES["considered"],
    "cubesat_6u_full": SUITES["cubesat_6u_full"],
    "bias": Suite(
        Gyro(considered=("bias",), bias_decay=1e-3),
        (SunSensor(), Magnetometer(considered=("bias",))),
    ),
    "constant bias": Suite(
        Gyro(considered=("bias",), bias_decay=1e-3), (SunSensor(), Magnetometer())
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_what_is_considered_is_noise_of_all_readings(name, monkeypatch):
    """A Kalman update by all readings at once, whose gain is zero for what is considered."""
    monkeypatch.setitem(SUITES, name, CASES[name])
    changes = MEMS | ({"rate_random_walk": 0.0} if name == "constant bias" else {})
    data, at = near(scenario(name, **changes), broken=False)
    suite = data.suite
    sigma, parts = suite.initial_sigma(1.0), Partition.of(suite)
    at.states[:, suite.considered] = 0.0
    J, r = dense(data, sigma, at, parts)
    N, d = len(data.times), len(parts.driven)
    state = np.concatenate([np.tile(parts.driven, N), parts.constant])
    of = np.isin(state, suite.considered)
    scale = sigma[state]
    J, believed = J * scale, suite.n_states + (N - 1) * d  # rows of the prior and of dynamics
    before, H, z = J[:believed], J[believed:], r[believed:]
    Q, R = np.linalg.qr(before)
    root = np.linalg.inv(R)
    P, mean, HR = root @ root.T, root @ (Q.T @ r[:believed]), H @ root
    gain = np.linalg.solve(HR @ HR.T + np.eye(len(z)), HR @ root.T).T
    mean = mean + np.where(of, 0.0, gain @ (z - H @ mean))
    P = schmidt(P, H, np.eye(len(z)), np.flatnonzero(of))
    spread = np.sqrt(np.diag(P))

    found = linear_solution(data, sigma, at, parts)
    estimated = np.concatenate([found.e.ravel(), found.e_c])[~of] / scale[~of]
    np.testing.assert_allclose((estimated - mean[~of]) / spread[~of], 0.0, atol=1e-9)
    whole = last_covariance(found, smoothed_covariances(found))
    states, last = as_believed(suite, found, sigma, np.ones(suite.n_states), whole)
    index = np.empty(suite.n_states, dtype=int)
    index[parts.driven] = (N - 1) * d + np.arange(d)
    index[parts.constant] = N * d + np.arange(len(parts.constant))
    grown = np.ones(suite.n_states)
    grown[parts.constant] = found.steps.growth[-1]
    unit = spread[index] * scale[index] * grown
    expected = P[np.ix_(index, index)] / np.outer(spread[index], spread[index])
    np.testing.assert_allclose(last / np.outer(unit, unit), expected, rtol=0, atol=1e-9)
    assert not states[suite.considered].any()
    assert states.sum() == suite.n_states - len(suite.considered)


def test_where_nothing_is_considered_nothing_changes():
    data, at = near(scenario("paper"))
    sigma = data.suite.initial_sigma(1.0)
    found = linear_solution(data, sigma, at, Partition.of(data.suite))
    P, x = np.eye(18), np.ones(18)
    states, covariance = as_believed(data.suite, found, sigma, x, P)
    assert states is x
    assert covariance is P
