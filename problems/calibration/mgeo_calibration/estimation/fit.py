"""Batch fit from an unknown attitude: initial attitude, growing data interval, outlier rejection.

`calibration.calibration` fits telemetry with this module.
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
_MAX_BIAS_ROTATION = (
    1.0  # largest rotation by the gyro bias over the first extension, 1-sigma [rad]
)
_MAX_WALK_ROTATION = (
    0.3  # largest rotation by the rate random walk over an extension, 1-sigma [rad]
)
_MAX_ITERATIONS = 30
_INTERVAL_TOLERANCES = 0.1, 1e-3
_MAX_ROUNDS = 30  # rounds of outlier rejection
_MAX_ACCEPTANCE_ROUNDS = 6  # rounds in which a rejected reading may be accepted again


@dataclass(frozen=True, eq=False)
class Fit:
    """Smoother solution of a batch after outlier rejection.

    Attributes
    ----------
    is_rejected : array of bool, shape (s, N)
        Readings of each sensor that the solution does not use: readings beyond the gate, and
        readings that crossed the gate in both directions in earlier rounds.
    residuals : Residuals
    solution : Solution
    """

    is_rejected: Bools
    residuals: Residuals
    solution: Solution

    @property
    def batch(self) -> Batch:
        """Batch with all readings."""
        return self.solution.batch


class FitError(ValueError):
    """Raised if the fit does not converge or most readings of a sensor are outliers."""


def fit(batch: Batch, prior: PriorEstimate, gate: float) -> Fit:
    """Estimate attitude and calibration parameters from an unknown attitude.

    The fit starts with a short interval in which the observed vectors are far apart. Wahba's
    problem gives the initial attitude. The interval is extended on both sides, each time from the
    previous estimate propagated with the gyro. A large gyro bias would make a fit of the whole
    batch diverge. If the satellite
    holds an attitude, the whole batch is solved at once from the held attitude.

    Parameters
    ----------
    batch : Batch
    prior : PriorEstimate
        Prior at the first sample.
    gate : float
        Probability of rejecting a valid reading; 0 keeps all readings.

    Raises
    ------
    FitError
        If the estimate does not converge, or more than half of a sensor's readings are outliers.
    ValueError
        If the vectors do not determine an attitude, or a sensor reports unit vectors where three
        noisy components are expected.
    """
    N = len(batch.times)
    begin = replace(prior, states=compute_initial_states(batch, prior))
    states = np.tile(begin.states, (N, 1))
    if batch.pointing is not None:
        return _fit_held_attitude(batch, prior, Trajectory(batch.pointing.attitude, states), gate)
    where = find_interval(collect_directions(batch, accumulate_rotations(batch, states), states), N)
    validate_vector_lengths(batch)
    reach = count_propagated_samples(batch, prior.sigma[3:6], _MAX_BIAS_ROTATION)
    least = min(MAX_FIRST_EXTENSION, max(_MIN_EXTENSION, where.stop - where.start, reach))
    drifted = _count_drift_samples(batch)
    at = Trajectory(np.tile(np.eye(3), (N, 1, 1)), states)
    rejected = find_outlying_lengths(
        batch
    )  # Only the first solution can replace this initial guess.
    arcs = np.concatenate([[0], np.flatnonzero(batch.breaks) + 1, [N]])
    low = high = where.start
    while high - low < N:
        grown = (EXTENSION_FACTOR - 1) * (high - low)
        more = max(least, where.stop - where.start, min(grown, max(drifted, grown // 8)))
        if drifted >= N and 2 * (high - low + more) > N:  # The whole batch costs hardly more.
            more = N
        old = low, high
        low, high = _extend_interval(low, high, more, arcs)
        at = _extend_trajectory(batch, at, old, (low, high), arcs)
        if low == 0 and prior.attitude is not None and batch.breaks[:1].any():
            at.attitude[0] = prior.attitude
        part = batch.select_samples(low, high)
        before = prior if low == 0 else prior.reset_varying_states()
        known = Trajectory(at.attitude[low:high], at.states[low:high])
        last = TOLERANCES if high - low == N else _INTERVAL_TOLERANCES
        result = fit_from_trajectory(part, before, known, gate, last, rejected[:, low:high])
        at.attitude[low:high] = result.solution.estimate.attitude
        at.states[low:high] = result.solution.estimate.states
        rejected[:, low:high] = result.is_rejected
        if high - low < N:
            del result  # Two solutions at once would double the memory.
    check_fit(result, prior, gate)
    return result


def _fit_held_attitude(
    batch: Batch, prior: PriorEstimate, trajectory: Trajectory, gate: float
) -> Fit:
    """Solve from the held attitude, all samples at once."""
    validate_vector_lengths(batch)
    found = fit_from_trajectory(
        batch, prior, trajectory, gate, is_rejected=find_outlying_lengths(batch)
    )
    check_fit(found, prior, gate)
    return found


def fit_from_trajectory(
    batch: Batch,
    prior: PriorEstimate,
    trajectory: Trajectory,
    gate: float,
    tolerances: tuple[float, float] = TOLERANCES,
    is_rejected: Bools | None = None,
) -> Fit:
    """Solve from a trajectory and reject outliers until the set of rejected readings is stable.

    Parameters
    ----------
    trajectory : Trajectory
        Initial trajectory.
    gate : float
        Probability of rejecting a valid reading; 0 keeps all readings.
    tolerances : (float, float)
        Convergence tolerances; see `Solution.settled`.
    is_rejected : array of bool, shape (s, N), optional
        Readings to reject in the first round.

    Returns
    -------
    Fit
        Best effort: the solution may not have converged; see `check`.
    """
    limit = compute_gate_thresholds(batch.suite, gate)[:, None]
    if is_rejected is None:
        is_rejected = np.zeros((len(batch.readings), len(batch.times)), dtype=bool)
    number = 0
    while True:
        solution = solve(batch, prior, trajectory, _MAX_ITERATIONS, tolerances, is_rejected)
        left = compute_residuals(solution)
        beyond = left.normalized_squares > limit
        # Readings near the gate could alternate forever. After some rounds they stay rejected.
        if number >= _MAX_ACCEPTANCE_ROUNDS:
            beyond |= is_rejected
        ended = not solution.is_converged(tolerances) or np.array_equal(beyond, is_rejected)
        number += 1
        if ended or number == _MAX_ROUNDS:
            return Fit(is_rejected, left, solution)
        is_rejected, trajectory = beyond, solution.estimate
        del solution, left  # Two solutions at once would double the memory.


def _count_drift_samples(batch: Batch) -> int:
    """Return the number of samples in which the rate random walk rotates by `_DRIFTED`, 1-sigma."""
    walk = float(np.linalg.norm(batch.suite.gyro.effective_rate_random_walk))
    if not walk:
        return len(batch.times)
    duration = (math.sqrt(3.0) * _MAX_WALK_ROTATION / walk) ** (2.0 / 3.0)
    return int(min(len(batch.times), duration / np.median(batch.durations)))


def compute_gate_thresholds(suite: Suite, gate: float) -> Floats:
    """Return the chi-square threshold of each sensor for a probability of false rejection."""
    return np.array([chdtri(len(sensor.noise_sigmas()), gate) for sensor in suite.sensors])


def check_fit(result: Fit, prior: PriorEstimate, gate: float) -> None:
    """Raise FitError if a fit has not converged or rejects most readings of a sensor.

    Raises
    ------
    FitError
        With the diverging state, or the name of the sensor.
    """
    suite = result.batch.suite
    for sensor, no, square, limit in zip(
        suite.sensors,
        result.is_rejected,
        result.residuals.normalized_squares,
        compute_gate_thresholds(suite, gate),
        strict=True,
    ):
        count = int(np.isfinite(square).sum())
        if 2 * no.sum() > count > 10:
            raise FitError(
                f"{sensor.name}: {no.sum()} of {count} readings are beyond the chi-square gate of "
                f"{limit:.4g}, their median is {np.nanmedian(square):.3g}: expected "
                f"{chdtri(len(sensor.noise_sigmas()), 0.5):.2g}. Check noise, mounting and unit of "
                f"{sensor.name}"
            )
    if not result.solution.is_converged():
        raise FitError(f"the fit does not converge: {_describe_divergence(result.solution, prior)}")


def _describe_divergence(solution: Solution, prior: PriorEstimate) -> str:
    suite, at = solution.batch.suite, solution.estimate
    off = prior.compute_difference(at.attitude[0], at.states[0])
    if prior.attitude is None:
        off[:3] = 0.0
    sigmas = np.abs(off) / prior.sigma
    worst = int(sigmas.argmax())
    block = suite.blocks[worst // 3]
    unit = suite.units[block]
    turn = np.linalg.norm(solution.stochastic_errors[:, :3], axis=1)
    return (
        f"{block} {'xyz'[worst % 3]} is {unit.factor * at.states[0, worst]:.3g} {unit.text}, "
        f"{sigmas[worst]:.3g} prior sigmas of {unit.factor * prior.sigma[worst]:.3g} {unit.text} "
        f"from its prior; the last iteration turns the attitude by {np.degrees(turn.max()):.2g} "
        f"deg at {solution.batch.times[turn.argmax()]:.0f} s"
    )


def _extend_interval(low: int, high: int, n_new: int, arcs: np.ndarray) -> tuple[int, int]:
    """Return the interval extended by a number of samples on both sides.

    Arcs beyond a break of the gyro are added as a whole.
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
    """Extend a trajectory in place over the new samples and return it.

    The attitude is propagated with the gyro, or estimated by Wahba's problem in an arc without
    estimate.
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
        known = max(a, low), min(b, high)
        if a >= b:
            continue
        part = batch.select_samples(a, b)
        if known[0] >= known[1]:
            attitude[a:b] = _estimate_attitude(part, states[a:b])
            continue
        relative = accumulate_rotations(part, states[a:b])
        for k, span in ((known[0], slice(a, known[0])), (known[1] - 1, slice(known[1], b))):
            frame = attitude[k] @ relative[k - a].T
            attitude[span] = frame @ relative[span.start - a : span.stop - a]
    return trajectory


def _estimate_attitude(batch: Batch, states: Floats) -> Floats:
    """Return attitudes by Wahba's problem, or arbitrary attitudes where it has no solution."""
    try:
        return estimate_initial_attitude(batch, states)[0]
    except ValueError:
        return accumulate_rotations(batch, states)
