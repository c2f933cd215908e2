"""The limit's slow twin: the information of a whole history at once, averaged over attitudes.

It shares with the limit the declaration of the suite alone. F and Q are Van Loan's, the attitude
scipy's, and what is averaged is the information matrix itself, of all states at all steps.
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
    """Covariance of all states at the end, of the mean information over turned histories.

    Parameters
    ----------
    rate : array, shape (3,)
        Of the body in the first of the histories [rad/s].
    rotations : array, shape (n, 3, 3)
        Of the others' body axes: attitudes and rates are turned by them.

    Returns
    -------
    array, shape (n_states, n_states)
        The attitude error in axes of GCRS.
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
    """Where the states at step k are: those that noise drives have a place in each."""
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
    """Whitened rows of prior, dynamics and measurements of one history."""
    model = dataclasses.replace(model, initial_attitude=rotation @ model.initial_attitude)
    rate, driven, n = rotation @ rate, _driven(model), model.suite.n_states
    starts = np.zeros(1, dtype=int)
    C = compute_attitudes(rate[None], starts, model.n_steps, model.step, model.initial_attitude)
    width = (model.n_steps + 1) * driven.sum() + (~driven).sum()
    rows = []

    def add(matrix: Floats, factor: Floats, *steps: int) -> None:
        """Rows matrix @ [x(k) for k in steps], noise factor factorᵀ; attitudes in GCRS axes."""
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
    """H of each sensor at all steps, shape (n_steps + 1, 3, n_states)."""
    found = []
    for index, sensor in enumerate(model.suite.sensors):
        rows = model.suite.gradient_rows(index)
        v, *gradient = (
            np.einsum("kij,kj->ki", C, model.references[:, row])
            for row in (index, *range(rows.start, rows.stop))
        )
        found.append(model.suite.measurement_matrix(sensor, v, C, gradient))
    return found
