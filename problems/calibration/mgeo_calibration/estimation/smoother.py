"""Fixed-interval smoother: the most probable trajectory and constant states of a batch.

Each Gauss-Newton step over all residuals is a linear smoother about the trajectory (B. M. Bell, The
iterated Kalman smoother as a Gauss-Newton method, SIAM Journal on Optimization 4 (1994) 626-636).
The compiled loops are in `kernels/two_stage.py` and `kernels/bryson_frazier.py`.

The forward filter forms the equations in spans of consecutive samples. For long telemetry, only the
filter estimate at the start of each span is stored; the backward pass forms the equations again.
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

#: Convergence tolerances of a step: change of the constant states in 1-sigmas, and of the attitude
#: in rad. The remaining error is of the order of the square of the step.
LAST = 1e-2, 1e-5
_HALVINGS = 4  # largest number of halvings of a step that increases the cost
#: Filter estimate x, T and P of one sample; see `Span.kept`.
Known = tuple[Floats, Floats, Floats]


@dataclass(frozen=True, eq=False)
class Span(Equations):
    """Filter estimates and linearized equations of consecutive samples.

    Attributes
    ----------
    first : int
        1 if the first sample is the last sample of the previous span, otherwise 0.
    used : array of bool, shape (s, n)
        Readings that are not rejected.
    kept : tuple of arrays
        x, T and P, shapes (n, d), (n, d, q) and (n, d, d). The errors of the stochastic states
        after the readings up to a sample are e = x + T c, where P is the covariance of e - T c.
    readings : tuple of arrays
        Hw, K, w and W of each reading; see `kernels/two_stage.py`.
    """

    first: int
    used: Bools
    kept: Known
    readings: tuple[Floats, Floats, Floats, Floats]

    @property
    def new(self) -> slice:
        """Samples of the batch that do not belong to the previous span."""
        return slice(self.low + self.first, self.high)

    @property
    def last(self) -> Known:
        """Filter estimate at the last sample."""
        x, T, P = (each[-1].copy() for each in self.kept)
        return x, T, P


@dataclass(frozen=True, eq=False)
class Linear:
    """Batch with the trajectory of its linearization.

    Attributes
    ----------
    batch : Batch
    trajectory : Trajectory
    parts : Partition
    used : array of bool, shape (s, N)
        Readings that are not rejected.
    growth : array, shape (N, c)
        Factors of the constant states; see `kinematics.Steps`.
    """

    batch: Batch
    trajectory: Trajectory
    parts: Partition
    used: Bools
    growth: Floats

    def filtered(
        self, known: Known, span: tuple[int, int, int], cost: float = 0.0
    ) -> tuple[Span, float]:
        """Run the filter over one span.

        Parameters
        ----------
        known : tuple of arrays
            Filter estimate at the first sample of the span.
        span : (int, int, int)
            One of `trajectory.spans`.
        cost : float
            Cost up to the first sample of the span.

        Returns
        -------
        span : Span
        cost : float
            Cost up to the last sample of the span.
        """
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
        result = Span(**vars(own), first=first, used=used, kept=kept, readings=readings)
        return result, cost


@dataclass(frozen=True, eq=False)
class Solution(Linear):
    """Linear smoother solution about a trajectory.

    The vector c of length q contains the errors of the d stochastic states at the first sample,
    followed by the errors of the constant states. Errors are corrections to the trajectory.

    Attributes
    ----------
    cost : float
        Sum of squares of all normalized residuals.
    prior : tuple of arrays
        Whitened residual of the prior of c and its negative derivative, shapes (q,) and (q, q).
    starts : tuple of Known
        Filter estimates at the first sample of each span and at the last sample of the batch.
    held : tuple of Span
        All spans, or none if the spans would take more memory than `KEPT`.
    root : array, shape (q, q)
        Upper triangular S, where S Sᵀ is the covariance of c.
    common : array, shape (q,)
        Estimate of c.
    e : array, shape (N, d)
        Smoothed errors of the stochastic states.
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
        """Covariance of c, shape (q, q)."""
        # `@` would start BLAS threads, which then wait for further work in a busy loop.
        covariance: Floats = np.einsum("ij,kj->ik", self.root, self.root)
        return covariance

    @property
    def e_c(self) -> Floats:
        """Estimated errors of the constant states, shape (c,)."""
        return self.common[len(self.parts.driven) :]

    @property
    def constants_covariance(self) -> Floats:
        """Covariance of the constant states, shape (c, c)."""
        d = len(self.parts.driven)
        return self.covariance[d:, d:]

    @cached_property
    def estimate(self) -> Trajectory:
        """Trajectory after the correction by the estimated errors."""
        return moved(self.trajectory, self.parts, self.growth, self.e, self.e_c, self.batch.suite)

    def settled(self, last: tuple[float, float] = LAST) -> bool:
        """Return whether the step is within the convergence tolerances; see `LAST`."""
        step = np.abs(self.e_c / np.sqrt(np.diag(self.constants_covariance))).max(initial=0.0)
        turn = np.abs(self.e[:, :3]).max()
        return bool(step < last[0] and turn < last[1])

    def spans(self, backward: bool = False) -> Iterator[Span]:
        """Yield all spans in order, recomputed unless they are in memory."""
        if self.held:
            yield from reversed(self.held) if backward else self.held
            return
        each = [*zip(spans(len(self.e)), self.starts, strict=False)]
        for span, known in reversed(each) if backward else each:
            yield self.filtered(known, span)[0]


