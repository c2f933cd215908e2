"""What a filter run needs of a scenario, as arrays: the same for every design."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .._typing import Bools, Floats
from ..environment import Environment
from ..environment.pointing import Place
from ..maneuvers.schedule import Schedule, schedule
from ..maneuvers.slew import SlewLimits
from ..scenario.settings import RequiredSigma, TraceWeights
from .layout import Monitors
from .suite import Suite

if TYPE_CHECKING:
    from ..scenario import Scenario


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
        The run has converged when the trace fell by less than this fraction over the window, and
        did not rise.
    allow_rise : bool
        Whether it has converged, too, when the trace rose.
    rule : {"trace", "required", "settling"}
        Whether that is the rule at all, or the end of a run tells from when on it was converged.
    factor : float
        Within which of its last value a trace has settled.
    initial_attitude : array, shape (3, 3)
        GCRS to body at the start.
    initial_rate : array, shape (3,)
        Body rate before the first maneuver [rad/s]; the ramps of `slew_limits` begin at it.
    slew_limits : SlewLimits, optional
        How fast rates can change; without it they change at once.
    cones : array, shape (n_cones, 3)
        Body axes that must stay off the Sun, unit vectors.
    cone_sigmas : array, shape (n_cones,)
        By how many 1-sigmas of the angle between more than they must.
    sun : array, shape (n_steps + 1, 3) or (0, 3)
        Direction to the Sun where it shines, else zero, GCRS; empty if no axis is watched.
    required_sigma : array, shape (n_states,)
        1-sigma that a plan must reach; infinite for a state without requirement.
    """

    suite: Suite
    step: float
    references: Floats
    available: Bools
    initial_sigma: Floats
    weights: Floats
    window_steps: int
    relative_decrease: float
    allow_rise: bool
    rule: str
    factor: float
    initial_attitude: Floats
    initial_rate: Floats
    slew_limits: SlewLimits | None
    cones: Floats
    cone_sigmas: Floats
    sun: Floats
    required_sigma: Floats

    @classmethod
    def from_scenario(
        cls, scenario: Scenario, environment: Environment | None = None
    ) -> FilterModel:
        """Build the tables; `environment` saves computing it again.

        Raises
        ------
        ValueError
            If `environment` is of another orbit, epoch, duration or step, or what is pointed at
            at the start leaves the clock angle open.
        """
        if environment is None:
            environment = Environment.from_scenario(scenario)
        else:
            environment.require(scenario)
        if not scenario.eclipse:
            environment = environment.without_shadow()
        suite = Suite(scenario.gyro, scenario.sensors)
        references, available = inertial_vectors(suite, environment)
        weights = np.repeat(TraceWeights(scenario.trace_weights).of(suite.blocks), 3)
        required = RequiredSigma(scenario.required_sigma)
        cones = np.array([cone.axis() for cone in scenario.keep_outs]).reshape(-1, 3)
        sun = environment.sun * environment.sunlit[:, None]
        start = Place(
            environment.position[:1],
            environment.velocity[:1],
            environment.sun[:1],
            environment.sunlit[:1],
        )
        initial_rate = scenario.initial.rate(start)
        return cls(
            suite=suite,
            step=scenario.step,
            references=references,
            available=available,
            initial_sigma=suite.initial_sigma(np.radians(scenario.initial.attitude_deg)),
            weights=weights,
            window_steps=round(scenario.convergence.window / scenario.step),
            relative_decrease=scenario.convergence.relative_decrease,
            allow_rise=scenario.convergence.allow_rise,
            rule=scenario.convergence.rule,
            factor=scenario.convergence.factor,
            initial_attitude=scenario.initial.attitude(start)[0],
            initial_rate=initial_rate,
            slew_limits=SlewLimits.of(scenario, initial_rate),
            cones=cones,
            cone_sigmas=np.array(
                [cone.attitude_sigmas for cone in scenario.keep_outs], dtype=float
            ),
            sun=sun if len(cones) else np.zeros((0, 3)),
            required_sigma=np.repeat(required.of(suite.units), 3),
        )

    @property
    def n_steps(self) -> int:
        return len(self.references) - 1

    @property
    def endless(self) -> FilterModel:
        """The same filter, run for the whole duration: its window is longer than that."""
        return dataclasses.replace(self, window_steps=self.n_steps + 1, rule="trace")

    @property
    def times(self) -> Floats:
        """Sample times [s], shape (n_steps + 1,)."""
        times: Floats = self.step * np.arange(self.n_steps + 1, dtype=float)
        return times

    @property
    def monitors(self) -> Monitors:
        """What is watched along a run."""
        states = np.flatnonzero(self.required_sigma < np.inf)
        margins = tuple(bool(sigmas > 0.0) for sigmas in self.cone_sigmas)
        return Monitors(margins, tuple(int(state) for state in states))

    @cached_property
    def table(self) -> Floats:
        """What a filter step needs of the orbit, side by side at every sample.

        The references; if an axis is watched, the Sun; and whether each gated sensor is available.
        """
        parts = [self.references.reshape(len(self.references), -1)]
        if len(self.cones):
            parts.append(self.sun)
        return np.hstack([*parts, self.available[:, self.gated]])

    @cached_property
    def dynamics(self) -> Floats:
        """A at rest, and what a unit rate about each axis adds, shape (4, n_dynamic, n_dynamic)."""
        rest, *unit = map(self.suite.dynamics_matrix, np.vstack([np.zeros(3), np.eye(3)]))
        return np.array([rest, *(matrix - rest for matrix in unit)])

    def schedule(self, designs: ArrayLike) -> Schedule:
        """What is flown of designs, shape (n, 4 m)."""
        return schedule(designs, self.step, self.slew_limits, self.n_steps)

    @property
    def gated(self) -> tuple[bool, ...]:
        """Which sensors are not available at every sample."""
        return tuple(bool(column.any()) for column in ~self.available.T)


def inertial_vectors(suite: Suite, environment: Environment) -> tuple[Floats, Bools]:
    """`FilterModel.references` and `FilterModel.available` of all samples."""
    n = len(environment.times)
    references = np.zeros((n, len(suite.sensors), 3))
    available = np.ones((n, len(suite.sensors)), dtype=bool)
    for index, sensor in enumerate(suite.sensors):
        reference, mask = sensor.inertial_vector(environment), sensor.available(environment)
        if reference is not None:
            references[:, index] = reference
        if mask is not None:
            available[:, index] = mask
    return references, available
