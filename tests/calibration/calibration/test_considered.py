"""Batches with considered states, against one update that does not estimate these states."""

import numpy as np
import pytest
from mgeo_attitude import Gyro, Magnetometer, Suite, SunSensor
from mgeo_attitude.filter.reference import update_with_considered_states
from mgeo_calibration.calibration.calibrate import reset_considered_states
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.smoother import compute_last_covariance, solve_linearized
from mgeo_calibration.estimation.trajectory import Partition

from ...attitude.filter.suites import SUITES
from .test_smoother import MEMS, build_batch_near_truth, build_dense_equations, build_scenario

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


def build_correlated_prior(suite, at):
    """Return a prior as a calibration leaves it: correlated errors and estimates other than
    zero.
    """
    rng, n = np.random.default_rng(5), suite.n_states
    root = np.eye(n) + 0.1 * rng.standard_normal((n, n))
    P = root @ root.T
    spread = np.sqrt(np.diag(P))
    sigma = suite.initial_sigma(1.0)
    states = 0.3 * sigma * rng.standard_normal(n)
    for first in suite.rotation_indices:
        states[first : first + 3] = 0.0
    return PriorEstimate(suite, at.attitude[0], states, sigma, P / np.outer(spread, spread))


@pytest.mark.parametrize("name", CASES)
def test_considered_states_act_as_measurement_noise(name, monkeypatch):
    """Expected: a Kalman update by all readings at once, whose gain is zero for the considered
    states.
    """
    monkeypatch.setitem(SUITES, name, CASES[name])
    changes = MEMS | ({"rate_random_walk": 0.0} if name == "constant bias" else {})
    data, at = build_batch_near_truth(build_scenario(name, **changes), broken=False)
    suite = data.suite
    sigma, parts = suite.initial_sigma(1.0), Partition.from_suite(suite)
    at.states[:, suite.considered_indices] = 0.0
    belief = build_correlated_prior(suite, at)
    J, r = build_dense_equations(data, sigma, at, parts)
    r[: suite.n_states], of_start = belief.compute_residual(at.attitude[0], at.states[0])
    N, d = len(data.times), len(parts.stochastic)
    J[: suite.n_states, :d] = of_start[:, parts.stochastic]
    J[: suite.n_states, N * d :] = of_start[:, parts.constant]
    state = np.concatenate([np.tile(parts.stochastic, N), parts.constant])
    of = np.isin(state, suite.considered_indices)
    scale = sigma[state]
    J, believed = J * scale, suite.n_states + (N - 1) * d  # Rows of the prior and of the dynamics.
    before, H, z = J[:believed], J[believed:], r[believed:]
    Q, R = np.linalg.qr(before)
    root = np.linalg.inv(R)
    P, mean, HR = root @ root.T, root @ (Q.T @ r[:believed]), H @ root
    gain = np.linalg.solve(HR @ HR.T + np.eye(len(z)), HR @ root.T).T
    mean = mean + np.where(of, 0.0, gain @ (z - H @ mean))
    P = update_with_considered_states(P, H, np.eye(len(z)), np.flatnonzero(of))
    spread = np.sqrt(np.diag(P))

    found = solve_linearized(data, belief, at, parts)
    estimated = (
        np.concatenate([found.stochastic_errors.ravel(), found.constant_errors])[~of] / scale[~of]
    )
    np.testing.assert_allclose((estimated - mean[~of]) / spread[~of], 0.0, atol=1e-9)
    whole = compute_last_covariance(found)
    states, last = reset_considered_states(belief, found, np.ones(suite.n_states), whole)
    index = np.empty(suite.n_states, dtype=int)
    index[parts.stochastic] = (N - 1) * d + np.arange(d)
    index[parts.constant] = N * d + np.arange(len(parts.constant))
    grown = np.ones(suite.n_states)
    grown[parts.constant] = found.constant_factors[-1]
    unit = spread[index] * scale[index] * grown
    expected = P[np.ix_(index, index)] / np.outer(spread[index], spread[index])
    np.testing.assert_allclose(last / np.outer(unit, unit), expected, rtol=0, atol=1e-9)
    c = suite.considered_indices
    left = grown[c] * (scale * mean)[index[c]]
    np.testing.assert_allclose(states[c] / unit[c], left / unit[c], rtol=0, atol=1e-9)
    assert (np.delete(states, c) == 1.0).all()
