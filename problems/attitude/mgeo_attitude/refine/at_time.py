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

    def best(self, designs: Floats, steps: int, most: int) -> Floats:
        """So many of the designs, the best first: least values after those that keep limits most.

        Limits are those on the way.
        """
        found: Floats = designs[self.order(designs, steps)[:most]]
        return found

    def order(self, designs: Floats, steps: Ints | int) -> Ints:
        """Rows of designs, the best first, as `best`."""
        value, excess = self.values(designs, steps)
        worst = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        return np.lexsort((value, worst))

    def soonest(self, designs: Floats) -> tuple[Ints, Floats]:
        """Rows of the designs that converge the soonest, and when [s]: by the scenario's rule.

        Of those that break limits on the way least, each that knows more than all that converge
        sooner; at least one.
        """
        result = evaluate(self.model, designs, self.threads)
        excesses = [each.excesses(result) for each in self.limits]
        worst = np.concatenate([*excesses, np.zeros((1, len(designs)))]).max(axis=0)
        order = np.lexsort((result.trace, result.t_end, worst))
        least = np.minimum.accumulate(np.nan_to_num(result.trace[order], nan=np.inf))
        rows: Ints = order[np.diff(least, prepend=np.inf) < 0.0]
        rows = rows if len(rows) else order[:1]
        return rows, result.t_end[rows]


def ending_at(designs: Floats, times: Floats | float, longest: float) -> Floats:
    """Designs, shape (n, 4 m), whose maneuvers are over at times, the last ones cut or held.

    No maneuver is made longer than the `longest`: a plan that has no more time left ends earlier.
    """
    found = designs.copy()
    durations = found[:, VARIABLES_PER_MANEUVER - 1 :: VARIABLES_PER_MANEUVER]
    until = np.broadcast_to(times, len(designs))[:, None]
    ends = np.minimum(np.cumsum(durations, axis=1), until)
    ends[:, -1:] = until
    durations[:] = np.minimum(np.diff(ends, axis=1, prepend=0.0), longest)
    return found


def stretched(designs: Floats, factors: Floats | float, longest: float) -> Floats:
    """Designs with all durations by factors, none of them longer than the `longest`."""
    found = designs.copy()
    durations = found[:, VARIABLES_PER_MANEUVER - 1 :: VARIABLES_PER_MANEUVER]
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
