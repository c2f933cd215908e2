"""The fixed-interval smoother: the most probable trajectory and constants of a whole batch.

Gauss-Newton on all residuals at once (B. M. Bell, The iterated Kalman smoother as a Gauss-Newton
method, SIAM Journal on Optimization 4 (1994) 626-636): each step is that of the linear smoother
about the trajectory (`kernels/two_stage.py`, `kernels/bryson_frazier.py`).

Equations are formed, and the filter goes forward, in spans of samples. Of long telemetry what it
knew at the first sample of each is kept, and all else is formed again when it goes backward.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from scipy.linalg.lapack import dtrtri

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.kinematics import growth
from mgeo_calibration.estimation.linearization import Equations, equations
from mgeo_calibration.estimation.trajectory import (
    KEPT,
    Partition,
    Trajectory,
    moved,
    row_bytes,
    spans,
)

#: A step this small, in 1-sigmas of the constants and in rad, is the last: what it leaves is of the
#: order of its square.
LAST = 1e-2, 1e-5
_HALVINGS = 4  # of a step that makes it worse
#: x, T and P, see `Span.kept`, of one sample.
Known = tuple[Floats, Floats, Floats]


@dataclass(frozen=True, eq=False)
class Span(Equations):
    """What the filter makes of the equations of some samples.

    Attributes
    ----------
    first : int
        0, or 1 if the first of them is the last of the span before.
    used : array of bool, shape (s, n)
        Readings that are not left out.
    kept : tuple of arrays
        x, T and P, shapes (n, d), (n, d, q) and (n, d, d): driven errors, by the readings until a
        sample, are e = x + T c, with covariance P of e - T c.
    readings : tuple of arrays
        What `kernels/two_stage.py` keeps of each.
    """

    first: int
    used: Bools
    kept: Known
    readings: tuple[Floats, Floats, Floats, Floats]

    @property
    def new(self) -> slice:
        """The samples of the batch that are not of the span before."""
        return slice(self.low + self.first, self.high)

    @property
    def last(self) -> Known:
        """What is known at its last sample."""
        x, T, P = (each[-1].copy() for each in self.kept)
        return x, T, P


@dataclass(frozen=True, eq=False)
class Linear:
    """A batch with its equations, linear about a trajectory.

    Attributes
    ----------
    used : array of bool, shape (s, N)
        Readings that are not left out.
    growth : array, shape (N, c)
        See `Steps`.
    """

    batch: Batch
    trajectory: Trajectory
    parts: Partition
    used: Bools
    growth: Floats

    def filtered(
        self, known: Known, span: tuple[int, int, int], cost: float = 0.0
    ) -> tuple[Span, float]:
        """One of `spans`, from what is known at its first sample, and the cost until its end."""
        low, high, first = span
        own = equations(self.batch, self.trajectory, self.parts, self.growth, low, high)
        move, seen = own.steps, own.sightings
        (d, q), (s, n, _, p) = known[1].shape, seen.H.shape
        kept = np.empty((n, d)), np.empty((n, d, q)), np.empty((n, d, d))
        for each, one in zip(kept, known, strict=True):
            each[0] = one
        Hw, K, w, W = (np.empty((s, n, 3, *more)) for more in ((p,), (d,), (), (q,)))
        readings, used = (Hw, K, w, W), np.ascontiguousarray(self.used[:, low:high])
        forward = load("two_stage").forward
        cost = forward(move.arrays, used, seen.arrays, move.growth, kept, readings, first, cost)
        found = Span(**vars(own), first=first, used=used, kept=kept, readings=readings)
        return found, cost


@dataclass(frozen=True, eq=False)
class Solution(Linear):
    """The linear smoother about a trajectory.

    Errors c, to be taken out, are the driven ones at the first sample, then those of the constants;
    q = d + c of them.

    Attributes
    ----------
    cost : float
        Sum of squares of all residuals over their 1-sigmas.
    prior : tuple of arrays
        Residual of what is believed of c and minus its derivative, shapes (q,) and (q, q).
    starts : tuple of Known
        At the first sample of each span, and at the last one of all.
    held : tuple of Span
        All, or none if they would take more than `KEPT`.
    root : array, shape (q, q)
        S, an upper triangle, with S Sᵀ the covariance of c.
    common : array, shape (q,)
        c.
    e : array, shape (N, d)
        Smoothed driven errors, to be taken out.
    """

    cost: float
    prior: tuple[Floats, Floats]
    starts: tuple[Known, ...]
    held: tuple[Span, ...]
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
        """Of e_c, shape (c, c)."""
        d = len(self.parts.driven)
        return self.covariance[d:, d:]

    @cached_property
    def estimate(self) -> Trajectory:
        """The trajectory with the errors taken out."""
        return moved(self.trajectory, self.parts, self.growth, self.e, self.e_c, self.batch.suite)

    def settled(self, last: tuple[float, float] = LAST) -> bool:
        """Whether the step is small enough to be the last."""
        step = np.abs(self.e_c / np.sqrt(np.diag(self.constants_covariance))).max(initial=0.0)
        turn = np.abs(self.e[:, :3]).max()
        return bool(step < last[0] and turn < last[1])

    def spans(self, backward: bool = False) -> Iterator[Span]:
        """All, one after the other, formed again unless they are held."""
        if self.held:
            yield from reversed(self.held) if backward else self.held
            return
        each = [*zip(spans(len(self.e)), self.starts, strict=False)]
        for span, known in reversed(each) if backward else each:
            yield self.filtered(known, span)[0]


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
        cost, at, grown = found.cost, found.trajectory, found.growth
        share, e, e_c = 1.0, found.e, found.e_c
        for _ in range(_HALVINGS):
            del found
            reached = moved(at, parts, grown, e, e_c, batch.suite, share)
            found = linear_solution(batch, belief, reached, parts, rejected)
            # the equations of a held attitude are not solved where the cost is least
            if batch.held is not None or found.cost <= cost * (1.0 + 1e-9):
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
    used = batch.there if rejected is None else batch.there & ~rejected
    linear = Linear(batch, at, parts, used, growth(batch, parts))
    N, d = len(batch.times), len(parts.driven)
    r, J = belief.residual(at.attitude[0], at.states[0])
    J = J[:, np.concatenate([parts.driven, parts.constant])]
    q = len(r)
    R = np.linalg.qr(np.column_stack([J, r]))[1]
    known: Known = (np.zeros(d), np.eye(d, q), np.zeros((d, d)))
    starts, held, cost = [known], list[Span](), 0.0
    hold = N * row_bytes(batch.suite, parts) <= KEPT
    for span in spans(N):
        found, cost = linear.filtered(starts[-1], span, cost)
        load("two_stage").learn(found.used, found.readings, found.first, R)
        starts.append(found.last)
        held += [found] if hold else []
    root = np.ascontiguousarray(dtrtri(R[:, :q])[0])  # in one thread, unlike `solve_triangular`
    solution = Solution(
        **vars(linear),
        cost=cost + float(r @ r),
        prior=(r, J),
        starts=tuple(starts),
        held=tuple(held),
        root=root,
        common=root @ R[:, q],
        e=np.empty((N, d)),
    )
    adjoint = np.zeros(d)
    for each in solution.spans(backward=True):
        e, seen = np.empty((each.high - each.low, d)), each.sightings
        load("bryson_frazier").backward(
            each.steps.F,
            each.used,
            seen.counts,
            seen.columns,
            each.readings,
            each.kept,
            solution.common,
            each.first,
            adjoint,
            e,
        )
        solution.e[each.new] = e[each.first :]
    return solution


def smoothed(solution: Solution, n: int | None = None) -> Iterator[tuple[Span, Spread]]:
    """All spans, the last one first, with the spread at their samples; the first may be without.

    Parameters
    ----------
    n : int, optional
        How many leading errors. Default: those of the attitude, and of all that readings depend on.
    """
    d, q = solution.starts[0][1].shape
    later, adjoint = np.zeros((d, d)), np.zeros((d, q))
    for each in solution.spans(backward=True):
        size, leading = each.high - each.low, each.sightings.leading if n is None else n
        found = Spread(np.empty((size, leading, leading)), np.empty((size, leading, q)))
        load("bryson_frazier").smoothed(
            each.steps.arrays,
            each.used,
            each.sightings.arrays,
            each.readings,
            each.kept,
            each.first,
            later,
            adjoint,
            found.given,
            found.slope,
        )
        yield each, found


def last_covariance(solution: Solution) -> Floats:
    """Of all states at the last sample, shape (n_states, n_states)."""
    parts, grown = solution.parts, solution.growth[-1]
    d, n = len(parts.driven), len(parts.driven) + len(parts.constant)
    _, T, P_given = solution.starts[-1]
    cross = T @ solution.covariance[:, d:] * grown
    P = np.zeros((n, n))
    P[np.ix_(parts.driven, parts.driven)] = P_given + T @ solution.covariance @ T.T
    P[np.ix_(parts.constant, parts.constant)] = (
        grown[:, None] * solution.constants_covariance * grown
    )
    P[np.ix_(parts.driven, parts.constant)] = cross
    P[np.ix_(parts.constant, parts.driven)] = cross.T
    return P
