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
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.field_strength import start_states
from mgeo_calibration.estimation.lengths import (
    check_normalized,
    implausible,
)
from mgeo_calibration.estimation.residuals import Residuals, residuals
from mgeo_calibration.estimation.smoother import LAST, Solution, solve
from mgeo_calibration.estimation.start import (
    accumulated,
    carried_for,
    directions,
    first_attitude,
    stretch,
)
from mgeo_calibration.estimation.trajectory import Trajectory

#: Largest number of samples that the first extension adds to each side, and the factor by which
#: each extension lengthens the interval.
FIRST, GROWTH = 200, 3
_FEWEST = 10
_ASTRAY = 1.0  # largest rotation by the gyro bias over the first extension, 1-sigma [rad]
_DRIFTED = 0.3  # largest rotation by the rate random walk over an extension, 1-sigma [rad]
_ITERATIONS = 30
_LAST_OF_STRETCH = 0.1, 1e-3
_ROUNDS = 30  # rounds of outlier rejection
_RETURNS = 6  # rounds in which a rejected reading may be accepted again


@dataclass(frozen=True, eq=False)
class Fit:
    """Smoother solution of a batch after outlier rejection.

    Attributes
    ----------
    rejected : array of bool, shape (s, N)
        Readings of each sensor that the solution does not use: readings beyond the gate, and
        readings that crossed the gate in both directions in earlier rounds.
    residuals : Residuals
    solution : Solution
    """

    rejected: Bools
    residuals: Residuals
    solution: Solution

    @property
    def batch(self) -> Batch:
        """Batch with all readings."""
        return self.solution.batch


class NoFit(ValueError):
    """Raised if the fit does not converge or most readings of a sensor are outliers."""


