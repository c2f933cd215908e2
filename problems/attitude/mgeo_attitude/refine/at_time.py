"""Evaluation of plans at a given time, independent of the convergence rule, and by a problem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.constraints import Constraint, list_constraints
from mgeo_attitude.criteria.objectives import find_objective
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, durations_of
from mgeo_attitude.scenario.scenario import Scenario

#: Fraction of a step by which ends are early, so that rounding does not add a step.
_EARLY = 1e-6
#: Function from designs to objectives, shape (n, k), and constraint violations, shape (n,).
Judge = Callable[[Floats], tuple[Floats, Floats]]


class PlanProblem(Protocol):
    """Problem whose designs are maneuvers of one scenario."""

    scenario: Scenario
    threads: int | None
    objectives: tuple[str, ...]

    def evaluate(self, X: Any, *args: Any, **kwargs: Any) -> Any: ...
    @property
    def model(self) -> FilterModel: ...


@dataclass(frozen=True)
class AtTime:
    """Evaluation of designs of a scenario at any filter step.

    Attributes
    ----------
    scenario : Scenario
    model : FilterModel
        Model of the scenario, possibly with thinned samples.
    name : str
        Key of the objective. The value is its logarithm ("log_det" is one already).
    threads : int, optional
        Threads of one evaluation.
    """

    scenario: Scenario
    model: FilterModel
    name: str = "trace"
    threads: int | None = None

    @cached_property
    def limits(self) -> list[Constraint]:
        """Constraints on the motion, which do not depend on the covariance at the end."""
        return [each for each in list_constraints(self.scenario) if not each.needs_covariance]

    @cached_property
    def requirements(self) -> list[Constraint]:
        """Constraints on the covariance at the end."""
        return [each for each in list_constraints(self.scenario) if each.needs_covariance]

    def values(
        self,
        designs: Floats,
        steps: Ints | int,
        required: bool = False,
        within_steps: bool = False,
    ) -> tuple[Floats, Floats]:
        """Evaluate designs at given filter steps.

        Parameters
        ----------
        designs : array, shape (n, 4 m)
        steps : array of int, shape (n,), or int
            Step at which each design is evaluated.
        required : bool
            Whether to include the constraints on the covariance at the end.
        within_steps : bool
            Whether maneuvers may end within a step, if rates change instantly; the values are then
            smooth functions of the durations.

        Returns
        -------
        value : array, shape (n,)
            Values of the objective; infinite if undefined.
        excess : array, shape (n, k)
            Violation of each constraint, positive if violated.
        """
        if within_steps and self.model.slew_limits is None:
            designs = with_partial_steps(designs, self.model.step)
        measure = find_objective(self.name, self.model.suite)
        active = self.limits + (self.requirements if required else [])
        covariance = measure.needs_covariance or any(each.needs_covariance for each in active)
        result = evaluate(
            self.model, designs, self.threads, covariance=covariance, end_steps=np.asarray(steps)
        )
        value = measure.value(self.model, result)
        with np.errstate(invalid="ignore"):
            value = value if self.name == "log_det" else np.log(value)
        excesses = [each.compute_violations(result) for each in active]
        excess = np.concatenate(excesses).T if excesses else np.empty((len(designs), 0))
        value, excess = (np.where(np.isfinite(each), each, np.inf) for each in (value, excess))
        return value, excess

    def best(self, designs: Floats, steps: int, most: int, within_steps: bool = False) -> Floats:
        """Return the `most` best designs, best first.

        The order is by the largest violation of a motion constraint, then by value.
        """
        return designs[self.order(designs, steps, within_steps)[:most]]

    def order(self, designs: Floats, steps: Ints | int, within_steps: bool = False) -> Ints:
        """Return the indices of designs in the order of `best`."""
        value, excess = self.values(designs, steps, within_steps=within_steps)
        worst = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        return np.lexsort((value, worst))

    def converging(self, designs: Floats) -> tuple[Floats, Floats]:
        """Evaluate designs with the convergence rule of the scenario.

        Returns
        -------
        F : array, shape (n, 2)
            Convergence times [s] and traces.
        violation : array, shape (n,)
            Largest violation of a motion constraint; 0 if all are satisfied.
        """
        result = evaluate(self.model, designs, self.threads)
        excesses = [each.compute_violations(result) for each in self.limits]
        worst = np.concatenate([*excesses, np.zeros((1, len(designs)))]).max(axis=0)
        return np.column_stack([result.t_end, result.trace]), worst


def at_time(problem: PlanProblem, name: str = "trace") -> AtTime:
    """Return an evaluator of a problem's designs at any time, in nominal runs."""
    return AtTime(problem.scenario, problem.model, name, problem.threads)


