"""Gradient-based descent on the objective of plans at given times."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.evaluators import FixedTimeEvaluator
from mgeo_attitude.refine.minimizers import minimize_bounded, minimize_constrained

#: Finite-difference increments: of a rate, relative to the maximum; of a duration, in filter steps.
_RATE_STEP, _DURATION_STEP = 1e-5, 1e-2
#: Relative margin to constraints, so that rounding errors do not violate them.
_MARGIN = 1e-6
#: Decrease of the logarithm of the objective below which a descent ends.
_TOLERANCE = 3e-5
#: Share of the descents of a group that continue, by the number of evaluated points.
_CONTINUING_SHARES = {3: 1 / 3, 8: 1 / 2, 20: 1 / 2}
#: Share of the plan's time that counts as zero.
_ZERO_SHARE = 1e-12
#: Finite replacement of an infinite objective.
_INFINITE_VALUE = 1e3


@dataclass
class DescentProblem:
    """Set of n problems, each of which minimizes the objective of one plan at a given time.

    The variables are the rates relative to the maximum rate, from -1 to 1, and the durations as
    shares of the time, from 0 to 1. The shares need not sum to one.

    Attributes
    ----------
    evaluator : FixedTimeEvaluator
    times : float or array, shape (n,)
        Time at which each plan ends and is evaluated [s].
    n_maneuvers : int
        Number m of maneuvers of each plan.
    """

    evaluator: FixedTimeEvaluator
    times: float | Floats
    n_maneuvers: int

    @property
    def steps(self) -> Ints:
        """Filter step at which each plan ends and is evaluated, shape () or (n,)."""
        steps = np.rint(np.asarray(self.times) / self.evaluator.model.step).astype(np.int64)
        return np.clip(steps, 1, self.evaluator.model.n_steps)

    @property
    def bounds(self) -> Floats:
        return np.array([(-1.0, 1.0)] * (3 * self.n_maneuvers) + [(0.0, 1.0)] * self.n_maneuvers)

    def select(self, rows: Ints | list[int]) -> DescentProblem:
        return DescentProblem(self.evaluator, np.asarray(self.times)[rows], self.n_maneuvers)

    def to_variables(self, designs: Floats) -> Floats:
        """Convert designs, shape (4 m,) or (n, 4 m), to scaled optimization variables.

        The variables have the shape of the designs and are clipped to `bounds`.
        """
        maneuvers = designs.reshape(*designs.shape[:-1], -1, VARIABLES_PER_MANEUVER)
        rates = maneuvers[..., :3] / self.evaluator.scenario.maneuvers.max_rate_deg_s
        shares = maneuvers[..., 3] / np.asarray(self.times)[..., None]
        scaled = np.concatenate([rates.reshape(*shares.shape[:-1], -1), shares], axis=-1)
        within: Floats = np.clip(scaled, *self.bounds.T)
        return within

    def to_designs(self, variables: Floats) -> Floats:
        """Convert scaled optimization variables to designs that last until the time of each plan.

        The designs have the shape (n, 4 m). A design is shorter than its time if all maneuvers have
        the maximum duration.
        """
        z = np.clip(np.atleast_2d(variables), *self.bounds.T)
        limits, n = self.evaluator.scenario.maneuvers, len(z)
        rates = limits.max_rate_deg_s * z[:, : 3 * self.n_maneuvers].reshape(n, -1, 3)
        shares = z[:, 3 * self.n_maneuvers :] + _ZERO_SHARE
        times = np.broadcast_to(self.times, n)[:, None]
        durations = times * shares / shares.sum(axis=1, keepdims=True)
        # Time beyond the maximum duration is given to the other maneuvers, in proportion to how
        # much each of them may be extended.
        remaining = np.maximum(limits.max_duration - durations, 0.0)
        excess = np.maximum(durations - limits.max_duration, 0.0).sum(axis=1, keepdims=True)
        fraction = np.minimum(
            excess / np.maximum(remaining.sum(axis=1, keepdims=True), _ZERO_SHARE), 1.0
        )
        durations = np.minimum(durations, limits.max_duration) + fraction * remaining
        return np.concatenate([rates, durations[:, :, None]], axis=2).reshape(n, -1)

    def evaluate_gradients(self, variables: Floats) -> tuple[Floats, Floats]:
        """Evaluate the objective and the constraint margins of each plan, and their gradients.

        The gradients are computed by finite differences.

        Parameters
        ----------
        variables : array, shape (n, 4 m)
            Scaled variables of each plan.

        Returns
        -------
        values : array, shape (n, 1 + k)
            Objective, then the margin of each constraint, positive if satisfied.
        gradients : array, shape (n, 1 + k, 4 m)
            Derivatives of the values with respect to the variables.
        """
        model, (n, size) = self.evaluator.model, variables.shape
        is_smooth = model.slew_limits is None  # Ramps start on steps, so that values have jumps.
        times = np.broadcast_to(self.times, n)
        steps = np.full((n, size), _RATE_STEP)
        steps[:, 3 * self.n_maneuvers :] = (
            (_DURATION_STEP if is_smooth else 1.0) * model.step / times[:, None]
        )
        steps = np.where(variables + steps > self.bounds[:, 1], -steps, steps)
        points = np.repeat(variables[:, None], 1 + size, axis=1)
        points[:, 1:] += steps[:, :, None] * np.eye(size)
        descent = DescentProblem(self.evaluator, np.repeat(times, 1 + size), self.n_maneuvers)
        designs = descent.to_designs(points.reshape(-1, size))
        value, excess = self.evaluator.evaluate_at_steps(
            designs, descent.steps, include_covariance_constraints=True, allow_partial_steps=True
        )
        values = np.column_stack(
            [np.minimum(value, _INFINITE_VALUE), -_MARGIN - np.minimum(excess, _INFINITE_VALUE)]
        )
        values = values.reshape(n, 1 + size, -1)
        differences = values[:, 1:] - values[:, :1]
        return values[:, 0], np.moveaxis(differences / steps[:, :, None], 1, 2)


def descend(
    evaluator: FixedTimeEvaluator, designs: Floats, times: float | Floats, max_iterations: int
) -> Floats:
    """Improve n designs by gradient-based descents at given times, within all constraints.

    All descents run in parallel. They use `minimize_constrained` if there are constraints,
    otherwise `minimize_bounded`. A design whose descent fails is returned unchanged.

    Parameters
    ----------
    evaluator : FixedTimeEvaluator
    designs : array, shape (n, 4 m)
        Designs that end by their time.
    times : float or array, shape (n,)
        Time of each design [s].
    max_iterations : int
        Largest number of iterations.

    Returns
    -------
    array, shape (n, 4 m)
    """
    count = designs.shape[1] // VARIABLES_PER_MANEUVER
    problem = DescentProblem(evaluator, np.broadcast_to(times, len(designs)), count)
    initial = problem.to_variables(designs)
    with warnings.catch_warnings():
        # The line search of SLSQP warns if it leaves the bounds by rounding.
        warnings.filterwarnings("ignore", "Values in x were outside bounds", RuntimeWarning)
        final = _run_in_parallel(problem, initial, max_iterations)
    is_finite: Bools = np.asarray(np.isfinite(final).all(axis=1))[:, None]
    return np.where(is_finite, problem.to_designs(np.where(is_finite, final, initial)), designs)


def descend_from_best(
    evaluator: FixedTimeEvaluator,
    designs: Floats,
    times: Floats,
    time_indices: Ints,
    max_iterations: int,
) -> Floats:
    """Find the best design for each of k times by descents from several initial designs.

    The scenario must have no constraints. All descents run in parallel. After a few points only the
    best third of the descents for a time continues, and later twice the better half.

    Parameters
    ----------
    evaluator : FixedTimeEvaluator
    designs : array, shape (n, 4 m)
        Initial designs.
    times : array, shape (k,)
        Times [s].
    time_indices : array of int, shape (n,)
        Index of the time of each design, ascending. Every time has a design.
    max_iterations : int
        Largest number of iterations.

    Returns
    -------
    array, shape (k, 4 m)
    """
    problem = DescentProblem(
        evaluator, times[time_indices], designs.shape[1] // VARIABLES_PER_MANEUVER
    )
    groups = [np.flatnonzero(time_indices == k).tolist() for k in range(len(times))]
    final = _run_in_parallel(problem, problem.to_variables(designs), max_iterations, groups)
    return problem.to_designs(final)[[group[0] for group in groups]]


def _run_in_parallel(
    problem: DescentProblem,
    initial_variables: Floats,
    iterations: int,
    groups: Sequence[list[int]] = (),
) -> Floats:
    """Minimize the objectives of all plans in parallel, and return the final scaled variables.

    Each list in `groups` contains the rows of one time. It is reduced in place to the descents that
    continue, the best first.
    """
    final, least = initial_variables.copy(), np.full(len(initial_variables), np.inf)
    is_constrained = bool(
        problem.evaluator.motion_constraints or problem.evaluator.covariance_constraints
    )
    minimize: Any = minimize_constrained if is_constrained else minimize_bounded
    minimizers = [minimize(z, problem.bounds, iterations, _TOLERANCE) for z in initial_variables]
    requests = {row: next(minimizer) for row, minimizer in enumerate(minimizers)}
    n_points = 0
    while requests:
        rows = list(requests)
        values, slopes = problem.select(rows).evaluate_gradients(np.array(list(requests.values())))
        for row, value, slope in zip(rows, values, slopes, strict=True):
            least[row] = min(least[row], value[0])
            try:
                result = (value, slope) if is_constrained else (float(value[0]), slope[0])
                requests[row] = minimizers[row].send(result)
            except StopIteration as end:
                final[row] = end.value
                del requests[row]
        n_points += 1
        if n_points in _CONTINUING_SHARES:
            for group in groups:
                group.sort(key=lambda row: least[row])
                n_left = max(int(_CONTINUING_SHARES[n_points] * len(group)), 1)
                for row in group[n_left:]:
                    requests.pop(row, None)
                del group[n_left:]
    for group in groups:
        group.sort(key=lambda row: least[row])
    return final
