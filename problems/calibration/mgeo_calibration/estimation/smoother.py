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
from mgeo_calibration.estimation.kernels import load_compiled_module
from mgeo_calibration.estimation.kinematics import compute_constant_factors
from mgeo_calibration.estimation.linearization import Equations, linearize_equations
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.trajectory import (
    MAX_SPAN_MEMORY,
    Partition,
    Trajectory,
    compute_sample_memory,
    correct_trajectory,
    split_into_spans,
)

#: Convergence tolerances of a step: change of the constant states in 1-sigmas, and of the attitude
#: in rad. The remaining error is of the order of the square of the step.
TOLERANCES = 1e-2, 1e-5
_MAX_HALVINGS = 4  # largest number of halvings of a step that increases the cost
#: Filter estimate x, T and P of one sample; see `Span.kept`.
FilterState = tuple[Floats, Floats, Floats]


@dataclass(frozen=True, eq=False)
class Span(Equations):
    """Filter estimates and linearized equations of consecutive samples.

    Attributes
    ----------
    first_new : int
        1 if the first sample is the last sample of the previous span, otherwise 0.
    is_used : array of bool, shape (s, n)
        Readings that are not rejected.
    estimates : tuple of arrays
        x, T and P, shapes (n, d), (n, d, q) and (n, d, d). The errors of the stochastic states
        after the readings up to a sample are e = x + T c, where P is the covariance of e - T c.
    readings : tuple of arrays
        Hw, K, w and W of each reading; see `kernels/two_stage.py`.
    """

    first_new: int
    is_used: Bools
    estimates: FilterState
    readings: tuple[Floats, Floats, Floats, Floats]

    @property
    def new_samples(self) -> slice:
        """Samples of the batch that do not belong to the previous span."""
        return slice(self.low + self.first_new, self.high)

    @property
    def last_estimate(self) -> FilterState:
        """Filter estimate at the last sample."""
        x, T, P = (each[-1].copy() for each in self.estimates)
        return x, T, P


