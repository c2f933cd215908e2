"""Smoothing of a telemetry batch without an initial attitude, with rejection of outliers.

`calibration.calibrate` estimates the calibration parameters with this module.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.suite import Suite
from scipy.special import chdtri

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.field_strength import compute_initial_states
from mgeo_calibration.estimation.initial_attitude import (
    accumulate_rotations,
    collect_directions,
    count_propagated_samples,
    estimate_initial_attitude,
    find_interval,
)
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.residuals import Residuals, compute_residuals
from mgeo_calibration.estimation.smoother import TOLERANCES, Solution, solve
from mgeo_calibration.estimation.trajectory import Trajectory
from mgeo_calibration.estimation.vector_lengths import (
    find_outlying_lengths,
    validate_vector_lengths,
)

#: Largest number of samples that the first extension adds to each side, and the factor by which
#: each extension lengthens the interval.
MAX_FIRST_EXTENSION, EXTENSION_FACTOR = 200, 3
_MIN_EXTENSION = 10
#: Largest rotation by the gyro bias over the first extension, 1-sigma [rad].
_MAX_BIAS_ROTATION = 1.0
#: Largest rotation by the rate random walk of the gyro over an extension, 1-sigma [rad].
_MAX_WALK_ROTATION = 0.3
_MAX_ITERATIONS = 30
#: Convergence tolerances of all intervals but the last; see `smoother.TOLERANCES`.
_INTERVAL_TOLERANCES = 0.1, 1e-3
#: Largest number of rounds of outlier rejection, and number of rounds in which a rejected reading
#: may be accepted again.
_MAX_ROUNDS, _MAX_ACCEPTANCE_ROUNDS = 30, 6


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of smoothing a telemetry batch, with residuals and rejected outliers.

    Attributes
    ----------
    is_rejected : array of bool, shape (s, N)
        Readings of each sensor that the solution does not use: readings beyond the gate, and
        readings that crossed the gate in both directions in earlier rounds.
    residuals : Residuals
        Residuals of all readings, including the rejected readings.
    solution : Solution
        Smoother solution of the last round of outlier rejection.
    """

    is_rejected: Bools
    residuals: Residuals
    solution: Solution

    @property
    def batch(self) -> Batch:
        """Telemetry batch that was fitted, including the rejected readings."""
        return self.solution.batch


class FitError(ValueError):
    """Exception raised if a fit does not converge, or if it rejects most readings of a sensor."""


