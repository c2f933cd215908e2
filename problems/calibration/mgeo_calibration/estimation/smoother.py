"""Fixed-interval smoother: the most probable trajectory and constant states of a batch.

Each Gauss-Newton step over all residuals is a linear smoother about the trajectory (B. M. Bell, The
iterated Kalman smoother as a Gauss-Newton method, SIAM Journal on Optimization 4 (1994) 626-636).
The compiled loops are in `kernels/two_stage.py` and `kernels/bryson_frazier.py`.

The forward filter computes the equations in spans of consecutive samples. For long telemetry, only
the filter estimate at the start of each span is stored; the backward pass computes the equations
again.
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
#: Filter estimate x, T and P of one sample; see `Span.estimates`.
FilterState = tuple[Floats, Floats, Floats]


@dataclass(frozen=True, eq=False)
class Span(Equations):
    """Linearized equations and forward filter estimates of consecutive samples of a batch.

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
        """Slice of the batch samples that belong to this span but not to the previous span."""
        return slice(self.low + self.first_new, self.high)

    @property
    def last_estimate(self) -> FilterState:
        """Copy of the filter estimate (x, T, P) at the last sample of the span."""
        x, T, P = (each[-1].copy() for each in self.estimates)
        return x, T, P


@dataclass(frozen=True, eq=False)
class LinearizedBatch:
    """Telemetry batch with the trajectory about which its equations are linearized.

    Attributes
    ----------
    batch : Batch
    trajectory : Trajectory
        Trajectory of the linearization.
    partition : Partition
        Stochastic and constant states.
    is_used : array of bool, shape (s, N)
        Readings that are not rejected.
    constant_factors : array, shape (N, c)
        Result of `kinematics.compute_constant_factors`.
    """

    batch: Batch
    trajectory: Trajectory
    partition: Partition
    is_used: Bools
    constant_factors: Floats

    def filter_span(
        self, start: FilterState, span: tuple[int, int, int], cost: float = 0.0
    ) -> tuple[Span, float]:
        """Run the forward filter over one span of samples, and return the result and its cost.

        Parameters
        ----------
        start : tuple of arrays
            Filter estimate at the first sample of the span.
        span : (int, int, int)
            Bounds of the span from `trajectory.split_into_spans`.
        cost : float
            Cost up to the first sample of the span.

        Returns
        -------
        span : Span
        cost : float
            Cost up to the last sample of the span.
        """
        low, high, first = span
        equations = linearize_equations(
            self.batch, self.trajectory, self.partition, self.constant_factors, low, high
        )
        process, measurements = equations.process, equations.measurements
        (d, q), (s, n, _, p) = start[1].shape, measurements.H.shape
        estimates = np.empty((n, d)), np.empty((n, d, q)), np.empty((n, d, d))
        for array, initial in zip(estimates, start, strict=True):
            array[0] = initial
        Hw, K, w, W = (np.empty((s, n, 3, *more)) for more in ((p,), (d,), (), (q,)))
        readings, is_used = (Hw, K, w, W), np.ascontiguousarray(self.is_used[:, low:high])
        run_filter = load_compiled_module("two_stage").run_filter
        cost = run_filter(
            process.arrays,
            is_used,
            measurements.arrays,
            process.constant_factors,
            estimates,
            readings,
            first,
            cost,
        )
        result = Span(
            **vars(equations),
            first_new=first,
            is_used=is_used,
            estimates=estimates,
            readings=readings,
        )
        return result, cost


