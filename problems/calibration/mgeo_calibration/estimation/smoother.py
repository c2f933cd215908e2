"""The fixed-interval smoother: the most probable trajectory and constants of a whole batch.

Gauss-Newton on all residuals at once (B. M. Bell, The iterated Kalman smoother as a Gauss-Newton
method, SIAM Journal on Optimization 4 (1994) 626-636): each step is that of the linear smoother
about the trajectory (`kernels/two_stage.py`, `kernels/bryson_frazier.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from scipy.linalg.lapack import dtrtri

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.linearization import (
    Partition,
    Sightings,
    Steps,
    Trajectory,
    moved,
    sightings,
    steps,
)

#: A step this small, in 1-sigmas of the constants and in rad, is the last: what it leaves is of the
#: order of its square.
LAST = 1e-2, 1e-5
_HALVINGS = 4  # of a step that makes it worse


@dataclass(frozen=True, eq=False)
class Solution:
    """The linear smoother about a trajectory.

    Errors c, to be taken out, are the driven ones at the first sample, then those of the constants;
    q = d + c of them. Driven errors of a sample, by the readings until it, are e = x + T c.

    Attributes
    ----------
    batch : Batch
    trajectory : Trajectory
        About which all is linear.
    parts : Partition
    steps : Steps
    sightings : Sightings
        Of all readings.
    used : array of bool, shape (s, N)
        Readings that are not left out.
    cost : float
        Sum of squares of all residuals over their 1-sigmas.
    prior : tuple of arrays
        Residual of what is believed of c and minus its derivative, shapes (q,) and (q, q).
    kept : tuple of arrays
        x, T and the covariance of e - T c, shapes (N, d), (N, d, q) and (N, d, d).
    readings : tuple of arrays
        What `kernels/two_stage.py` keeps of each.
    root : array, shape (q, q)
        S, an upper triangle, with S Sᵀ the covariance of c.
    common : array, shape (q,)
        c.
    e : array, shape (N, d)
        Smoothed driven errors, to be taken out.
    """

    batch: Batch
    trajectory: Trajectory
    parts: Partition
    steps: Steps
    sightings: Sightings
    used: Bools
    cost: float
    prior: tuple[Floats, Floats]
    kept: tuple[Floats, Floats, Floats]
    readings: tuple[Floats, Floats, Floats, Floats]
    root: Floats
    common: Floats
    e: Floats

    @cached_property
    def covariance(self) -> Floats:
        """Of c, shape (q, q)."""
        # not by `@`: BLAS would start its threads, which then wait for more in a busy loop
        covariance: Floats = np.einsum("ij,kj->ik", self.root, self.root)
        return covariance

    @property
    def e_c(self) -> Floats:
        """Errors of the constants, to be taken out, shape (c,)."""
        return self.common[len(self.parts.driven) :]

    @property
    def constants_covariance(self) -> Floats:
        """Of the constants, shape (c, c)."""
        d = len(self.parts.driven)
        return self.covariance[d:, d:]

    @cached_property
    def estimate(self) -> Trajectory:
        """The trajectory with the errors taken out."""
        return self.moved(1.0)

    def moved(self, share: float) -> Trajectory:
        """The trajectory with this share of the errors taken out."""
        e, e_c, growth = share * self.e, share * self.e_c, self.steps.growth
        return moved(self.trajectory, self.parts, growth, e, e_c, self.batch.suite)

    def settled(self, last: tuple[float, float] = LAST) -> bool:
        """Whether the step is small enough to be the last."""
        step = np.abs(self.e_c / np.sqrt(np.diag(self.constants_covariance))).max(initial=0.0)
        turn = np.abs(self.e[:, :3]).max()
        return bool(step < last[0] and turn < last[1])


@dataclass(frozen=True, eq=False)
class Spread:
    """Covariances of the n leading smoothed driven errors, given c, and their change with c.

    Attributes
    ----------
    given : array, shape (N, n, n)
    slope : array, shape (N, n, q)
    """

    given: Floats
    slope: Floats


def solve(
    batch: Batch,
    belief: Belief,
    start: Trajectory,
    iterations: int,
    last: tuple[float, float] = LAST,
    rejected: Bools | None = None,
) -> Solution:
    """Iterate from a trajectory until the step is `settled`, at most so many times.

    Parameters
    ----------
    rejected : array of bool, shape (s, N), optional
        Readings to leave out.
    """
    parts = Partition.of(batch.suite)
    found = linear_solution(batch, belief, start, parts, rejected)
    for _ in range(iterations):
        if found.settled(last):
            break
        # all else of the solution would be as large as that of the next
        cost, at, growth = found.cost, found.trajectory, found.steps.growth
        share, e, e_c = 1.0, found.e, found.e_c
        for _ in range(_HALVINGS):
            del found
            reached = moved(at, parts, growth, share * e, share * e_c, batch.suite)
            found = linear_solution(batch, belief, reached, parts, rejected)
            if found.cost <= cost * (1.0 + 1e-9):
                break
            share *= 0.5
    return found


def linear_solution(
    batch: Batch,
    belief: Belief,
    at: Trajectory,
    parts: Partition,
    rejected: Bools | None = None,
) -> Solution:
    """The step from a trajectory, and the covariance of c."""
    move, seen = steps(batch, at, parts), sightings(batch, at, parts)
    used = seen.there if rejected is None else seen.there & ~rejected
    N, d = len(batch.times), len(parts.driven)
    r, J = belief.residual(at.attitude[0], at.states[0])
    J = J[:, np.concatenate([parts.driven, parts.constant])]
    q, (s, _, _, p) = len(r), seen.H.shape
    R = np.linalg.qr(np.column_stack([J, r]))[1]
    kept = np.empty((N, d)), np.empty((N, d, q)), np.empty((N, d, d))
    Hw, K, w, W = (np.empty((s, N, 3, *more)) for more in ((p,), (d,), (), (q,)))
    readings = Hw, K, w, W
    forward = load("two_stage").forward
    cost = forward(move.arrays, used, seen.arrays, move.growth, kept, readings, R, 0)
    root = np.ascontiguousarray(dtrtri(R[:, :q])[0])  # in one thread, unlike `solve_triangular`
    common = root @ R[:, q]
    e = np.empty((N, d))
    load("bryson_frazier").backward(
        move.F, used, seen.counts, seen.columns, readings, kept, common, e
    )
    return Solution(
        batch=batch,
        trajectory=at,
        parts=parts,
        steps=move,
        sightings=seen,
        used=used,
        cost=cost + float(r @ r),
        prior=(r, J),
        kept=kept,
        readings=readings,
        root=root,
        common=common,
        e=e,
    )


def spread(solution: Solution, n: int | None = None) -> Spread:
    """Of every sample.

    Parameters
    ----------
    n : int, optional
        How many leading errors. Default: those of the attitude, and of all that readings depend on.
    """
    N, _, q = solution.kept[1].shape
    if n is None:
        n = solution.sightings.leading
    found = Spread(np.empty((N, n, n)), np.empty((N, n, q)))
    load("bryson_frazier").smoothed(
        solution.steps.arrays,
        solution.used,
        solution.sightings.arrays,
        solution.readings,
        solution.kept,
        found.given,
        found.slope,
    )
    return found


def covariances(solution: Solution, found: Spread) -> Floats:
    """Of the n leading driven states at every sample, shape (N, n, n)."""
    J = found.slope
    P: Floats = found.given + J @ solution.covariance @ J.swapaxes(1, 2)
    return P


def last_covariance(solution: Solution) -> Floats:
    """Of all states at the last sample, shape (n_states, n_states)."""
    parts, growth = solution.parts, solution.steps.growth[-1]
    d, n = len(parts.driven), len(parts.driven) + len(parts.constant)
    _, T, P_given = (each[-1] for each in solution.kept)
    cross = T @ solution.covariance[:, d:] * growth
    P = np.zeros((n, n))
    P[np.ix_(parts.driven, parts.driven)] = P_given + T @ solution.covariance @ T.T
    P[np.ix_(parts.constant, parts.constant)] = (
        growth[:, None] * solution.constants_covariance * growth
    )
    P[np.ix_(parts.driven, parts.constant)] = cross
    P[np.ix_(parts.constant, parts.driven)] = cross.T
    return P