def fit(batch: Batch, belief: Belief, gate: float) -> Fit:
    """Estimate attitude and calibration parameters from an unknown attitude.

    The fit starts with a short interval in which the observed vectors are far apart. Wahba's
    problem gives the initial attitude. The interval is extended on both sides, each time from the
    previous estimate propagated with the gyro. A large gyro bias would make a fit of the whole
    batch diverge. If the satellite
    holds an attitude, the whole batch is solved at once from the held attitude.

    Parameters
    ----------
    batch : Batch
    belief : Belief
        Prior at the first sample.
    gate : float
        Probability of rejecting a valid reading; 0 keeps all readings.

    Raises
    ------
    NoFit
        If the estimate does not converge, or more than half of a sensor's readings are outliers.
    ValueError
        If the vectors do not determine an attitude, or a sensor reports unit vectors where three
        noisy components are expected.
    """
    N = len(batch.times)
    begin = replace(belief, states=start_states(batch, belief))
    states = np.tile(begin.states, (N, 1))
    if batch.held is not None:
        return _fit_held(batch, belief, Trajectory(batch.held.attitude, states), gate)
    where = stretch(directions(batch, accumulated(batch, states), states), N)
    check_normalized(batch)
    reach = carried_for(batch, belief.sigma[3:6], _ASTRAY)
    least = min(FIRST, max(_FEWEST, where.stop - where.start, reach))
    drifted = _count_drift_samples(batch)
    at = Trajectory(np.tile(np.eye(3), (N, 1, 1)), states)
    rejected = implausible(batch)  # Only the first solution can replace this initial guess.
    arcs = np.concatenate([[0], np.flatnonzero(batch.breaks) + 1, [N]])
    low = high = where.start
    while high - low < N:
        grown = (GROWTH - 1) * (high - low)
        more = max(least, where.stop - where.start, min(grown, max(drifted, grown // 8)))
        if drifted >= N and 2 * (high - low + more) > N:  # The whole batch costs hardly more.
            more = N
        old = low, high
        low, high = _extend_interval(low, high, more, arcs)
        at = _extend_trajectory(batch, at, old, (low, high), arcs)
        if low == 0 and belief.attitude is not None and batch.breaks[:1].any():
            at.attitude[0] = belief.attitude
        part = batch.part(low, high)
        before = belief if low == 0 else belief.without_attitude()
        known = Trajectory(at.attitude[low:high], at.states[low:high])
        last = LAST if high - low == N else _LAST_OF_STRETCH
        result = settle(part, before, known, gate, last, rejected[:, low:high])
        at.attitude[low:high] = result.solution.estimate.attitude
        at.states[low:high] = result.solution.estimate.states
        rejected[:, low:high] = result.rejected
        if high - low < N:
            del result  # Two solutions at once would double the memory.
    check(result, belief, gate)
    return result


def _fit_held(batch: Batch, belief: Belief, at: Trajectory, gate: float) -> Fit:
    """Solve from the held attitude, all samples at once."""
    check_normalized(batch)
    found = settle(batch, belief, at, gate, rejected=implausible(batch))
    check(found, belief, gate)
    return found


def settle(
    batch: Batch,
    belief: Belief,
    at: Trajectory,
    gate: float,
    last: tuple[float, float] = LAST,
    rejected: Bools | None = None,
) -> Fit:
    """Solve from a trajectory and reject outliers until the set of rejected readings is stable.

    Parameters
    ----------
    at : Trajectory
        Initial trajectory.
    gate : float
        Probability of rejecting a valid reading; 0 keeps all readings.
    last : (float, float)
        Convergence tolerances; see `Solution.settled`.
    rejected : array of bool, shape (s, N), optional
        Readings to reject in the first round.

    Returns
    -------
    Fit
        Best effort: the solution may not have converged; see `check`.
    """
    limit = limits(batch.suite, gate)[:, None]
    if rejected is None:
        rejected = np.zeros((len(batch.sensors), len(batch.times)), dtype=bool)
    number = 0
    while True:
        solution = solve(batch, belief, at, _ITERATIONS, last, rejected)
        left = residuals(solution)
        beyond = left.squares > limit
        # Readings near the gate could alternate forever. After some rounds they stay rejected.
        if number >= _RETURNS:
            beyond |= rejected
        ended = not solution.settled(last) or np.array_equal(beyond, rejected)
        number += 1
        if ended or number == _ROUNDS:
            return Fit(rejected, left, solution)
        rejected, at = beyond, solution.estimate
        del solution, left  # Two solutions at once would double the memory.


def _count_drift_samples(batch: Batch) -> int:
    """Return the number of samples in which the rate random walk rotates by `_DRIFTED`, 1-sigma."""
    walk = float(np.linalg.norm(batch.suite.gyro.effective_rate_random_walk))
    if not walk:
        return len(batch.times)
    duration = (math.sqrt(3.0) * _DRIFTED / walk) ** (2.0 / 3.0)
    return int(min(len(batch.times), duration / np.median(batch.durations)))


def limits(suite: Suite, gate: float) -> Floats:
    """Return the chi-square threshold of each sensor for a probability of false rejection."""
    return np.array([chdtri(len(sensor.noise_sigmas()), gate) for sensor in suite.sensors])


def check(result: Fit, belief: Belief, gate: float) -> None:
    """Raise NoFit if a fit has not converged or rejects most readings of a sensor.

    Raises
    ------
    NoFit
        With the diverging state, or the name of the sensor.
    """
    suite = result.batch.suite
    for sensor, no, square, limit in zip(
        suite.sensors, result.rejected, result.residuals.squares, limits(suite, gate), strict=True
    ):
        count = int(np.isfinite(square).sum())
        if 2 * no.sum() > count > 10:
            raise NoFit(
                f"{sensor.name}: {no.sum()} of {count} readings are beyond the chi-square gate of "
                f"{limit:.4g}, their median is {np.nanmedian(square):.3g}: expected "
                f"{chdtri(len(sensor.noise_sigmas()), 0.5):.2g}. Check noise, mounting and unit of "
                f"{sensor.name}"
            )
    if not result.solution.settled():
        raise NoFit(f"the fit does not converge: {_describe_divergence(result.solution, belief)}")


def _describe_divergence(solution: Solution, belief: Belief) -> str:
    suite, at = solution.batch.suite, solution.estimate
    off = belief.difference(at.attitude[0], at.states[0])
    if belief.attitude is None:
        off[:3] = 0.0
    sigmas = np.abs(off) / belief.sigma
    worst = int(sigmas.argmax())
    block = suite.blocks[worst // 3]
    unit = suite.units[block]
    turn = np.linalg.norm(solution.e[:, :3], axis=1)
    return (
        f"{block} {'xyz'[worst % 3]} is {unit.factor * at.states[0, worst]:.3g} {unit.text}, "
        f"{sigmas[worst]:.3g} prior sigmas of {unit.factor * belief.sigma[worst]:.3g} {unit.text} "
        f"from its prior; the last iteration turns the attitude by {np.degrees(turn.max()):.2g} "
        f"deg at {solution.batch.times[turn.argmax()]:.0f} s"
    )


def _extend_interval(low: int, high: int, more: int, arcs: np.ndarray) -> tuple[int, int]:
    """Return the interval extended by a number of samples on both sides.

    Arcs beyond a break of the gyro are added as a whole.
    """
    N = int(arcs[-1])
    left, right = max(0, low - more), min(N, high + more)
    first = int(arcs[np.searchsorted(arcs, low, side="right") - 1])
    last = int(arcs[np.searchsorted(arcs, max(high, low + 1), side="left")])
    if left < first:
        left = int(arcs[np.searchsorted(arcs, left, side="right") - 1])
    if right > last:
        right = int(arcs[np.searchsorted(arcs, right, side="left")])
    return left, right


def _extend_trajectory(
    batch: Batch, at: Trajectory, old: tuple[int, int], new: tuple[int, int], arcs: np.ndarray
) -> Trajectory:
    """Extend a trajectory in place over the new samples and return it.

    The attitude is propagated with the gyro, or estimated by Wahba's problem in an arc without
    estimate.
    """
    (low, high), (left, right) = old, new
    states, attitude = at.states, at.attitude
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
        part = batch.part(a, b)
        if known[0] >= known[1]:
            attitude[a:b] = _estimate_attitude(part, states[a:b])
            continue
        relative = accumulated(part, states[a:b])
        for k, span in ((known[0], slice(a, known[0])), (known[1] - 1, slice(known[1], b))):
            frame = attitude[k] @ relative[k - a].T
            attitude[span] = frame @ relative[span.start - a : span.stop - a]
    return at


def _estimate_attitude(part: Batch, states: Floats) -> Floats:
    """Return attitudes by Wahba's problem, or arbitrary attitudes where it has no solution."""
    try:
        return first_attitude(part, states)[0]
    except ValueError:
        return accumulated(part, states)
