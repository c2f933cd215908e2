"""Independent lower bound: information of a complete history, averaged over attitudes.

The computation shares only the error model of the suite with the package. F and Q follow from Van
Loan's method, attitudes from scipy, and the information matrix contains all states at all steps.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from mgeo_attitude import FilterModel
from mgeo_attitude.filter.reference import discretize_van_loan
from mgeo_attitude.maneuvers.motion import compute_attitudes
from numpy.typing import NDArray
from scipy.linalg import inv, solve_triangular

Floats = NDArray[np.float64]


def mean_covariance(model: FilterModel, rate: Floats, rotations: Floats) -> Floats:
    """Return the final covariance that the mean information over rotated histories gives.

    Parameters
    ----------
    rate : array, shape (3,)
        Body rate of the first history [rad/s].
    rotations : array, shape (n, 3, 3)
        Rotations of attitude and rate for the other histories.

    Returns
    -------
    array, shape (n_states, n_states)
        Covariance of all states, with the attitude error in GCRS.
    """
    information = sum(
        jacobian.T @ jacobian
        for jacobian in (_jacobian(model, rotation, rate) for rotation in rotations)
    )
    at_end = _columns(model, model.n_steps)
    scale = np.sqrt(np.diag(information) / len(rotations))
    scaled = information / len(rotations) / np.outer(scale, scale)
    covariance = inv(scaled) / np.outer(scale, scale)
    return covariance[np.ix_(at_end, at_end)]


def _columns(model: FilterModel, k: int) -> Floats:
    """Return the columns of the states at step k. Driven states have columns for each step."""
    driven = _driven(model)
    constant = (model.n_steps + 1) * driven.sum()
    columns = np.empty(len(driven), dtype=int)
    columns[driven] = k * driven.sum() + np.arange(driven.sum())
    columns[~driven] = constant + np.arange((~driven).sum())
    return columns


def _driven(model: FilterModel) -> NDArray[np.bool_]:
    driven = np.zeros(model.suite.n_states, dtype=bool)
    driven[: model.suite.n_dynamic] = model.suite.compute_noise_density() > 0.0
    return driven


def _jacobian(model: FilterModel, rotation: Floats, rate: Floats) -> Floats:
    """Return the normalized rows of prior, dynamics and measurements of one history."""
    model = dataclasses.replace(model, initial_attitude=rotation @ model.initial_attitude)
    rate, driven, n = rotation @ rate, _driven(model), model.suite.n_states
    starts = np.zeros(1, dtype=int)
    C = compute_attitudes(rate[None], starts, model.n_steps, model.step, model.initial_attitude)
    width = (model.n_steps + 1) * driven.sum() + (~driven).sum()
    rows = []

    def add(matrix: Floats, factor: Floats, *steps: int) -> None:
        """Add rows matrix @ [x(k) for k in steps] with the noise covariance factor @ factor.T."""
        row = np.zeros((len(matrix), width))
        for part, k in zip(np.split(matrix, len(steps), axis=1), steps, strict=True):
            part = part.copy()
            part[:, :3] = part[:, :3] @ C[k]
            row[:, _columns(model, k)] += part
        rows.append(solve_triangular(factor, row, lower=True))

    add(np.eye(n), np.linalg.cholesky(model.initial_covariance), 0)
    F, Q = discretize_van_loan(model, rate)
    lower = np.linalg.cholesky(Q[np.ix_(driven, driven)])
    H = _measurements(model, C)
    for k in range(1, model.n_steps + 1):
        add(np.hstack([F[driven], -np.eye(n)[driven]]), lower, k - 1, k)
        for index, sensor in enumerate(model.suite.sensors):
            if model.available[k, index]:
                add(H[index][k], np.diag(sensor.noise_sigmas()), k)
    return np.concatenate(rows)


def _measurements(model: FilterModel, C: Floats) -> list[Floats]:
    """Return the measurement matrix of each sensor, shape (n_steps + 1, 3, n_states)."""
    matrices = []
    for index, sensor in enumerate(model.suite.sensors):
        rows = model.suite.find_auxiliary_rows(index)
        v, *auxiliary_vectors = (
            np.einsum("kij,kj->ki", C, model.references[:, row])
            for row in (index, *range(rows.start, rows.stop))
        )
        matrices.append(model.suite.measurement_matrix(sensor, v, C, auxiliary_vectors))
    return matrices
