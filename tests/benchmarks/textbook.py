"""Baselines: predict and update of one candidate with filterpy, and with bare NumPy.

Only predict and update are inside the loops; F, Q, R and every H are ready beforehand.
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
class Matrices:
    """The filter of one maneuver over n steps."""

    P0: Floats
    F: Floats
    Q: Floats
    R: Floats
    #: One for each step, shape (n, rows, n_states).
    H: Floats


def matrices(model: FilterModel, omega: Floats, n_steps: int) -> Matrices:
    """Matrices of `n_steps` steps at constant body rate `omega` [rad/s]."""
    F, Q = discretize_van_loan(model, omega)
    C = compute_attitudes(omega[None], np.zeros(1, dtype=np.int64), n_steps, model.step)[1:]
    v = np.einsum("kij,ksj->ksi", C, model.references[1 : n_steps + 1])
    sensors = model.suite.sensors
    H = [model.suite.measurement_matrix(sensor, v[:, s]) for s, sensor in enumerate(sensors)]
    R = np.concatenate([np.square(sensor.noise_sigmas()) for sensor in sensors])
    return Matrices(
        P0=np.diag(model.initial_sigma**2), F=F, Q=Q, R=np.diag(R), H=np.concatenate(H, axis=1)
    )


def run_filterpy(given: Matrices) -> Floats:
    """Covariance after the last step, shape (n_states, n_states)."""
    rows, n = given.H.shape[1:]
    kf = KalmanFilter(dim_x=n, dim_z=rows)
    kf.x = np.zeros(n)  # one-dimensional: filterpy broadcasts its (n, 1) default when given H
    kf.P, kf.F, kf.Q, kf.R = given.P0, given.F, given.Q, given.R
    z = np.zeros(rows)
    for H in given.H:
        kf.predict()
        kf.update(z, H=H)
    P: Floats = kf.P
    return P


def run_numpy(given: Matrices) -> Floats:
    """Covariance after the last step, shape (n_states, n_states); equations (3) and (4)."""
    P, F, Q, R = given.P0, given.F, given.Q, given.R
    for H in given.H:
        P = F @ P @ F.T + Q
        PHt = P @ H.T
        P = P - PHt @ np.linalg.inv(H @ PHt + R) @ PHt.T
    return P
