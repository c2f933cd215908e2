"""What plans are worth: at a time, whatever the rule of convergence, and by a problem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.constraints import Constraint, constraints
from mgeo_attitude.criteria.objectives import objective
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, durations_of
from mgeo_attitude.scenario.scenario import Scenario

#: By how much of a step ends are early, so that rounding does not put them past a step.
_EARLY = 1e-6
#: Objectives and constraint violations, the latter 0 where all is kept, shapes (n, k) and (n,).
Judge = Callable[[Floats], tuple[Floats, Floats]]


class PlanProblem(Protocol):
    """A problem whose designs are maneuvers of one scenario."""

    scenario: Scenario
    threads: int | None
    objectives: tuple[str, ...]

    def evaluate(self, X: Any, *args: Any, **kwargs: Any) -> Any: ...
    @property
    def model(self) -> FilterModel: ...


@dataclass(frozen=True)
class AtTime:
    """Values of designs of a scenario at any step of the filter.

    Attributes
    ----------
    name : str
        Of the objective; its logarithm is the value.
    """

    scenario: Scenario
    model: FilterModel
    name: str = "trace"
    threads: int | None = None

    @cached_property
    def limits(self) -> list[Constraint]:
        """Of what is flown on the way."""
        return [each for each in constraints(self.scenario) if not each.needs_covariance]

    @cached_property
    def requirements(self) -> list[Constraint]:
        """Of what is known at the end."""
        return [each for each in constraints(self.scenario) if each.needs_covariance]

    def values(
        self,
        designs: Floats,
        steps: Ints | int,
        required: bool = False,
        within_steps: bool = False,
    ) -> tuple[Floats, Floats]:
        """Value, shape (n,), and excess over each limit, shape (n, k), after so many steps.

        A design without a value has an infinite one. Limits are those on the way and, where they
        are `required`, those of the end. Maneuvers end `within_steps` where rates change at once.
        """
        if within_steps and self.model.slew_limits is None:
            designs = with_partial_steps(designs, self.model.step)
        found = objective(self.name, self.model.suite)
        asked = self.limits + (self.requirements if required else [])
        covariance = found.needs_covariance or any(each.needs_covariance for each in asked)
        result = evaluate(
            self.model, designs, self.threads, covariance=covariance, until=np.asarray(steps)
        )
        value = found.value(self.model, result)
        with np.errstate(invalid="ignore"):
            value = value if self.name == "log_det" else np.log(value)
        excesses = [each.excesses(result) for each in asked]
        excess = np.concatenate(excesses).T if excesses else np.empty((len(designs), 0))
        value, excess = (np.where(np.isfinite(each), each, np.inf) for each in (value, excess))
        return value, excess

    def best(self, designs: Floats, steps: int, most: int, within_steps: bool = False) -> Floats:
        """So many of the designs, the best first: least values after those that keep limits most.

        Limits are those on the way.
        """
        return designs[self.order(designs, steps, within_steps)[:most]]

    def order(self, designs: Floats, steps: Ints | int, within_steps: bool = False) -> Ints:
        """Rows of designs, the best first, as `best`."""
        value, excess = self.values(designs, steps, within_steps=within_steps)
        worst = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        return np.lexsort((value, worst))

    def converging(self, designs: Floats) -> tuple[Floats, Floats]:
        """Times [s] and traces of designs by the scenario's rule, shape (n, 2), and violations.

        The latter of limits on the way alone.
        """
        result = evaluate(self.model, designs, self.threads)
        excesses = [each.excesses(result) for each in self.limits]
        worst = np.concatenate([*excesses, np.zeros((1, len(designs)))]).max(axis=0)
        return np.column_stack([result.t_end, result.trace]), worst


def at_time(problem: PlanProblem, name: str = "trace") -> AtTime:
    """What maneuvers of a problem are worth at any time, flown exactly."""
    return AtTime(problem.scenario, problem.model, name, problem.threads)


def judged_by(problem: PlanProblem) -> Judge:
    """Designs judged as the problem does."""

    def judge(designs: Floats) -> tuple[Floats, Floats]:
        F, G = problem.evaluate(designs, return_values_of=["F", "G"])
        return F, np.maximum(G, 0.0).max(axis=1, initial=0.0)

    return judge


def ending_at(designs: Floats, times: Floats | float, longest: float) -> Floats:
    """Designs, shape (n, 4 m), whose maneuvers are over at times, the last ones cut or held.

    No maneuver is made longer than the `longest`: a plan that has no more time left ends earlier.
    """
    found = designs.copy()
    durations = durations_of(found)
    until = np.broadcast_to(times, len(designs))[:, None]
    ends = np.minimum(np.cumsum(durations, axis=1), until)
    ends[:, -1:] = until
    durations[:] = np.minimum(np.diff(ends, axis=1, prepend=0.0), longest)
    return found


def stretched(designs: Floats, factors: Floats | float, longest: float) -> Floats:
    """Designs with all durations by factors, none of them longer than the `longest`."""
    found = designs.copy()
    durations = durations_of(found)
    by = np.broadcast_to(factors, len(designs))[:, None]
    durations[:] = np.minimum(by * durations, longest)
    return found


def slowed(designs: Floats, factors: Floats | float, longest: float, greatest: float) -> Floats:
    """Designs through the same attitudes in times by factors, where limits allow it.

    No maneuver is made longer than the `longest`, and no rate is above the `greatest` [deg/s].
    """
    found = stretched(designs, factors, longest)
    maneuvers = found.reshape(len(found), -1, VARIABLES_PER_MANEUVER)
    by = np.broadcast_to(factors, len(designs))[:, None, None]
    maneuvers[:, :, :3] = np.clip(maneuvers[:, :, :3] / by, -greatest, greatest)
    return found


def on_steps(at: AtTime, designs: Floats) -> Floats:
    """Designs, shape (n, 4 m), whose maneuvers end on the steps nearest to their ends.

    They are flown until the next ones, half a step late in the mean. Rates that change slowly begin
    on steps: nothing is changed there.
    """
    if at.model.slew_limits is not None:
        return designs
    found, step = designs.copy(), at.model.step
    durations = durations_of(found)
    ends = np.maximum(np.rint(np.cumsum(durations, axis=1) / step) - _EARLY, 0.0)
    longest = at.scenario.maneuvers.max_duration
    durations[:] = np.minimum(step * np.diff(ends, axis=1, prepend=0.0), longest)
    return found


def with_partial_steps(designs: Floats, step: float) -> Floats:
    """Designs, shape (n, 4 m), as ones that end on steps, shape (n, 4 (2 m - 1)).

    Of a plan whose maneuvers end within steps values change smoothly with it.

    In the step [s] in which one maneuver or more end the rate is the mean of theirs, as long as
    each of them is flown in it.
    """
    maneuvers = designs.reshape(len(designs), -1, VARIABLES_PER_MANEUVER)
    rates, ends = maneuvers[:, :, :3], np.cumsum(maneuvers[:, :, 3], axis=1) / step
    if ends.shape[1] == 1:
        return designs
    starts = np.hstack([np.zeros((len(ends), 1)), ends[:, :-1]])
    shared = np.floor(ends[:, :-1])  # the step in which each ends, shape (n, m - 1)
    flown = np.minimum(shared[:, :, None] + 1.0, ends[:, None]) - np.maximum(
        shared[:, :, None], starts[:, None]
    )
    flown = np.maximum(flown, 0.0)
    flown[:, :, -1] += 1.0 - flown.sum(axis=2)  # the last rate is held
    n, m = ends.shape
    found = np.empty((n, 2 * m - 1, VARIABLES_PER_MANEUVER))
    found[:, ::2, :3], found[:, 1::2, :3] = rates, flown @ rates
    until = np.empty((n, 2 * m - 1))
    until[:, :-1:2], until[:, 1::2] = shared, shared + 1.0
    until[:, -1] = np.ceil(ends[:, -1] - _EARLY)
    until = np.maximum.accumulate(until, axis=1)
    found[:, :, 3] = step * np.diff(np.maximum(until - _EARLY, 0.0), axis=1, prepend=0.0)
    return found.reshape(n, -1)