@dataclass(frozen=True, eq=False)
class LinearizedBatch:
    """Batch with the trajectory of its linearization.

    Attributes
    ----------
    batch : Batch
    trajectory : Trajectory
    partition : Partition
    is_used : array of bool, shape (s, N)
        Readings that are not rejected.
    constant_factors : array, shape (N, c)
        Factors of the constant states; see `kinematics.Steps`.
    """

    batch: Batch
    trajectory: Trajectory
    partition: Partition
    is_used: Bools
    constant_factors: Floats

    def filter_span(
        self, start: FilterState, span: tuple[int, int, int], cost: float = 0.0
    ) -> tuple[Span, float]:
        """Run the filter over one span.

        Parameters
        ----------
        start : tuple of arrays
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
        own = linearize_equations(
            self.batch, self.trajectory, self.partition, self.constant_factors, low, high
        )
        move, seen = own.process, own.measurements
        (d, q), (s, n, _, p) = start[1].shape, seen.H.shape
        kept = np.empty((n, d)), np.empty((n, d, q)), np.empty((n, d, d))
        for each, one in zip(kept, start, strict=True):
            each[0] = one
        Hw, K, w, W = (np.empty((s, n, 3, *more)) for more in ((p,), (d,), (), (q,)))
        readings, used = (Hw, K, w, W), np.ascontiguousarray(self.is_used[:, low:high])
        forward = load_compiled_module("two_stage").run_filter
        cost = forward(
            move.arrays, used, seen.arrays, move.constant_factors, kept, readings, first, cost
        )
        result = Span(**vars(own), first_new=first, is_used=used, estimates=kept, readings=readings)
        return result, cost


@dataclass(frozen=True, eq=False)
class Solution(LinearizedBatch):
    """Linear smoother solution about a trajectory.

    The vector c of length q contains the errors of the d stochastic states at the first sample,
    followed by the errors of the constant states. Errors are corrections to the trajectory.

    Attributes
    ----------
    cost : float
        Sum of squares of all normalized residuals.
    prior_equations : tuple of arrays
        Whitened residual of the prior of c and its negative derivative, shapes (q,) and (q, q).
    span_starts : tuple of Known
        Filter estimates at the first sample of each span and at the last sample of the batch.
    spans_in_memory : tuple of Span
        All spans, or none if the spans would take more memory than `KEPT`.
    covariance_root : array, shape (q, q)
        Upper triangular S, where S Sᵀ is the covariance of c.
    common_errors : array, shape (q,)
        Estimate of c.
    stochastic_errors : array, shape (N, d)
        Smoothed errors of the stochastic states.
    """

    cost: float
    prior_equations: tuple[Floats, Floats]
    span_starts: tuple[FilterState, ...]
    spans_in_memory: tuple[Span, ...]
    covariance_root: Floats
    common_errors: Floats
    stochastic_errors: Floats

    @cached_property
    def covariance(self) -> Floats:
        """Covariance of c, shape (q, q)."""
        # `@` would start BLAS threads, which then wait for further work in a busy loop.
        covariance: Floats = np.einsum("ij,kj->ik", self.covariance_root, self.covariance_root)
        return covariance

    @property
    def constant_errors(self) -> Floats:
        """Estimated errors of the constant states, shape (c,)."""
        return self.common_errors[len(self.partition.stochastic) :]

    @property
    def constants_covariance(self) -> Floats:
        """Covariance of the constant states, shape (c, c)."""
        d = len(self.partition.stochastic)
        return self.covariance[d:, d:]

    @cached_property
    def estimate(self) -> Trajectory:
        """Trajectory after the correction by the estimated errors."""
        return correct_trajectory(
            self.trajectory,
            self.partition,
            self.constant_factors,
            self.stochastic_errors,
            self.constant_errors,
            self.batch.suite,
        )

    def is_converged(self, tolerances: tuple[float, float] = TOLERANCES) -> bool:
        """Return whether the step is within the convergence tolerances; see `TOLERANCES`."""
        step = np.abs(self.constant_errors / np.sqrt(np.diag(self.constants_covariance))).max(
            initial=0.0
        )
        turn = np.abs(self.stochastic_errors[:, :3]).max()
        return bool(step < tolerances[0] and turn < tolerances[1])

    def iterate_spans(self, backward: bool = False) -> Iterator[Span]:
        """Yield all spans in order, recomputed unless they are in memory."""
        if self.spans_in_memory:
            yield from reversed(self.spans_in_memory) if backward else self.spans_in_memory
            return
        each = [*zip(split_into_spans(len(self.stochastic_errors)), self.span_starts, strict=False)]
        for span, known in reversed(each) if backward else each:
            yield self.filter_span(known, span)[0]


@dataclass(frozen=True, eq=False)
class SmoothedCovariance:
    """Covariances of the first n smoothed stochastic states for a known c, and their derivatives.

    Attributes
    ----------
    conditional_covariance : array, shape (N, n, n)
        Covariance of the errors e for a known c.
    derivative : array, shape (N, n, q)
        Derivative of e with respect to c.
    """

    conditional_covariance: Floats
    derivative: Floats


def solve(
    batch: Batch,
    prior: PriorEstimate,
    start: Trajectory,
    max_iterations: int,
    tolerances: tuple[float, float] = TOLERANCES,
    is_rejected: Bools | None = None,
) -> Solution:
    """Iterate from a trajectory until convergence or a number of iterations.

    Parameters
    ----------
    prior : PriorEstimate
        Prior at the first sample.
    start : Trajectory
        Initial trajectory.
    max_iterations : int
        Largest number of iterations.
    tolerances : (float, float)
        Convergence tolerances; see `TOLERANCES`.
    is_rejected : array of bool, shape (s, N), optional
        Readings to exclude.

    Returns
    -------
    Solution
        Solution of the last iteration; `Solution.settled` tells whether it has converged.
    """
    parts = Partition.from_suite(batch.suite)
    result = solve_linearized(batch, prior, start, parts, is_rejected)
    for _ in range(max_iterations):
        if result.is_converged(tolerances):
            break
        # Delete the old solution before the next one is computed, to halve the peak memory.
        cost, at, grown = result.cost, result.trajectory, result.constant_factors
        share, e, e_c = 1.0, result.stochastic_errors, result.constant_errors
        for _ in range(_MAX_HALVINGS):
            del result
            reached = correct_trajectory(at, parts, grown, e, e_c, batch.suite, share)
            result = solve_linearized(batch, prior, reached, parts, is_rejected)
            # For a held attitude the equations are not solved where the cost is least.
            if batch.pointing is not None or result.cost <= cost * (1.0 + 1e-9):
                break
            share *= 0.5
    return result


def solve_linearized(
    batch: Batch,
    prior: PriorEstimate,
    trajectory: Trajectory,
    partition: Partition,
    is_rejected: Bools | None = None,
) -> Solution:
    """Compute one Gauss-Newton step about a trajectory.

    Parameters
    ----------
    prior : PriorEstimate
        Prior at the first sample.
    trajectory : Trajectory
        Trajectory to linearize about.
    partition : Partition
    is_rejected : array of bool, shape (s, N), optional
        Readings to exclude.

    Returns
    -------
    Solution
    """
    used = batch.has_reading if is_rejected is None else batch.has_reading & ~is_rejected
    linear = LinearizedBatch(
        batch, trajectory, partition, used, compute_constant_factors(batch, partition)
    )
    N, d = len(batch.times), len(partition.stochastic)
    r, J = prior.compute_residual(trajectory.attitude[0], trajectory.states[0])
    J = J[:, np.concatenate([partition.stochastic, partition.constant])]
    q = len(r)
    R = np.linalg.qr(np.column_stack([J, r]))[1]
    known: FilterState = (np.zeros(d), np.eye(d, q), np.zeros((d, d)))
    starts, held, cost = [known], list[Span](), 0.0
    hold = N * compute_sample_memory(batch.suite, partition) <= MAX_SPAN_MEMORY
    for span in split_into_spans(N):
        result, cost = linear.filter_span(starts[-1], span, cost)
        load_compiled_module("two_stage").reduce_readings(
            result.is_used, result.readings, result.first_new, R
        )
        starts.append(result.last_estimate)
        held += [result] if hold else []
    # `solve_triangular` would start BLAS threads.
    root = np.ascontiguousarray(dtrtri(R[:, :q])[0])
    solution = Solution(
        **vars(linear),
        cost=cost + float(r @ r),
        prior_equations=(r, J),
        span_starts=tuple(starts),
        spans_in_memory=tuple(held),
        covariance_root=root,
        common_errors=root @ R[:, q],
        stochastic_errors=np.empty((N, d)),
    )
    adjoint = np.zeros(d)
    for each in solution.iterate_spans(backward=True):
        e, seen = np.empty((each.high - each.low, d)), each.measurements
        load_compiled_module("bryson_frazier").smooth_errors(
            each.process.F,
            each.is_used,
            seen.n_columns,
            seen.columns,
            each.readings,
            each.estimates,
            solution.common_errors,
            each.first_new,
            adjoint,
            e,
        )
        solution.stochastic_errors[each.new_samples] = e[each.first_new :]
    return solution


def smooth_covariances(
    solution: Solution, n_leading: int | None = None
) -> Iterator[tuple[Span, SmoothedCovariance]]:
    """Yield all spans backward in time with the smoothed covariances of their samples.

    The covariances at the first sample of a span are undefined if `Span.first` is 1.

    Parameters
    ----------
    n_leading : int, optional
        Number of leading stochastic states. Default: all that the readings depend on, at least
        three.
    """
    d, q = solution.span_starts[0][1].shape
    later, adjoint = np.zeros((d, d)), np.zeros((d, q))
    for each in solution.iterate_spans(backward=True):
        size, leading = (
            each.high - each.low,
            each.measurements.n_leading if n_leading is None else n_leading,
        )
        result = SmoothedCovariance(
            np.empty((size, leading, leading)), np.empty((size, leading, q))
        )
        load_compiled_module("bryson_frazier").smooth_covariances(
            each.process.arrays,
            each.is_used,
            each.measurements.arrays,
            each.readings,
            each.estimates,
            each.first_new,
            later,
            adjoint,
            result.conditional_covariance,
            result.derivative,
        )
        yield each, result


def compute_last_covariance(solution: Solution) -> Floats:
    """Return the covariance of all states at the last sample, shape (n_states, n_states)."""
    parts, grown = solution.partition, solution.constant_factors[-1]
    d, n = len(parts.stochastic), len(parts.stochastic) + len(parts.constant)
    _, T, P_given = solution.span_starts[-1]
    cross = T @ solution.covariance[:, d:] * grown
    P = np.zeros((n, n))
    P[np.ix_(parts.stochastic, parts.stochastic)] = P_given + T @ solution.covariance @ T.T
    P[np.ix_(parts.constant, parts.constant)] = (
        grown[:, None] * solution.constants_covariance * grown
    )
    P[np.ix_(parts.stochastic, parts.constant)] = cross
    P[np.ix_(parts.constant, parts.stochastic)] = cross.T
    return P
