"""The fixed-interval smoother: the most probable trajectory and constants of a whole batch.

Gauss-Newton on all residuals at once (B. M. Bell, The iterated Kalman smoother as a Gauss-Newton
method, SIAM Journal on Optimization 4 (1994) 626-636). Driven states, those of every sample, make
the normal equations block tridiagonal; the constants border them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cho_solve_banded, cholesky_banded

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.estimation.batch import Batch
from mgeo_attitude.estimation.linearization import (
    Partition,
    Sightings,
    Steps,
    Trajectory,
    moved,
    prior,
    sightings,
    steps,
)

#: A step this small, in 1-sigmas of the constants and in rad, is the last.
CONVERGED = 1e-6, 1e-9
_HALVINGS = 4  # of a step that makes it worse


@dataclass(frozen=True, eq=False)
class Solution:
    """The normal equations at a trajectory, solved.

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
    factor : array, shape (2 d, N d)
        Banded Cholesky factor of the driven states' part.
    border : array, shape (N, d, c)
        How the driven states follow the constants: -∂e/∂e_c.
    covariance : array, shape (c, c)
        Of the constants.
    e : array, shape (N, d)
    e_c : array, shape (c,)
        Errors of the trajectory, to be taken out.
    """

    trajectory: Trajectory
    parts: Partition
    steps: Steps
    sightings: tuple[Sightings, ...]
    cost: float
    factor: Floats
    border: Floats
    covariance: Floats
    e: Floats
    e_c: Floats

    def settled(self, times: float = 1.0) -> bool:
        """Whether the step is small enough to be the last, so many times `CONVERGED`."""
        step = np.abs(self.e_c / np.sqrt(np.diag(self.covariance))).max(initial=0.0)
        turn = np.abs(self.e[:, :3]).max()
        return bool(step < times * CONVERGED[0] and turn < times * CONVERGED[1])


def solve(
    batch: Batch, sigma: Floats, start: Trajectory, iterations: int, tolerance: float = 1.0
) -> Solution:
    """Iterate from a trajectory until it is `settled`, at most so many times.

    Parameters
    ----------
    sigma : array, shape (n_states,)
        Initial 1-sigmas.
    """
    parts = Partition.of(batch.suite)
    found = linear_solution(batch, sigma, start, parts)
    for _ in range(iterations):
        if found.settled(tolerance):
            break
        share = 1.0
        for _ in range(_HALVINGS):
            growth = found.steps.growth
            e, e_c = share * found.e, share * found.e_c
            at = moved(found.trajectory, parts, growth, e, e_c, batch.suite)
            better = linear_solution(batch, sigma, at, parts)
            if better.cost <= found.cost * (1.0 + 1e-9):
                break
            share *= 0.5
        found = better
    return found


def linear_solution(batch: Batch, sigma: Floats, at: Trajectory, parts: Partition) -> Solution:
    """Normal equations about a trajectory and the step that solves them."""
    move = steps(batch, at, parts)
    seen = tuple(sightings(batch, index, at) for index in range(len(batch.suite.sensors)))
    N, d, c = len(batch.times), len(parts.driven), len(parts.constant)
    A, below = np.zeros((N, d, d)), np.zeros((N, d, d))
    B, C = np.zeros((N, d, c)), np.zeros((c, c))
    g, g_c = np.zeros((N, d)), np.zeros(c)

    r, J = prior(batch.suite, at.states[0], sigma)
    own, others = J[:, parts.driven], J[:, parts.constant]
    A[0] += own.T @ own
    C += others.T @ others
    g[0] += own.T @ r
    g_c += others.T @ r
    cost = float(r @ r)

    information = np.linalg.inv(move.Q)
    IF, IG = information @ move.F, information @ move.G
    Id = np.einsum("nij,nj->ni", information, move.defect)
    Ft = move.F.swapaxes(1, 2)
    A[1:] += information
    A[:-1] += Ft @ IF
    below[:-1] = -IF
    B[1:] -= IG
    B[:-1] += Ft @ IG
    C += _inner(move.G, IG)
    g[1:] += Id
    g[:-1] -= np.einsum("nij,nj->ni", Ft, Id)
    g_c -= _inner(move.G, Id[..., None])[:, 0]
    cost += float(np.einsum("ni,ni->", move.defect, Id))

    for each in seen:
        k = each.samples
        H, z = each.H / each.noise[:, None], each.z / each.noise
        own, driven = _columns(H, each.states, parts.driven)
        others, constant = _columns(H, each.states, parts.constant)
        others = others * move.growth[k][:, None, constant]
        t = own.swapaxes(1, 2)
        A[k[:, None, None], driven[:, None], driven] += t @ own
        B[k[:, None, None], driven[:, None], constant] += t @ others
        C[np.ix_(constant, constant)] += _inner(others, others)
        g[k[:, None], driven] += np.einsum("nij,ni->nj", own, z)
        g_c[constant] += _inner(others, z[..., None])[:, 0]
        cost += float(np.einsum("ni,ni->", z, z))

    factor = cholesky_banded(_banded(A, below), lower=True, check_finite=False)
    rows = np.column_stack([B.reshape(N * d, c), g.ravel()])
    solved = cho_solve_banded((factor, True), rows, check_finite=False)
    border = solved[:, :c]
    schur = cho_factor(C - rows[:, :c].T @ border)
    e_c = cho_solve(schur, g_c - rows[:, :c].T @ solved[:, c])
    e = (solved[:, c] - border @ e_c).reshape(N, d)
    covariance = cho_solve(schur, np.eye(c))
    return Solution(
        trajectory=at,
        parts=parts,
        steps=move,
        sightings=seen,
        cost=cost,
        factor=factor,
        border=border.reshape(N, d, c),
        covariance=0.5 * (covariance + covariance.T),
        e=e,
        e_c=e_c,
    )


def diagonal_blocks(solution: Solution) -> Floats:
    """D_k = L_k L_kᵀ of the factor's blocks on the diagonal, shape (N, d, d).

    Information of what came before, of sample k and of the step after it.
    """
    N, d = solution.e.shape
    L = np.zeros((N, d, d))
    for i in range(d):
        for j in range(i + 1):
            L[:, i, j] = solution.factor[i - j, j::d]
    blocks: Floats = L @ L.swapaxes(1, 2)
    return blocks


def smoothed_covariances(solution: Solution) -> Floats:
    """Of the driven states at every sample, shape (N, d, d), constants known; see `covariances`."""
    D = np.linalg.inv(diagonal_blocks(solution)).astype(np.float64, copy=False)
    # e_k = D⁻¹ (y_k + Fᵀ Q⁻¹ e_{k+1})
    gain = D[:-1] @ np.linalg.solve(solution.steps.Q, solution.steps.F).swapaxes(1, 2)
    P = D.copy()
    for k in range(len(gain) - 1, -1, -1):
        P[k] += gain[k] @ P[k + 1] @ gain[k].T
    return P


def covariances(solution: Solution, given: Floats) -> Floats:
    """Of the driven states at every sample, shape (N, d, d), with those of the constants in them.

    Parameters
    ----------
    given : array, shape (N, d, d)
        Covariances for known constants.
    """
    border = solution.border
    P: Floats = given + border @ solution.covariance @ border.swapaxes(1, 2)
    return P


def last_covariance(solution: Solution, given: Floats) -> Floats:
    """Of all states at the last sample, shape (n_states, n_states)."""
    parts, growth = solution.parts, solution.steps.growth[-1]
    n = len(parts.driven) + len(parts.constant)
    P = np.zeros((n, n))
    own = growth[:, None] * solution.covariance * growth
    cross = -solution.border[-1] @ (solution.covariance * growth)
    P[np.ix_(parts.driven, parts.driven)] = covariances(solution, given)[-1]
    P[np.ix_(parts.constant, parts.constant)] = own
    P[np.ix_(parts.driven, parts.constant)] = cross
    P[np.ix_(parts.constant, parts.driven)] = cross.T
    return P


def _columns(H: Floats, states: Ints, wanted: Ints) -> tuple[Floats, Ints]:
    """Derivatives by some of the wanted states, and which of these they are."""
    found = np.flatnonzero(np.isin(states, wanted))
    return np.ascontiguousarray(H[:, :, found]), np.searchsorted(wanted, states[found])


def _inner(a: Floats, b: Floats) -> Floats:
    """Sum over n of a_nᵀ b_n, of arrays of shapes (n, k, i) and (n, k, j)."""
    product: Floats = a.reshape(-1, a.shape[-1]).T @ b.reshape(-1, b.shape[-1])
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
