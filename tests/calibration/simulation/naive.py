"""Error-state filter of a single run with dense matrices, quaternions and hand-written derivatives.

It serves as the reference for suites of a plain gyro, Sun sensors and magnetometers, whose
measurement is R(φ) C v + b.
"""

from functools import cache

import numpy as np
from mgeo_attitude.filter.reference import discretize_van_loan
from scipy.spatial.transform import Rotation


def skew(a):
    return np.cross(a, np.eye(3)).T


def rotation_from_gibbs(g):
    """Return the rotation of twice the Gibbs vector g."""
    return Rotation.from_quat([*(0.5 * g), 1.0])


def gibbs_vector(turn):
    x, y, z, w = turn.as_quat()
    return 2.0 * np.array([x, y, z]) / w


def run_filter(model, readings, rates, estimator):
    """Return attitude, states and covariance after every sample, with rotation vectors as states of
    misalignments.
    """
    suite, n = model.suite, model.suite.n_states
    C, x, P = Rotation.identity(), np.zeros(n), np.diag(model.initial_sigma**2)
    estimates = [(C.as_matrix(), x, P)]
    F_rest = discretize_van_loan(model, np.zeros(3))[0]
    discretize = cache(lambda *rate: discretize_van_loan(model, np.array(rate)))
    for k, rate in enumerate(rates, start=1):
        F, Q = (A.copy() for A in discretize(*rate))
        mean_bias = -np.diag(F_rest[:3, 3:6]) * x[3:6] / model.step
        turn = Rotation.from_rotvec(-(readings.gyro[k - 1] - mean_bias) * model.step)
        F[:3, :3] = turn.as_matrix()
        C, x, P = turn * C, x.copy(), F @ P @ F.T + Q
        x[3:6] *= np.diag(F_rest)[3:6]
        for index, sensor in enumerate(suite.sensors):
            y = readings.sensors[index][k, 0]
            if not np.isnan(y).any():
                R = np.diag(np.square(sensor.noise_sigmas()))
                first = 6 + 6 * index
                C, x, P = update(C, x, P, y, R, model.references[k, index], first, estimator)
        estimates.append((C.as_matrix(), x, P))
    return estimates


def update(C, x, P, y, R, reference, first, estimator):
    v, mounting = C.apply(reference), rotation_from_gibbs(x[first : first + 3]).as_matrix()
    r = y - mounting @ v - x[first + 3 : first + 6]
    M = np.eye(3) if estimator.jacobians == "aligned" else mounting
    H, B = np.zeros((3, len(x))), np.zeros((3, len(x), len(x)))
    H[:, :3], H[:, first : first + 3], H[:, first + 3 : first + 6] = (
        M @ skew(v),
        -M @ skew(v),
        np.eye(3),
    )
    for i, a in enumerate(np.eye(3)):
        for j, b in enumerate(np.eye(3)):
            both = 0.5 * (np.cross(a, np.cross(b, v)) + np.cross(b, np.cross(a, v)))
            B[:, i, j] = B[:, first + i, first + j] = -M @ both
            mixed = M @ np.cross(a, np.cross(b, v))  # misalignment a and attitude b
            B[:, first + i, j] = B[:, j, first + i] = mixed
    z, S = r, H @ P @ H.T + R
    if estimator.second_order:
        z = z + [0.5 * np.trace(b @ P) for b in B]
        S = S + [[0.5 * np.trace(b @ P @ c @ P) for c in B] for b in B]
    e = P @ H.T @ np.linalg.solve(S, z)
    P = P - P @ H.T @ np.linalg.solve(S, H @ P)
    if estimator.reset:
        T = np.eye(len(x))
        for block in list_rotation_blocks(len(x)):
            g = e[block]
            T[block, block] = (np.eye(3) - 0.5 * skew(g)) / (1.0 + 0.25 * g @ g)
        P = T @ P @ T.T
    return *correct(C, x, e), 0.5 * (P + P.T)


def correct(C, x, e):
    corrected = x + e
    corrected[:3] = 0.0
    for block in list_rotation_blocks(len(x))[1:]:
        corrected[block] = gibbs_vector(
            rotation_from_gibbs(x[block]) * rotation_from_gibbs(e[block])
        )
    return rotation_from_gibbs(-e[:3]) * C, corrected


def list_rotation_blocks(n):
    """Return the slices of the attitude and of each sensor's misalignment."""
    return [slice(0, 3), *(slice(first, first + 3) for first in range(6, n, 6))]
