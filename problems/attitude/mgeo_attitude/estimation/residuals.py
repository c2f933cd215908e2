"""What a solution leaves of the readings: each against all others, and against those before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.estimation.batch import Batch
from mgeo_attitude.estimation.linearization import Sightings, sightings
from mgeo_attitude.estimation.smoother import Solution, diagonal_blocks


@dataclass(frozen=True, eq=False)
class Innovations:
    """Of m readings of a sensor, each predicted from those before it, constants known.

    Attributes
    ----------
    samples : array of int, shape (m,)
    whitened : array, shape (m, 3)
        L⁻¹ r for the innovation r and its covariance L Lᵀ: standard normal, and independent.
    """

    samples: Ints
    whitened: Floats

    @property
    def nis(self) -> Floats:
        """Normalized innovation squared, shape (m,)."""
        nis: Floats = (self.whitened**2).sum(axis=1)
        return nis


def chi_squares(
    batch: Batch, solution: Solution, given: Floats, rejected: tuple[Bools, ...]
) -> tuple[Floats, ...]:
    """Square of every reading's residual to what all others say, over its covariance.

    That is rᵀ (R ∓ H P Hᵀ)⁻¹ r for the residual r to the smoothed estimate: minus where the reading
    is part of the estimate, plus where it is not. Unlike an innovation it can tell an outlier among
    the first readings, too.

    Parameters
    ----------
    batch : Batch
        With all readings.
    given : array, shape (N, d, d)
        See `smoothed_covariances`.
    rejected : tuple of arrays of bool, shape (N,)
        Of each sensor: readings that the solution was found without.

    Returns
    -------
    tuple of arrays, shape (N,), NaN where there is no reading
    """
    found = []
    for index, without in enumerate(rejected):
        seen = sightings(batch, index, solution.trajectory)
        own, total = _derivatives(seen, solution)
        HPH = own @ given[seen.samples] @ own.swapaxes(1, 2)
        HPH += total @ solution.covariance @ total.swapaxes(1, 2)
        sign = np.where(without[seen.samples], 1.0, -1.0)[:, None, None]
        S = np.diag(seen.noise**2) + sign * HPH
        squares = np.full(len(batch.times), np.nan)
        squares[seen.samples] = _squares(S, seen.z)
        found.append(squares)
    return tuple(found)


def innovations(solution: Solution) -> tuple[Innovations, ...]:
    """Of every sensor, by the Kalman filter that is linear about a settled solution.

    Its information at a sample is what Cholesky's factor has of it less that of the step after it,
    and as the gradient is zero at every sample, its estimate there is off the smoothed one by
    Λ⁻¹ Fᵀ Q⁻¹ defect. So nothing is done one sample after the other.
    """
    estimate, P = predicted(solution)
    found = []
    for seen in solution.sightings:
        own, _ = _derivatives(seen, solution)
        S = own @ P[seen.samples] @ own.swapaxes(1, 2) + np.diag(seen.noise**2)
        r = seen.z - np.einsum("nij,nj->ni", own, estimate[seen.samples])
        whitened = np.linalg.solve(np.linalg.cholesky(S), r[..., None])[..., 0]
        found.append(Innovations(seen.samples, whitened))
    return tuple(found)


def predicted(solution: Solution) -> tuple[Floats, Floats]:
    """Of the linear filter before the readings of each sample: errors (N, d) and covariances."""
    estimate, P = filtered(solution)
    move = solution.steps
    before, Pb = np.zeros_like(estimate), np.empty_like(P)
    Pb[0] = P[0]
    before[1:] = np.einsum("nij,nj->ni", move.F, estimate[:-1]) + move.defect
    Pb[1:] = move.F @ P[:-1] @ move.F.swapaxes(1, 2) + move.Q
    first = np.linalg.inv(P[0])
    for seen in solution.sightings:  # what the first sample's readings have brought
        own, _ = _derivatives(seen, solution)
        for k in np.flatnonzero(seen.samples == 0):
            H = own[k] / seen.noise[:, None]
            first -= H.T @ H
    Pb[0] = np.linalg.inv(first)
    return before, Pb


def filtered(solution: Solution) -> tuple[Floats, Floats]:
    """Of the linear filter after the readings of each sample: errors (N, d) and covariances.

    Constants are known.
    """
    move = solution.steps
    information = diagonal_blocks(solution)
    Ft = move.F.swapaxes(1, 2)
    weights = np.linalg.inv(move.Q)
    information[:-1] -= Ft @ weights @ move.F
    symmetric: Floats = 0.5 * (information + information.swapaxes(1, 2))
    P: Floats = np.asarray(np.linalg.inv(symmetric), dtype=np.float64)
    estimate = np.zeros_like(solution.e)
    flow = np.einsum("nij,njk,nk->ni", Ft, weights, move.defect)
    estimate[:-1] = np.einsum("nij,nj->ni", P[:-1], flow)
    return estimate, P


def filtered_covariances(solution: Solution, given: Floats) -> Floats:
    """Those of `filtered`, P, shape (N, d, d), with the uncertainty of the constants in them."""
    move, border = solution.steps, solution.border
    follow = diagonal_blocks(solution) @ border
    flow = np.linalg.solve(move.Q, move.F).swapaxes(1, 2)
    follow[:-1] -= flow @ (border[1:] + move.G)
    own = given @ follow
    P: Floats = given + own @ solution.covariance @ own.swapaxes(1, 2)
    return P


def _derivatives(seen: Sightings, solution: Solution) -> tuple[Floats, Floats]:
    """Of readings: by driven errors, and by constants that the driven ones follow."""
    parts, k = solution.parts, seen.samples
    full = np.zeros((len(k), 3, len(parts.driven) + len(parts.constant)))
    full[:, :, seen.states] = seen.H
    own = full[:, :, parts.driven]
    others = full[:, :, parts.constant] * solution.steps.growth[k][:, None]
    return own, others - own @ solution.border[k]


def _squares(S: Floats, r: Floats) -> Floats:
    solved = np.linalg.solve(S, r[..., None])[..., 0]
    squares: Floats = np.einsum("ni,ni->n", r, solved)
    return squares
