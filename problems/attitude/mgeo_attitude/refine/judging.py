"""What the parts of this room need of a problem, and how designs are judged by it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.start_times import StartTimes
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.at_time import AtTime
from mgeo_attitude.scenario import Scenario

#: Objectives and constraint violations, the latter 0 where all is kept, shapes (n, k) and (n,).
Judge = Callable[[Floats], tuple[Floats, Floats]]


class PlanProblem(Protocol):
    """A problem whose designs are maneuvers of one scenario."""

    scenario: Scenario
    threads: int | None
    objectives: tuple[str, ...]

    def evaluate(self, X: Any, *args: Any, **kwargs: Any) -> Any: ...
    def begun(self, x: Any) -> tuple[PlanProblem, Floats]: ...
    @property
    def model(self) -> FilterModel: ...
    @property
    def start_times(self) -> StartTimes | None: ...


def parts(problem: PlanProblem, designs: Floats) -> tuple[Floats, Floats]:
    """Maneuvers, shape (n, 4 m), and starts, shape (n, 1), or (n, 0) where they are not free."""
    at = VARIABLES_PER_MANEUVER * problem.scenario.maneuvers.count
    return designs[:, :at], designs[:, at:]


def begins_with(maneuvers: Floats, start: Floats) -> Floats:
    """Designs of maneuvers, shape (n, 4 m), that have a start, shape (1,) or (0,)."""
    return np.hstack([maneuvers, np.tile(start, (len(maneuvers), 1))])


def at_time(problem: PlanProblem, name: str = "trace", start: Floats | None = None) -> AtTime:
    """What maneuvers of a problem are worth at any time from a start on, flown exactly."""
    own = problem
    if start is not None and start.size:
        none = np.zeros(VARIABLES_PER_MANEUVER * problem.scenario.maneuvers.count)
        own, _ = problem.begun(np.append(none, start))
    return AtTime(own.scenario, own.model, name, problem.threads)


def judged_by(problem: PlanProblem) -> Judge:
    """Designs judged as the problem does."""

    def judge(designs: Floats) -> tuple[Floats, Floats]:
        F, G = problem.evaluate(designs, return_values_of=["F", "G"])
        return F, np.maximum(G, 0.0).max(axis=1, initial=0.0)

    return judge
