"""Kalman filter of a single candidate with filterpy and with plain NumPy, as baselines for the
speed of the kernel.

Only predict and update are inside the loops. F, Q, R and all H are computed beforehand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from filterpy.kalman import KalmanFilter
from mgeo_attitude import FilterModel
from mgeo_attitude.filter.reference import discretize_van_loan
from mgeo_attitude.maneuvers.motion import compute_attitudes
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FilterMatrices:
    """Matrices of the filter along one maneuver of n steps."""

    P0: Floats
    F: Floats
    Q: Floats
    R: Floats
    #: Measurement matrix of each step, shape (n, n_rows, n_states).
    H: Floats


def build_matrices(model: FilterModel, omega: Floats, n_steps: int) -> FilterMatrices:
    """Return the filter matrices for `n_steps` steps at the constant body rate `omega` [rad/s]."""
    F, Q = discretize_van_loan(model, omega)
    C = compute_attitudes(omega[None], np.zeros(1, dtype=np.int64), n_steps, model.step)[1:]
    v = np.einsum("kij,ksj->ksi", C, model.references[1 : n_steps + 1])
    sensors = model.suite.sensors
    H = [model.suite.measurement_matrix(sensor, v[:, s]) for s, sensor in enumerate(sensors)]
    R = np.concatenate([np.square(sensor.noise_sigmas()) for sensor in sensors])
    return FilterMatrices(
        P0=np.diag(model.initial_sigma**2), F=F, Q=Q, R=np.diag(R), H=np.concatenate(H, axis=1)
    )


def run_filterpy(matrices: FilterMatrices) -> Floats:
    """Return the covariance after the last step by filterpy, shape (n_states, n_states)."""
    rows, n = matrices.H.shape[1:]
    kf = KalmanFilter(dim_x=n, dim_z=rows)
    # The state must be one-dimensional, because filterpy broadcasts its default of shape (n, 1).
    kf.x = np.zeros(n)
    kf.P, kf.F, kf.Q, kf.R = matrices.P0, matrices.F, matrices.Q, matrices.R
    z = np.zeros(rows)
    for H in matrices.H:
        kf.predict()
        kf.update(z, H=H)
    P: Floats = kf.P
    return P


def run_numpy(matrices: FilterMatrices) -> Floats:
    """Return the covariance after the last step by equations (3) and (4), shape (n_states,
    n_states).
    """
    P, F, Q, R = matrices.P0, matrices.F, matrices.Q, matrices.R
    for H in matrices.H:
        P = F @ P @ F.T + Q
        PHt = P @ H.T
        P = P - PHt @ np.linalg.inv(H @ PHt + R) @ PHt.T
    return P
