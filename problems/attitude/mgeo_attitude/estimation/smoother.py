"""The fixed-interval smoother: the most probable trajectory and constants of a whole batch.

Gauss-Newton on all residuals at once (B. M. Bell, The iterated Kalman smoother as a Gauss-Newton
method, SIAM Journal on Optimization 4 (1994) 626-636). Driven states, those of every sample, make
the normal equations block tridiagonal; the constants border them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cho_solve_banded, cholesky_banded

from mgeo_attitude._typing import Floats
from mgeo_attitude.estimation.batch import Batch
from mgeo_attitude.estimation.belief import Belief
from mgeo_attitude.estimation.linearization import (
    Partition,
    Sightings,
    Steps,
    Trajectory,
    moved,
    sightings,
    steps,
)

#: A step this small, in 1-sigmas of the constants and in rad, is the last.
CONVERGED = 1e-5, 1e-7
_HALVINGS = 4  # of a step that makes it worse


@dataclass(frozen=True, eq=False)
class Solution:
    """The normal equations at a trajectory, solved.

    Driven errors are e_k = Ψ_k c + δ_k: what errors c at the start and of the constants lead to,
    and what noise has added since, with δ_0 = 0. So the banded part is well conditioned, however
    little is known of the attitude and however good the gyro is.

    Attributes
    ----------
    trajectory : Trajectory
        About which they are linear.
    parts : Partition
    steps : Steps
    sightings : tuple of Sightings
        One a sensor.
    cost : float
        Sum of squares of all residuals over their 1-sigmas.
    prior : tuple of arrays
        Information on c from what is believed, shape (q, q), and its gradient, shape (q,).
    follow : array, shape (N, d, q)
        Ψ.
    factor : array, shape (2 d, (N - 1) d)
        Banded Cholesky factor of the information on δ_1, δ_2...
    free : array, shape (N, d)
    border : array, shape (N, d, q)
        δ = free - border c.
    covariance : array, shape (q, q)
        Of c: of the driven errors at the first sample, then of those of the constants.
    common : array, shape (q,)
        c, to be taken out.
    """

    trajectory: Trajectory
    parts: Partition
    steps: Steps
    sightings: tuple[Sightings, ...]
    cost: float
    prior: tuple[Floats, Floats]
    follow: Floats
    factor: Floats
    free: Floats
    border: Floats
    covariance: Floats
    common: Floats

    @property
    def e(self) -> Floats:
        """Driven errors, to be taken out, shape (N, d)."""
        e: Floats = self.free + (self.follow - self.border) @ self.common
        return e

    @property
    def e_c(self) -> Floats:
        """Errors of the constants, to be taken out, shape (c,)."""
        return self.common[len(self.parts.driven) :]

    @property
    def constants_covariance(self) -> Floats:
        """Of the constants, shape (c, c)."""
        d = len(self.parts.driven)
        return self.covariance[d:, d:]

    def settled(self, times: float = 1.0) -> bool:
        """Whether the step is small enough to be the last, so many times `CONVERGED`."""
        step = np.abs(self.e_c / np.sqrt(np.diag(self.constants_covariance))).max(initial=0.0)
        turn = np.abs(self.e[:, :3]).max()
        return bool(step < times * CONVERGED[0] and turn < times * CONVERGED[1])


def solve(
    batch: Batch, belief: Belief, start: Trajectory, iterations: int, tolerance: float = 1.0
) -> Solution:
    """Iterate from a trajectory until it is `settled`, at most so many times."""
    parts = Partition.of(batch.suite)
    found = linear_solution(batch, belief, start, parts)
    for _ in range(iterations):
        if found.settled(tolerance):
            break
        share = 1.0
        for _ in range(_HALVINGS):
            growth = found.steps.growth
            e, e_c = share * found.e, share * found.e_c
            at = moved(found.trajectory, parts, growth, e, e_c, batch.suite)
            better = linear_solution(batch, belief, at, parts)
            if better.cost <= found.cost * (1.0 + 1e-9):
                break
            share *= 0.5
        found = better
    return found


def linear_solution(batch: Batch, belief: Belief, at: Trajectory, parts: Partition) -> Solution:
    """Normal equations about a trajectory and the step that solves them."""
    move = steps(batch, at, parts)
    seen = tuple(sightings(batch, index, at) for index in range(len(batch.suite.sensors)))
    N, d = len(batch.times), len(parts.driven)
    follow = _followed(move)
    q = follow.shape[-1]

    r, J = belief.residual(at.attitude[0], at.states[0])
    J = J[:, np.concatenate([parts.driven, parts.constant])]
    believed = J.T @ J, J.T @ r
    C, g_c = believed[0].copy(), believed[1].copy()
    cost = float(r @ r)

    A, below = np.zeros((N, d, d)), np.zeros((N, d, d))
    B, g = np.zeros((N, d, q)), np.zeros((N, d))
    information = np.linalg.inv(move.Q)
    IF = information @ move.F
    Id = np.einsum("nij,nj->ni", information, move.defect)
    Ft = move.F.swapaxes(1, 2)
    A[1:] += information
    A[:-1] += Ft @ IF
    below[:-1] = -IF
    g[1:] += Id
    g[:-1] -= np.einsum("nij,nj->ni", Ft, Id)
    cost += float(np.einsum("ni,ni->", move.defect, Id))

    for each in seen:
        k = each.samples
        if not len(k):
            continue
        z = each.z / each.noise
        own, total = derivatives(each, parts, move, follow)
        own, total = own / each.noise[:, None], total / each.noise[:, None]
        t = own.swapaxes(1, 2)
        A[k] += t @ own
        B[k] += t @ total
        C += _inner(total, total)
        g[k] += np.einsum("nij,ni->nj", own, z)
        g_c += _inner(total, z[..., None])[:, 0]
        cost += float(np.einsum("ni,ni->", z, z))

    free, border = np.zeros((N, d)), np.zeros((N, d, q))
    factor = cholesky_banded(_banded(A[1:], below[1:]), lower=True, check_finite=False)
    rows = np.column_stack([B[1:].reshape(-1, q), g[1:].ravel()])
    solved = cho_solve_banded((factor, True), rows, check_finite=False)
    border[1:], free[1:] = solved[:, :q].reshape(-1, d, q), solved[:, q].reshape(-1, d)
    eliminated = _inner(B[1:], solved.reshape(-1, d, q + 1))
    schur = cho_factor(C - eliminated[:, :q])
    common = cho_solve(schur, g_c - eliminated[:, q])
    covariance = cho_solve(schur, np.eye(q))
    return Solution(
        trajectory=at,
        parts=parts,
        steps=move,
        sightings=seen,
        cost=cost,
        prior=believed,
        follow=follow,
        factor=factor,
        free=free,
        border=border,
        covariance=0.5 * (covariance + covariance.T),
        common=common,
    )


def derivatives(
    seen: Sightings, parts: Partition, move: Steps, follow: Floats
) -> tuple[Floats, Floats]:
    """Of readings by δ, shape (m, 3, d), and by c, shape (m, 3, q)."""
    own = np.zeros((len(seen.samples), 3, len(parts.driven)))
    driven = np.flatnonzero(np.isin(seen.states, parts.driven))
    constant = np.flatnonzero(np.isin(seen.states, parts.constant))
    places = np.searchsorted(parts.driven, seen.states[driven])
    own[:, :, places] = seen.H[:, :, driven]
    total = seen.H[:, :, driven] @ follow[seen.samples][:, places]
    places = np.searchsorted(parts.constant, seen.states[constant])
    growth = move.growth[seen.samples][:, None, places]
    total[:, :, len(parts.driven) + places] += seen.H[:, :, constant] * growth
    return own, total


def diagonal_blocks(solution: Solution) -> Floats:
    """D_k = L_k L_kᵀ of the factor's blocks on the diagonal, shape (N - 1, d, d).

    Information on δ_k, k = 1, 2..., of what came before, of sample k and of the step after it.
    """
    d = len(solution.parts.driven)
    L = np.zeros((len(solution.free) - 1, d, d))
    for i in range(d):
        for j in range(i + 1):
            L[:, i, j] = solution.factor[i - j, j::d]
    blocks: Floats = L @ L.swapaxes(1, 2)
    return blocks


def smoothed_covariances(solution: Solution) -> Floats:
    """Of δ at every sample, shape (N, d, d), for a known c; see `covariances`."""
    D = np.linalg.inv(diagonal_blocks(solution)).astype(np.float64, copy=False)
    # δ_k = D⁻¹ (y_k + Fᵀ Q⁻¹ δ_{k+1})
    F, Q = solution.steps.F[1:], solution.steps.Q[1:]
    gain = D[:-1] @ np.linalg.solve(Q, F).swapaxes(1, 2)
    P = np.concatenate([np.zeros((1, *D.shape[1:])), D])
    for k in range(len(gain), 0, -1):
        P[k] += gain[k - 1] @ P[k + 1] @ gain[k - 1].T
    return P


def covariances(solution: Solution, given: Floats) -> Floats:
    """Of the driven states at every sample, shape (N, d, d).

    Parameters
    ----------
    given : array, shape (N, d, d)
        `smoothed_covariances`.
    """
    J = solution.follow - solution.border
    P: Floats = given + J @ solution.covariance @ J.swapaxes(1, 2)
    return P


def last_covariance(solution: Solution, given: Floats) -> Floats:
    """Of all states at the last sample, shape (n_states, n_states)."""
    parts, growth = solution.parts, solution.steps.growth[-1]
    d, n = len(parts.driven), len(parts.driven) + len(parts.constant)
    J = solution.follow[-1] - solution.border[-1]
    cross = J @ solution.covariance[:, d:] * growth
    P = np.zeros((n, n))
    P[np.ix_(parts.driven, parts.driven)] = covariances(solution, given)[-1]
    P[np.ix_(parts.constant, parts.constant)] = (
        growth[:, None] * solution.constants_covariance * growth
    )
    P[np.ix_(parts.driven, parts.constant)] = cross
    P[np.ix_(parts.constant, parts.driven)] = cross.T
    return P


def _followed(move: Steps) -> Floats:
    """Ψ: from errors at the first sample, and of the constants, to driven ones."""
    n, d, c = move.G.shape
    follow = np.zeros((n + 1, d, d + c))
    follow[0, :, :d] = np.eye(d)
    follow[1:, :, d:] = move.G
    for k in range(n):
        follow[k + 1] += move.F[k] @ follow[k]
    return follow


def _inner(a: Floats, b: Floats) -> Floats:
    """Sum over n of a_nᵀ b_n, of arrays of shapes (n, k, i) and (n, k, j).

    Not by BLAS, whose threads would add in another order, and wait for each other.
    """
    product: Floats = np.einsum("nki,nkj->ij", a, b)
    return product


def _banded(A: Floats, below: Floats) -> Floats:
    """Lower band of a symmetric block tridiagonal matrix, shape (2 d, N d)."""
    N, d, _ = A.shape
    band = np.zeros((2 * d, N * d))
    for i in range(d):
        for j in range(i + 1):
            band[i - j, j::d] = A[:, i, j]
        for j in range(d):
            band[d + i - j, j::d] = below[:, i, j]
    return band