def judged_by(problem: PlanProblem) -> Judge:
    """Return an evaluator of designs by the objectives and constraints of a problem."""

    def judge(designs: Floats) -> tuple[Floats, Floats]:
        F, G = problem.evaluate(designs, return_values_of=["F", "G"])
        return F, np.maximum(G, 0.0).max(axis=1, initial=0.0)

    return judge


def ending_at(designs: Floats, times: Floats | float, longest: float) -> Floats:
    """Return designs that end at given times, with the last maneuvers cut short or extended.

    No maneuver becomes longer than `longest`, so that a plan may also end earlier.

    Parameters
    ----------
    designs : array, shape (n, 4 m)
    times : array, shape (n,), or float
        End of each design [s].
    longest : float
        Longest duration of a maneuver [s].
    """
    result = designs.copy()
    durations = durations_of(result)
    until = np.broadcast_to(times, len(designs))[:, None]
    ends = np.minimum(np.cumsum(durations, axis=1), until)
    ends[:, -1:] = until
    durations[:] = np.minimum(np.diff(ends, axis=1, prepend=0.0), longest)
    return result


def stretched(designs: Floats, factors: Floats | float, longest: float) -> Floats:
    """Return designs with all durations multiplied by `factors`, up to `longest` [s]."""
    result = designs.copy()
    durations = durations_of(result)
    by = np.broadcast_to(factors, len(designs))[:, None]
    durations[:] = np.minimum(by * durations, longest)
    return result


def slowed(designs: Floats, factors: Floats | float, longest: float, greatest: float) -> Floats:
    """Return designs with durations multiplied and rates divided by `factors`.

    Without saturation the designs pass through the same attitudes.

    Parameters
    ----------
    designs : array, shape (n, 4 m)
    factors : array, shape (n,), or float
    longest : float
        Longest duration of a maneuver [s].
    greatest : float
        Maximum rate about each axis [deg/s].
    """
    result = stretched(designs, factors, longest)
    maneuvers = result.reshape(len(result), -1, VARIABLES_PER_MANEUVER)
    by = np.broadcast_to(factors, len(designs))[:, None, None]
    maneuvers[:, :, :3] = np.clip(maneuvers[:, :, :3] / by, -greatest, greatest)
    return result


def on_steps(at: AtTime, designs: Floats) -> Floats:
    """Return designs, shape (n, 4 m), with maneuver ends rounded to the nearest filter step.

    A maneuver that ends within a step continues to the next step, which is half a step too late on
    average. Designs with ramps are returned unchanged, since ramps start on steps.
    """
    if at.model.slew_limits is not None:
        return designs
    result, step = designs.copy(), at.model.step
    durations = durations_of(result)
    ends = np.maximum(np.rint(np.cumsum(durations, axis=1) / step) - _EARLY, 0.0)
    longest = at.scenario.maneuvers.max_duration
    durations[:] = np.minimum(step * np.diff(ends, axis=1, prepend=0.0), longest)
    return result


def with_partial_steps(designs: Floats, step: float) -> Floats:
    """Approximate maneuvers that end within a step, as designs of shape (n, 4 (2 m - 1)).

    Each step [s] in which maneuvers end has the time-weighted mean of their rates, and all other
    ends are on steps. Values of the result are smooth functions of the durations.
    """
    maneuvers = designs.reshape(len(designs), -1, VARIABLES_PER_MANEUVER)
    rates, ends = maneuvers[:, :, :3], np.cumsum(maneuvers[:, :, 3], axis=1) / step
    if ends.shape[1] == 1:
        return designs
    starts = np.hstack([np.zeros((len(ends), 1)), ends[:, :-1]])
    shared = np.floor(ends[:, :-1])  # These are the steps in which maneuvers end, (n, m - 1).
    weights = np.minimum(shared[:, :, None] + 1.0, ends[:, None]) - np.maximum(
        shared[:, :, None], starts[:, None]
    )
    weights = np.maximum(weights, 0.0)
    weights[:, :, -1] += 1.0 - weights.sum(axis=2)  # The last rate is held in the rest of a step.
    n, m = ends.shape
    result = np.empty((n, 2 * m - 1, VARIABLES_PER_MANEUVER))
    result[:, ::2, :3], result[:, 1::2, :3] = rates, weights @ rates
    until = np.empty((n, 2 * m - 1))
    until[:, :-1:2], until[:, 1::2] = shared, shared + 1.0
    until[:, -1] = np.ceil(ends[:, -1] - _EARLY)
    until = np.maximum.accumulate(until, axis=1)
    result[:, :, 3] = step * np.diff(np.maximum(until - _EARLY, 0.0), axis=1, prepend=0.0)
    return result.reshape(n, -1)
