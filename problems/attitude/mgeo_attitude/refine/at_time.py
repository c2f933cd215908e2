"""What plans are worth at a time, whatever the rule of convergence, and how that changes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.constraints import Constraint, constraints
from mgeo_attitude.criteria.objectives import objective
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.scenario import Scenario


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
        self, designs: Floats, steps: Ints | int, required: bool = False
    ) -> tuple[Floats, Floats]:
        """Value, shape (n,), and excess over each limit, shape (n, k), after so many steps.

        A design without a value has an infinite one. Limits are those on the way and, where they
        are `required`, those of the end.
        """
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

    def best(self, designs: Floats, steps: int) -> int:
        """The row of least value among those that keep the limits on the way, or else most so."""
        value, excess = self.values(designs, steps)
        worst = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        return int(np.lexsort((value, worst))[0])

    def by_convergence(self, designs: Floats) -> tuple[Ints, Floats]:
        """Rows in the order in which they converge by the scenario's rule, and their traces.

        Those come first that break limits on the way least, and of these the soonest; of several
        that of the least trace.
        """
        result = evaluate(self.model, designs, self.threads)
        excesses = [each.excesses(result) for each in self.limits]
        worst = np.concatenate([*excesses, np.zeros((1, len(designs)))]).max(axis=0)
        return np.lexsort((result.trace, result.t_end, worst)), result.trace


def ending_at(design: Floats, time: float, longest: float) -> Floats:
    """A design, shape (4 m,), whose maneuvers are over at a time, the last one cut or held.

    No maneuver is made longer than the `longest`: a plan that has no more time left ends earlier.
    """
    maneuvers = design.reshape(-1, VARIABLES_PER_MANEUVER).copy()
    ends = np.minimum(np.cumsum(maneuvers[:, 3]), time)
    ends[-1] = time
    maneuvers[:, 3] = np.minimum(np.diff(ends, prepend=0.0), longest)
    return maneuvers.ravel()


def stretched(design: Floats, factor: float, longest: float) -> Floats:
    """A design with all durations by a factor, none of them longer than the `longest`."""
    maneuvers = design.reshape(-1, VARIABLES_PER_MANEUVER).copy()
    maneuvers[:, 3] = np.minimum(factor * maneuvers[:, 3], longest)
    return maneuvers.ravel()


def slowed(design: Floats, factor: float, longest: float, greatest: float) -> Floats:
    """A design through the same attitudes in a time by a factor, where limits allow it.

    No maneuver is made longer than the `longest`, and no rate is above the `greatest` [deg/s].
    """
    maneuvers = stretched(design, factor, longest).reshape(-1, VARIABLES_PER_MANEUVER)
    maneuvers[:, :3] = np.clip(maneuvers[:, :3] / factor, -greatest, greatest)
    return maneuvers.ravel()