@dataclass(frozen=True, eq=False)
class Spread:
    """Covariances of the first n smoothed stochastic states for a known c, and their derivatives.

    Attributes
    ----------
    given : array, shape (N, n, n)
        Covariance of the errors e for a known c.
    slope : array, shape (N, n, q)
        Derivative of e with respect to c.
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
    """Iterate from a trajectory until convergence or a number of iterations.

    Parameters
    ----------
    belief : Belief
        Prior at the first sample.
    start : Trajectory
        Initial trajectory.
    iterations : int
        Largest number of iterations.
    last : (float, float)
        Convergence tolerances; see `LAST`.
    rejected : array of bool, shape (s, N), optional
        Readings to exclude.

    Returns
    -------
    Solution
        Solution of the last iteration; `Solution.settled` tells whether it has converged.
    """
    parts = Partition.of(batch.suite)
    result = linear_solution(batch, belief, start, parts, rejected)
    for _ in range(iterations):
        if result.settled(last):
            break
        # Delete the old solution before the next one is computed, to halve the peak memory.
        cost, at, grown = result.cost, result.trajectory, result.growth
        share, e, e_c = 1.0, result.e, result.e_c
        for _ in range(_HALVINGS):
            del result
            reached = moved(at, parts, grown, e, e_c, batch.suite, share)
            result = linear_solution(batch, belief, reached, parts, rejected)
            # For a held attitude the equations are not solved where the cost is least.
            if batch.held is not None or result.cost <= cost * (1.0 + 1e-9):
                break
            share *= 0.5
    return result


def linear_solution(
    batch: Batch,
    belief: Belief,
    at: Trajectory,
    parts: Partition,
    rejected: Bools | None = None,
) -> Solution:
    """Compute one Gauss-Newton step about a trajectory.

    Parameters
    ----------
    belief : Belief
        Prior at the first sample.
    at : Trajectory
        Trajectory to linearize about.
    parts : Partition
    rejected : array of bool, shape (s, N), optional
        Readings to exclude.

    Returns
    -------
    Solution
    """
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
        result, cost = linear.filtered(starts[-1], span, cost)
        load("two_stage").learn(result.used, result.readings, result.first, R)
        starts.append(result.last)
        held += [result] if hold else []
    # `solve_triangular` would start BLAS threads.
    root = np.ascontiguousarray(dtrtri(R[:, :q])[0])
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
    """Yield all spans backward in time with the smoothed covariances of their samples.

    The covariances at the first sample of a span are undefined if `Span.first` is 1.

    Parameters
    ----------
    n : int, optional
        Number of leading stochastic states. Default: all that the readings depend on, at least
        three.
    """
    d, q = solution.starts[0][1].shape
    later, adjoint = np.zeros((d, d)), np.zeros((d, q))
    for each in solution.spans(backward=True):
        size, leading = each.high - each.low, each.sightings.leading if n is None else n
        result = Spread(np.empty((size, leading, leading)), np.empty((size, leading, q)))
        load("bryson_frazier").smoothed(
            each.steps.arrays,
            each.used,
            each.sightings.arrays,
            each.readings,
            each.kept,
            each.first,
            later,
            adjoint,
            result.given,
            result.slope,
        )
        yield each, result


def last_covariance(solution: Solution) -> Floats:
    """Return the covariance of all states at the last sample, shape (n_states, n_states)."""
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
