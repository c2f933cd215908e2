"""What a solution leaves of the readings: each against all others, and against those before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.estimation.batch import Batch
from mgeo_attitude.estimation.linearization import sightings
from mgeo_attitude.estimation.smoother import Solution, derivatives, diagonal_blocks


@dataclass(frozen=True, eq=False)
class Innovations:
    """Of m readings of a sensor, each predicted from those before it.

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
        own, total = derivatives(seen, solution.parts, solution.steps, solution.follow)
        total = total - own @ solution.border[seen.samples]
        HPH = own @ given[seen.samples] @ own.swapaxes(1, 2)
        HPH += total @ solution.covariance @ total.swapaxes(1, 2)
        sign = np.where(without[seen.samples], 1.0, -1.0)[:, None, None]
        S = np.diag(seen.noise**2) + sign * HPH
        squares = np.full(len(batch.times), np.nan)
        squares[seen.samples] = _squares(S, seen.z)
        found.append(squares)
    return tuple(found)


def innovations(solution: Solution, past: Filtered) -> tuple[Innovations, ...]:
    """Of every sensor, by the Kalman filter that is linear about a solution."""
    move, found = solution.steps, []
    F, Ft = move.F, move.F.swapaxes(1, 2)
    # of every sample by what came before: δ = offset - slope c, and its covariance for a known c
    offset, slope, P = (np.zeros_like(part) for part in (past.offset, past.slope, past.given))
    offset[1:] = np.einsum("nij,nj->ni", F, past.offset[:-1]) + move.defect
    slope[1:] = F @ past.slope[:-1]
    P[1:] = F @ past.given[:-1] @ Ft + move.Q
    information, gradient = solution.prior
    first = np.linalg.inv(information)
    common = np.concatenate([(first @ gradient)[None], past.common[:-1]])
    covariance = np.concatenate([first[None], past.covariance[:-1]])
    for seen in solution.sightings:
        k = seen.samples
        own, total = derivatives(seen, solution.parts, move, solution.follow)
        total = total - own @ slope[k]
        r = seen.z - np.einsum("nij,nj->ni", own, offset[k])
        r -= np.einsum("nij,nj->ni", total, common[k])
        S = own @ P[k] @ own.swapaxes(1, 2) + total @ covariance[k] @ total.swapaxes(1, 2)
        S += np.diag(seen.noise**2)
        whitened = np.linalg.solve(np.linalg.cholesky(S), r[..., None])[..., 0]
        found.append(Innovations(k, whitened))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Filtered:
    """The linear filter after the readings of each of N samples.

    Attributes
    ----------
    common, covariance : arrays, shapes (N, q) and (N, q, q)
        c, the errors at the start and of the constants.
    offset, slope, given : arrays, shapes (N, d), (N, d, q) and (N, d, d)
        δ = offset - slope c, with this covariance for a known c.
    """

    common: Floats
    covariance: Floats
    offset: Floats
    slope: Floats
    given: Floats

    def errors(self, solution: Solution) -> Floats:
        """Estimated driven errors of the solution's trajectory, shape (N, d)."""
        J = solution.follow - self.slope
        e: Floats = self.offset + np.einsum("nij,nj->ni", J, self.common)
        return e

    def covariances(self, solution: Solution) -> Floats:
        """Of the driven states, shape (N, d, d)."""
        J = solution.follow - self.slope
        P: Floats = self.given + J @ self.covariance @ J.swapaxes(1, 2)
        return P


def filtered(solution: Solution) -> Filtered:
    """The filter that is linear about a solution, read off its Cholesky factor.

    The factor's block of a sample is the filter's information there with that of the step after
    it, and the solution tells what forward substitution has come to. So nothing is done one sample
    after the other.
    """
    move, (N, d) = solution.steps, solution.free.shape
    q = solution.follow.shape[-1]
    D = diagonal_blocks(solution)
    flow = np.linalg.solve(move.Q, move.F).swapaxes(1, 2)[1:]  # Fᵀ Q⁻¹
    y, y_c = (D @ x[1:].reshape(N - 1, d, -1) for x in (solution.free, solution.border))
    y[:-1] -= flow @ solution.free[2:, :, None]
    y_c[:-1] -= flow @ solution.border[2:]
    eliminated = np.linalg.solve(D, np.concatenate([y, y_c], axis=2))
    information = D.copy()
    information[:-1] -= flow @ move.F[1:]
    y[:-1] += flow @ move.defect[1:, :, None]

    given, offset, slope = np.zeros((N, d, d)), np.zeros((N, d)), np.zeros((N, d, q))
    given[1:] = np.linalg.inv(0.5 * (information + information.swapaxes(1, 2)))
    offset[1:], slope[1:] = (given[1:] @ y)[..., 0], given[1:] @ y_c

    C, g = np.zeros((N, q, q)), np.zeros((N, q))
    C[0], g[0] = solution.prior
    for seen in solution.sightings:
        _, total = derivatives(seen, solution.parts, move, solution.follow)
        total = total / seen.noise[:, None]
        C[seen.samples] += total.swapaxes(1, 2) @ total
        g[seen.samples] += np.einsum("nij,ni->nj", total, seen.z / seen.noise)
    t = y_c.swapaxes(1, 2)[:-1]
    C[2:] -= t @ eliminated[:-1, :, 1:]
    g[2:] -= (t @ eliminated[:-1, :, :1])[..., 0]
    C, g = C.cumsum(axis=0), g.cumsum(axis=0)
    C[1:] -= y_c.swapaxes(1, 2) @ slope[1:]
    g[1:] -= np.einsum("nij,ni->nj", y_c, offset[1:])
    covariance = np.linalg.inv(0.5 * (C + C.swapaxes(1, 2))).astype(np.float64, copy=False)
    common: Floats = np.einsum("nij,nj->ni", covariance, g)
    return Filtered(common, covariance, offset, slope, given)


def _squares(S: Floats, r: Floats) -> Floats:
    solved = np.linalg.solve(S, r[..., None])[..., 0]
    squares: Floats = np.einsum("ni,ni->n", r, solved)
    return squares
