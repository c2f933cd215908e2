"""What the parts of this room need of a problem, and how designs are judged by it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
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
    @property
    def model(self) -> FilterModel: ...


def at_time(problem: PlanProblem, name: str = "trace") -> AtTime:
    """What designs of a problem are worth at any time, flown exactly."""
    return AtTime(problem.scenario, problem.model, name, problem.threads)


def judged_by(problem: PlanProblem) -> Judge:
    """Designs judged as the problem does."""

    def judge(designs: Floats) -> tuple[Floats, Floats]:
        F, G = problem.evaluate(designs, return_values_of=["F", "G"])
        return F, np.maximum(G, 0.0).max(axis=1, initial=0.0)

    return judge