@dataclass(frozen=True, eq=False)
class Solution(LinearizedBatch):
    """Result of one linear smoother pass: estimated errors of a trajectory and their covariance.

    The vector c of length q contains the errors of the d stochastic states at the first sample,
    followed by the errors of the constant states. Errors are corrections to the trajectory.

    Attributes
    ----------
    cost : float
        Sum of squares of all normalized residuals.
    prior_equations : tuple of arrays
        Whitened residual of the prior of c and its negative Jacobian, shapes (q,) and (q, q).
    span_starts : tuple of FilterState
        Filter estimates at the first sample of each span and at the last sample of the batch.
    spans_in_memory : tuple of Span
        All spans, or none if the spans would need more memory than `MAX_SPAN_MEMORY`.
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
        """Covariance of the state errors at the first sample, shape (q, q)."""
        # `@` would start BLAS threads, which then wait for further work in a busy loop.
        covariance: Floats = np.einsum("ij,kj->ik", self.covariance_root, self.covariance_root)
        return covariance

    @property
    def constant_errors(self) -> Floats:
        """Estimated errors of the constant states, shape (c,)."""
        return self.common_errors[len(self.partition.stochastic) :]

    @property
    def constants_covariance(self) -> Floats:
        """Covariance of the errors of the constant states, shape (c, c)."""
        d = len(self.partition.stochastic)
        return self.covariance[d:, d:]

    @cached_property
    def estimate(self) -> Trajectory:
        """Trajectory corrected by the estimated errors, computed on first use."""
        return correct_trajectory(
            self.trajectory,
            self.partition,
            self.constant_factors,
            self.stochastic_errors,
            self.constant_errors,
            self.batch.suite,
        )

    def is_converged(self, tolerances: tuple[float, float] = TOLERANCES) -> bool:
        """Return True if the estimated errors are smaller than the convergence tolerances.

        Parameters
        ----------
        tolerances : (float, float)
            Tolerance of the constant states in 1-sigmas, and of the attitude in rad.
        """
        largest_step = np.abs(
            self.constant_errors / np.sqrt(np.diag(self.constants_covariance))
        ).max(initial=0.0)
        largest_rotation = np.abs(self.stochastic_errors[:, :3]).max()
        return bool(largest_step < tolerances[0] and largest_rotation < tolerances[1])

    def iterate_spans(self, backward: bool = False) -> Iterator[Span]:
        """Yield the spans of the batch with their filter estimates, forward or backward in time.

        Spans that are not in memory are computed again.

        Parameters
        ----------
        backward : bool
            Start with the last span.
        """
        if self.spans_in_memory:
            yield from reversed(self.spans_in_memory) if backward else self.spans_in_memory
            return
        starts = [
            *zip(split_into_spans(len(self.stochastic_errors)), self.span_starts, strict=False)
        ]
        for span, start in reversed(starts) if backward else starts:
            yield self.filter_span(start, span)[0]


@dataclass(frozen=True, eq=False)
class SmoothedCovariance:
    """Smoothed covariance of the first n stochastic states, given the errors c that all samples
    share, and the derivative of the smoothed errors with respect to c.

    The vector c contains the errors at the first sample and the errors of the constant states.

    Attributes
    ----------
    conditional_covariance : array, shape (N, n, n)
        Covariance of the errors e for a given c.
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
    """Smooth a batch by Gauss-Newton iterations that start from an initial trajectory.

    A step that increases the cost is halved.

    Parameters
    ----------
    batch : Batch
    prior : PriorEstimate
        Prior estimate at the first sample.
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
        Solution of the last iteration. It may not have converged; see `Solution.is_converged`.
    """
    partition = Partition.from_suite(batch.suite)
    result = solve_linearized(batch, prior, start, partition, is_rejected)
    for _ in range(max_iterations):
        if result.is_converged(tolerances):
            break
        # The old solution is deleted before the next one is computed, to halve the peak memory.
        cost, trajectory, constant_factors = result.cost, result.trajectory, result.constant_factors
        fraction, e, e_c = 1.0, result.stochastic_errors, result.constant_errors
        for _ in range(_MAX_HALVINGS):
            del result
            corrected = correct_trajectory(
                trajectory, partition, constant_factors, e, e_c, batch.suite, fraction
            )
            result = solve_linearized(batch, prior, corrected, partition, is_rejected)
            # With a held attitude, the solution of the equations does not minimize the cost.
            if batch.pointing is not None or result.cost <= cost * (1.0 + 1e-9):
                break
            fraction *= 0.5
    return result


