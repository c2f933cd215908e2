"""What a filter run needs of a scenario, as arrays: the same for every design."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..environment import Environment
from ..scenario.settings import TraceWeights
from .suite import Suite

if TYPE_CHECKING:
    from ..scenario import Scenario

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FilterModel:
    """A sensor suite along an orbit, with initial uncertainty and convergence rule.

    Attributes
    ----------
    suite : Suite
    step : float
        Filter step [s].
    references : array, shape (n_steps + 1, n_sensors, 3)
        Vector that each sensor looks at, GCRS; zero for one that looks at none.
    available : array of bool, shape (n_steps + 1, n_sensors)
        Whether each sensor can measure at each sample, apart from its field of view.
    initial_sigma : array, shape (n_states,)
    weights : array, shape (n_states,)
        Weight of each state's variance in the trace.
    window_steps : int
        Convergence window [steps].
    relative_decrease : float
        The run has converged when the trace fell by less than this fraction over the window.
    """

    suite: Suite
    step: float
    references: Floats
    available: NDArray[np.bool_]
    initial_sigma: Floats
    weights: Floats
    window_steps: int
    relative_decrease: float

    @classmethod
    def from_scenario(
        cls, scenario: Scenario, environment: Environment | None = None
    ) -> FilterModel:
        """Build the tables; `environment` saves computing it again."""
        environment = environment or Environment.from_scenario(scenario)
        if not scenario.eclipse:
            sunlit = np.ones_like(environment.sunlit)
            environment = dataclasses.replace(environment, sunlit=sunlit)
        suite = Suite(scenario.gyro, scenario.sensors)
        n = len(environment.times)
        references = np.zeros((n, len(suite.sensors), 3))
        available = np.ones((n, len(suite.sensors)), dtype=bool)
        for index, sensor in enumerate(suite.sensors):
            reference, mask = sensor.reference(environment), sensor.available(environment)
            if reference is not None:
                references[:, index] = reference
            if mask is not None:
                available[:, index] = mask
        weights = np.repeat(TraceWeights(scenario.trace_weights).of(suite.blocks), 3)
        return cls(
            suite=suite,
            step=scenario.step,
            references=references,
            available=available,
            initial_sigma=suite.initial_sigma(np.radians(scenario.initial.attitude_deg)),
            weights=weights,
            window_steps=round(scenario.convergence.window / scenario.step),
            relative_decrease=scenario.convergence.relative_decrease,
        )

    @property
    def n_steps(self) -> int:
        return len(self.references) - 1

    @property
    def times(self) -> Floats:
        """Sample times [s], shape (n_steps + 1,)."""
        times: Floats = self.step * np.arange(self.n_steps + 1, dtype=float)
        return times

    @property
    def gated(self) -> tuple[bool, ...]:
        """Which sensors are not available at every sample."""
        return tuple(bool(column.any()) for column in ~self.available.T)