def fit(batch: Batch, prior: PriorEstimate, gate: float) -> Fit:
    """Estimate attitude and calibration parameters by smoothing a telemetry batch. No initial
    attitude is needed.

    The fit starts with a short interval in which the observed vectors are far apart. Wahba's
    problem gives the initial attitude of this interval. The interval is then extended on both
    sides, each time from the previous estimate propagated with the gyro, because a large gyro bias
    would make a fit of the whole batch diverge. If the satellite is assumed to hold an attitude,
    the whole batch is fitted at once from this attitude.

    Parameters
    ----------
    batch : Batch
    prior : PriorEstimate
        Prior estimate at the first sample.
    gate : float
        Probability of rejecting a valid reading; 0 keeps all readings.

    Returns
    -------
    Fit
        Converged smoother solution.

    Raises
    ------
    FitError
        If the estimate does not converge, or more than half of a sensor's readings are outliers.
    ValueError
        If the vectors do not determine an attitude, or a sensor reports unit vectors where three
        noisy components are expected.
    """
    N = len(batch.times)
    initial = replace(prior, states=compute_initial_states(batch, prior))
    states = np.tile(initial.states, (N, 1))
    if batch.pointing is not None:
        return _fit_held_attitude(batch, prior, Trajectory(batch.pointing.attitude, states), gate)
    interval = find_interval(
        collect_directions(batch, accumulate_rotations(batch, states), states), N
    )
    validate_vector_lengths(batch)
    n_bias_samples = count_propagated_samples(batch, prior.sigma[3:6], _MAX_BIAS_ROTATION)
    min_extension = min(
        MAX_FIRST_EXTENSION, max(_MIN_EXTENSION, interval.stop - interval.start, n_bias_samples)
    )
    n_drift_samples = _count_drift_samples(batch)
    trajectory = Trajectory(np.tile(np.eye(3), (N, 1, 1)), states)
    # The fit of an interval may accept these readings again.
    is_rejected = find_outlying_lengths(batch)
    arcs = np.concatenate([[0], np.flatnonzero(batch.breaks) + 1, [N]])
    low = high = interval.start
    while high - low < N:
        growth = (EXTENSION_FACTOR - 1) * (high - low)
        n_new = max(
            min_extension,
            interval.stop - interval.start,
            min(growth, max(n_drift_samples, growth // 8)),
        )
        if n_drift_samples >= N and 2 * (high - low + n_new) > N:
            n_new = N  # A fit of the whole batch takes little more time than this extension.
        previous = low, high
        low, high = _extend_interval(low, high, n_new, arcs)
        trajectory = _extend_trajectory(batch, trajectory, previous, (low, high), arcs)
        if low == 0 and prior.attitude is not None and batch.breaks[:1].any():
            trajectory.attitude[0] = prior.attitude
        interval_batch = batch.select_samples(low, high)
        interval_prior = prior if low == 0 else prior.reset_varying_states()
        interval_trajectory = Trajectory(trajectory.attitude[low:high], trajectory.states[low:high])
        tolerances = TOLERANCES if high - low == N else _INTERVAL_TOLERANCES
        result = fit_from_trajectory(
            interval_batch,
            interval_prior,
            interval_trajectory,
            gate,
            tolerances,
            is_rejected[:, low:high],
        )
        trajectory.attitude[low:high] = result.solution.estimate.attitude
        trajectory.states[low:high] = result.solution.estimate.states
        is_rejected[:, low:high] = result.is_rejected
        if high - low < N:
            del result  # Two solutions at once would double the memory.
    check_fit(result, prior, gate)
    return result


def _fit_held_attitude(
    batch: Batch, prior: PriorEstimate, trajectory: Trajectory, gate: float
) -> Fit:
    """Smooth a whole batch of telemetry from a satellite that is assumed to hold an attitude.

    The assumed attitude is the initial guess at all samples.
    """
    validate_vector_lengths(batch)
    result = fit_from_trajectory(
        batch, prior, trajectory, gate, is_rejected=find_outlying_lengths(batch)
    )
    check_fit(result, prior, gate)
    return result


def fit_from_trajectory(
    batch: Batch,
    prior: PriorEstimate,
    trajectory: Trajectory,
    gate: float,
    tolerances: tuple[float, float] = TOLERANCES,
    is_rejected: Bools | None = None,
) -> Fit:
    """Smooth a batch from an initial trajectory, and repeat without outliers until the set of
    outliers no longer changes.

    An outlier is a reading whose normalized squared residual exceeds the chi-square threshold of
    its sensor.

    Parameters
    ----------
    batch : Batch
    prior : PriorEstimate
        Prior estimate at the first sample.
    trajectory : Trajectory
        Initial trajectory.
    gate : float
        Probability of rejecting a valid reading; 0 keeps all readings.
    tolerances : (float, float)
        Convergence tolerances; see `Solution.is_converged`.
    is_rejected : array of bool, shape (s, N), optional
        Readings to reject in the first round.

    Returns
    -------
    Fit
        Result of the last round. The solution may not have converged; see `check_fit`.
    """
    thresholds = compute_gate_thresholds(batch.suite, gate)[:, None]
    if is_rejected is None:
        is_rejected = np.zeros((len(batch.readings), len(batch.times)), dtype=bool)
    n_rounds = 0
    while True:
        solution = solve(batch, prior, trajectory, _MAX_ITERATIONS, tolerances, is_rejected)
        residuals = compute_residuals(solution)
        is_outlier = residuals.normalized_squares > thresholds
        # Readings near the threshold could alternate forever. After some rounds they stay rejected.
        if n_rounds >= _MAX_ACCEPTANCE_ROUNDS:
            is_outlier |= is_rejected
        is_last = not solution.is_converged(tolerances) or np.array_equal(is_outlier, is_rejected)
        n_rounds += 1
        if is_last or n_rounds == _MAX_ROUNDS:
            return Fit(is_rejected, residuals, solution)
        is_rejected, trajectory = is_outlier, solution.estimate
        del solution, residuals  # Two solutions at once would double the memory.


def _count_drift_samples(batch: Batch) -> int:
    """Return the number of samples over which gyro propagation of the attitude is accurate.

    After more samples, the rate random walk of the gyro causes a 1-sigma rotation larger than
    `_MAX_WALK_ROTATION`.
    """
    walk = float(np.linalg.norm(batch.suite.gyro.effective_rate_random_walk))
    if not walk:
        return len(batch.times)
    duration = (math.sqrt(3.0) * _MAX_WALK_ROTATION / walk) ** (2.0 / 3.0)
    return int(min(len(batch.times), duration / np.median(batch.durations)))


def compute_gate_thresholds(suite: Suite, gate: float) -> Floats:
    """Return the normalized squared residual above which a sensor's reading is an outlier.

    The thresholds are quantiles of the chi-square distribution.

    Parameters
    ----------
    suite : Suite
    gate : float
        Probability that a valid reading exceeds the threshold.

    Returns
    -------
    array, shape (s,)
    """
    return np.array([chdtri(len(sensor.noise_sigmas()), gate) for sensor in suite.sensors])


def check_fit(result: Fit, prior: PriorEstimate, gate: float) -> None:
    """Raise FitError if a fit has not converged or rejects more than half of a sensor's readings.

    Parameters
    ----------
    result : Fit
    prior : PriorEstimate
        Prior of the fit, for the message.
    gate : float
        Probability of rejecting a valid reading, as in `fit`.

    Raises
    ------
    FitError
        With the diverging state, or the name of the sensor.
    """
    suite = result.batch.suite
    for sensor, is_rejected, square, threshold in zip(
        suite.sensors,
        result.is_rejected,
        result.residuals.normalized_squares,
        compute_gate_thresholds(suite, gate),
        strict=True,
    ):
        count = int(np.isfinite(square).sum())
        if 2 * is_rejected.sum() > count > 10:
            raise FitError(
                f"{sensor.name}: {is_rejected.sum()} of {count} readings are beyond the chi-square "
                f"gate of {threshold:.4g}. The median of the normalized squared residuals is "
                f"{np.nanmedian(square):.3g}: expected "
                f"{chdtri(len(sensor.noise_sigmas()), 0.5):.2g}. Check noise, mounting and unit of "
                f"{sensor.name}"
            )
    if not result.solution.is_converged():
        raise FitError(f"the fit does not converge: {_describe_divergence(result.solution, prior)}")


def _describe_divergence(solution: Solution, prior: PriorEstimate) -> str:
    """Describe a fit that does not converge, for an error message.

    The text states the parameter farthest from its prior and the largest attitude change in the
    last iteration.
    """
    suite, estimate = solution.batch.suite, solution.estimate
    difference = prior.compute_difference(estimate.attitude[0], estimate.states[0])
    if prior.attitude is None:
        difference[:3] = 0.0
    sigmas = np.abs(difference) / prior.sigma
    worst = int(sigmas.argmax())
    block = suite.blocks[worst // 3]
    unit = suite.units[block]
    correction = np.linalg.norm(solution.stochastic_errors[:, :3], axis=1)
    return (
        f"{block} {'xyz'[worst % 3]} is {unit.factor * estimate.states[0, worst]:.3g} {unit.text}, "
        f"{sigmas[worst]:.3g} initial 1-sigmas of {unit.factor * prior.sigma[worst]:.3g} "
        f"{unit.text} from its prior; the last iteration rotates the attitude by "
        f"{np.degrees(correction.max()):.2g} deg at "
        f"{solution.batch.times[correction.argmax()]:.0f} s"
    )


def _extend_interval(low: int, high: int, n_new: int, arcs: np.ndarray) -> tuple[int, int]:
    """Extend an interval of samples by `n_new` samples on both sides, and return the new bounds.

    An arc contains the samples between two gyro breaks; `arcs` holds the bounds of all arcs. An arc
    beyond a gyro break is always added completely.
    """
    N = int(arcs[-1])
    left, right = max(0, low - n_new), min(N, high + n_new)
    first = int(arcs[np.searchsorted(arcs, low, side="right") - 1])
    last = int(arcs[np.searchsorted(arcs, max(high, low + 1), side="left")])
    if left < first:
        left = int(arcs[np.searchsorted(arcs, left, side="right") - 1])
    if right > last:
        right = int(arcs[np.searchsorted(arcs, right, side="left")])
    return left, right


def _extend_trajectory(
    batch: Batch,
    trajectory: Trajectory,
    old_interval: tuple[int, int],
    new_interval: tuple[int, int],
    arcs: np.ndarray,
) -> Trajectory:
    """Set initial values of the attitude and the states at the new samples of an interval.

    The trajectory is modified in place. States are copied from the nearest old sample, with decay
    toward zero for random processes. The attitude is propagated with the gyro. In an arc without
    estimates, the attitude follows from Wahba's problem.
    """
    (low, high), (left, right) = old_interval, new_interval
    states, attitude = trajectory.states, trajectory.attitude
    processes, m = batch.suite.processes, batch.suite.n_dynamic
    if high > low:
        for k, span in ((low, slice(left, low)), (high - 1, slice(high, right))):
            states[span] = states[k]
            elapsed = batch.times[span, None] - batch.times[k]
            states[span, 3:6] *= np.exp(-batch.suite.gyro.bias_decay * elapsed)
            for process, i in zip(
                processes.values(), range(batch.suite.n_kinematic, m, 3), strict=True
            ):
                decay, _ = process.discretize(np.abs(elapsed))
                states[span, i : i + 3] *= decay
    for first, end in pairwise(arcs.tolist()):
        a, b = max(first, left), min(end, right)
        estimated = max(a, low), min(b, high)
        if a >= b:
            continue
        arc = batch.select_samples(a, b)
        if estimated[0] >= estimated[1]:
            attitude[a:b] = _estimate_attitude(arc, states[a:b])
            continue
        relative = accumulate_rotations(arc, states[a:b])
        for k, span in (
            (estimated[0], slice(a, estimated[0])),
            (estimated[1] - 1, slice(estimated[1], b)),
        ):
            frame = attitude[k] @ relative[k - a].T
            attitude[span] = frame @ relative[span.start - a : span.stop - a]
    return trajectory


def _estimate_attitude(batch: Batch, states: Floats) -> Floats:
    """Estimate the attitude at all samples from Wahba's problem and the gyro rates.

    If Wahba's problem has no solution, the first attitude is the identity.
    """
    try:
        return estimate_initial_attitude(batch, states)[0]
    except ValueError:
        return accumulate_rotations(batch, states)