def solve_linearized(
    batch: Batch,
    prior: PriorEstimate,
    trajectory: Trajectory,
    partition: Partition,
    is_rejected: Bools | None = None,
) -> Solution:
    """Smooth a batch in one Gauss-Newton step about a trajectory.

    Parameters
    ----------
    batch : Batch
    prior : PriorEstimate
        Prior estimate at the first sample.
    trajectory : Trajectory
        Trajectory to linearize about.
    partition : Partition
        Stochastic and constant states.
    is_rejected : array of bool, shape (s, N), optional
        Readings to exclude.

    Returns
    -------
    Solution
    """
    is_used = batch.has_reading if is_rejected is None else batch.has_reading & ~is_rejected
    linear = LinearizedBatch(
        batch, trajectory, partition, is_used, compute_constant_factors(batch, partition)
    )
    N, d = len(batch.times), len(partition.stochastic)
    r, J = prior.compute_residual(trajectory.attitude[0], trajectory.states[0])
    J = J[:, np.concatenate([partition.stochastic, partition.constant])]
    q = len(r)
    R = np.linalg.qr(np.column_stack([J, r]))[1]
    initial_state: FilterState = (np.zeros(d), np.eye(d, q), np.zeros((d, d)))
    starts, stored_spans, cost = [initial_state], list[Span](), 0.0
    store_spans = N * compute_sample_memory(batch.suite, partition) <= MAX_SPAN_MEMORY
    for span in split_into_spans(N):
        result, cost = linear.filter_span(starts[-1], span, cost)
        load_compiled_module("two_stage").reduce_readings(
            result.is_used, result.readings, result.first_new, R
        )
        starts.append(result.last_estimate)
        stored_spans += [result] if store_spans else []
    # `solve_triangular` would start BLAS threads.
    root = np.ascontiguousarray(dtrtri(R[:, :q])[0])
    solution = Solution(
        **vars(linear),
        cost=cost + float(r @ r),
        prior_equations=(r, J),
        span_starts=tuple(starts),
        spans_in_memory=tuple(stored_spans),
        covariance_root=root,
        common_errors=root @ R[:, q],
        stochastic_errors=np.empty((N, d)),
    )
    adjoint = np.zeros(d)
    for each in solution.iterate_spans(backward=True):
        e, measurements = np.empty((each.high - each.low, d)), each.measurements
        load_compiled_module("bryson_frazier").smooth_errors(
            each.process.F,
            each.is_used,
            measurements.n_columns,
            measurements.columns,
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
    """Yield the smoothed covariances of a solution for one span of consecutive samples at a time,
    last span first.

    The covariances at the first sample of a span are undefined if `Span.first_new` is 1.

    Parameters
    ----------
    solution : Solution
    n_leading : int, optional
        Number of leading stochastic states. Default: all that the readings depend on, at least
        three.

    Yields
    ------
    span : Span
    smoothed : SmoothedCovariance
        Covariances at the samples of the span.
    """
    d, q = solution.span_starts[0][1].shape
    later_information, adjoint = np.zeros((d, d)), np.zeros((d, q))
    for span in solution.iterate_spans(backward=True):
        size, leading = (
            span.high - span.low,
            span.measurements.n_leading if n_leading is None else n_leading,
        )
        smoothed = SmoothedCovariance(
            np.empty((size, leading, leading)), np.empty((size, leading, q))
        )
        load_compiled_module("bryson_frazier").smooth_covariances(
            span.process.arrays,
            span.is_used,
            span.measurements.arrays,
            span.readings,
            span.estimates,
            span.first_new,
            later_information,
            adjoint,
            smoothed.conditional_covariance,
            smoothed.derivative,
        )
        yield span, smoothed


def compute_last_covariance(solution: Solution) -> Floats:
    """Return the covariance of all states at the last sample, as an array of
    shape (n_states, n_states).
    """
    partition, constant_factors = solution.partition, solution.constant_factors[-1]
    d, n = len(partition.stochastic), len(partition.stochastic) + len(partition.constant)
    _, T, P_conditional = solution.span_starts[-1]
    cross = T @ solution.covariance[:, d:] * constant_factors
    P = np.zeros((n, n))
    P[np.ix_(partition.stochastic, partition.stochastic)] = (
        P_conditional + T @ solution.covariance @ T.T
    )
    P[np.ix_(partition.constant, partition.constant)] = (
        constant_factors[:, None] * solution.constants_covariance * constant_factors
    )
    P[np.ix_(partition.stochastic, partition.constant)] = cross
    P[np.ix_(partition.constant, partition.stochastic)] = cross.T
    return P
