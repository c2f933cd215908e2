"""What a filter run needs of a scenario, as arrays: the same for every design."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.directions import Passage, Place, directions, radii
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.codegen import instrument_constants
from mgeo_attitude.filter.layout import (
    Monitors,
    Traits,
    Watch,
    directions_of,
    is_disc,
    slopes,
    viewed_directions,
    watched_directions,
)
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.maneuvers.drives import CoilDrive
from mgeo_attitude.maneuvers.schedule import Schedule, Turning, schedule
from mgeo_attitude.scenario.channels import channel_values
from mgeo_attitude.scenario.goals import RequiredSigma, TraceWeights
from mgeo_attitude.scenario.limits import PathLimit
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.suite import Suite


@dataclass(frozen=True)
class FilterModel:
    """A sensor suite along an orbit, with initial uncertainty and convergence rule.

    Attributes
    ----------
    suite : Suite
    step : float
        Filter step [s].
    references : array, shape (n_steps + 1, n_vectors, 3)
        Vector that each sensor looks at, GCRS, zero for one that looks at none; then the columns
        of their gradients, see `Suite.gradient_rows`.
    available : array of bool, shape (n_steps + 1, n_sensors)
        Whether each sensor can measure at each sample, apart from its field of view.
    initial_sigma : array, shape (n_states,)
    initial_correlation : array, shape (n_states, n_states)
        Of the errors at the start; the identity unless a calibration has been before.
    initial_states : array, shape (n_states,)
        What is believed of gyro and sensors then, rotations as vectors of `rotation.rotate`; zero
        unless a calibration has been before. It does not enter the covariance.
    weights : array, shape (n_states,)
        Weight of each state's variance in the trace.
    window_steps : int
        Convergence window [steps].
    relative_decrease : float
        The run has converged when the trace fell by less than this fraction over the window, and
        did not rise.
    allow_rise : bool
        Whether it has converged, too, when the trace rose.
    rule : {"trace", "required", "settling", "end"}
        Whether that is the rule at all, or the end of a run tells from when on it was converged, or
        a run ends with the last maneuver.
    factor : float
        Within which of its last value a trace has settled.
    initial_attitude : array, shape (3, 3)
        GCRS to body at the start.
    initial_rate : array, shape (3,)
        Body rate before the first maneuver [rad/s]; the ramps of `slew_limits` begin at it.
    slew_limits : SlewLimits or CoilDrive, optional
        How fast rates can change, or what coils make of them; without it they change at once.
    path_limits : tuple of PathLimit
    directions : array, shape (n_steps + 1, n_directions, 3)
        Unit vectors that path limits and views of sensors look at, in the order of
        `layout.directions_of`, GCRS; zero where there is nothing to be seen: of the Sun, in
        eclipse.
    radii : array, shape (n_steps + 1, n_directions)
        Their apparent radii [rad]; zero for what is no disc.
    budget : MomentumBudget, optional
        Of wheels whose load does not follow from the rates alone.
    required_sigma : array, shape (n_states,)
        1-sigma that a plan must reach; infinite for a state without requirement.
    channels : mapping of str to array, shape (n_steps + 1,)
        Values of what biases follow.
    by_polynomials : bool
        Whether transitions are those of `polynomials` where they can be, which differ from others
        by rounding and take a ninth of the time.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario
    >>> model = FilterModel.from_scenario(Scenario.paper())
    >>> model.references.shape, model.step, model.initial_sigma.shape
    ((11985, 2, 3), 1.0, (18,))
    """

    suite: Suite
    step: float
    references: Floats
    available: Bools
    initial_sigma: Floats
    initial_correlation: Floats
    initial_states: Floats
    weights: Floats
    window_steps: int
    relative_decrease: float
    allow_rise: bool
    rule: str
    factor: float
    initial_attitude: Floats
    initial_rate: Floats
    slew_limits: Turning
    path_limits: tuple[PathLimit, ...]
    directions: Floats
    radii: Floats
    budget: MomentumBudget | None
    required_sigma: Floats
    channels: Mapping[str, Floats]
    by_polynomials: bool = False

    @classmethod
    def from_scenario(
        cls,
        scenario: Scenario,
        environment: Environment | None = None,
        epoch: datetime | None = None,
    ) -> FilterModel:
        """Build the tables; `environment` saves computing it again.

        Its times count from `epoch`, if not from the scenario's.

        Raises
        ------
        ValueError
            If `environment` is of another orbit, epoch, duration or step, what is pointed at
            at the start leaves the clock angle open, or an influence is of no channel.
        """
        if environment is None:
            environment = Environment.from_scenario(scenario)
        else:
            environment.require(scenario)
        if not scenario.eclipse:
            environment = environment.without_shadow()
        suite = scenario.suite
        references, available = inertial_vectors(suite, environment)
        for index, sensor in enumerate(suite.sensors):
            available[:, index] &= sampled(sensor, scenario.step, len(available))
        weights = TraceWeights(scenario.trace_weights).of(suite.blocks, suite.uncalibrated)
        required = RequiredSigma(scenario.required_sigma)
        watches = tuple(map(Watch.of, scenario.path_limits))
        names = directions_of(suite, Monitors(watches))
        start, prior = Place.row(environment), scenario.prior
        attitude, rate = scenario.initial_attitude(start), scenario.initial_rate(start)
        sigma = suite.initial_sigma(np.radians(scenario.initial.attitude_deg))
        return cls(
            suite=suite,
            step=scenario.step,
            references=references,
            available=available,
            initial_sigma=sigma if prior is None else prior.sigma,
            initial_correlation=suite.initial_correlation if prior is None else prior.correlation,
            initial_states=np.zeros_like(sigma) if prior is None else prior.estimates,
            weights=np.repeat(weights, 3),
            window_steps=round(scenario.convergence.window / scenario.step),
            relative_decrease=scenario.convergence.relative_decrease,
            allow_rise=scenario.convergence.allow_rise,
            rule=scenario.convergence.rule,
            factor=scenario.convergence.factor,
            initial_attitude=attitude,
            initial_rate=rate,
            slew_limits=scenario.turning(environment.field_tesla, attitude, rate),
            path_limits=scenario.path_limits,
            directions=directions(names, environment, epoch or scenario.epoch),
            radii=radii(names, environment),
            budget=MomentumBudget.of(scenario, environment, attitude, rate),
            required_sigma=np.repeat(required.of(suite.units), 3),
            channels=channel_values(
                scenario.channels, suite, environment.times, environment.sunlit
            ),
        )

    def turned(self, turn: Floats) -> FilterModel:
        """The same from another attitude: at the start body axes are off by `turn`.

        They are those of ``turn @ initial_attitude.T``, column by column, in axes of GCRS.
        """
        limits = self.slew_limits
        return dataclasses.replace(
            self,
            slew_limits=limits.turned(turn) if isinstance(limits, CoilDrive) else limits,
            references=self.references @ turn,
            directions=(self.directions.reshape(-1, 3) @ turn).reshape(self.directions.shape),
            budget=self.budget and self.budget.turned(turn),
        )

    @property
    def n_steps(self) -> int:
        return len(self.references) - 1

    @property
    def longest(self) -> float:
        """The t_end of a run that does not converge [s]."""
        return self.n_steps * self.step

    @property
    def ends_by_design(self) -> bool:
        """Whether a run ends with the last maneuver, and no filter is waited for."""
        return self.rule == "end"

    @property
    def too_late(self) -> float:
        """The t_end from which on a run has not converged [s]; infinite where none has to."""
        return np.inf if self.ends_by_design else self.longest

    @cached_property
    def endless(self) -> FilterModel:
        """The same filter, run for the whole duration: its window is longer than that."""
        return dataclasses.replace(self, window_steps=self.n_steps + 1, rule="trace")

    @cached_property
    def unending(self) -> FilterModel:
        """The same filter, which no trace stops."""
        # within one step no trace falls by less than nothing
        return dataclasses.replace(
            self, window_steps=1, relative_decrease=0.0, allow_rise=False, rule="trace"
        )

    @property
    def initial_covariance(self) -> Floats:
        """Of the errors at the start, shape (n_states, n_states)."""
        sigma = self.initial_sigma
        return sigma[:, None] * self.initial_correlation * sigma

    def at_samples(self, samples: slice, **changes: Any) -> FilterModel:
        """The same with the tables of some samples, and with other changes."""

        def some(table: NDArray[Any]) -> NDArray[Any]:
            return np.ascontiguousarray(table[samples])

        tables: dict[str, Any] = {
            "references": some(self.references),
            "available": some(self.available),
            "directions": some(self.directions),
            "radii": some(self.radii),
            "channels": {name: some(values) for name, values in self.channels.items()},
        }
        return dataclasses.replace(self, **(tables | changes))

    @property
    def times(self) -> Floats:
        """Sample times [s], shape (n_steps + 1,)."""
        return self.step * np.arange(self.n_steps + 1, dtype=float)

    @cached_property
    def influences(self) -> Floats:
        """What the suite's influences are times; see `Suite.influence_values`."""
        return self.suite.influence_values(self.channels, len(self.references))

    @cached_property
    def monitors(self) -> Monitors:
        """What is watched along a run."""
        states = np.flatnonzero(self.required_sigma < np.inf)
        watches = tuple(map(Watch.of, self.path_limits))
        return Monitors(watches, tuple(int(state) for state in states))

    def direction(self, name: str, samples: slice = slice(None)) -> tuple[Floats, Floats]:
        """One of `directions`, shape (n, 3), and its radius, shape (n,)."""
        index = directions_of(self.suite, self.monitors).index(name)
        return self.directions[samples, index], self.radii[samples, index]

    def passage(self, name: str, samples: slice = slice(None)) -> Passage:
        """The same in the steps that lead to these samples, of which the first has none."""
        return Passage.of(*self.direction(name, samples))

    @cached_property
    def table(self) -> Floats:
        """What a filter step needs of the orbit, side by side at every sample.

        See `layout.given_columns`.
        """
        parts = [self.references.reshape(len(self.references), -1)]
        for name in watched_directions(self.monitors):
            passage = self.passage(name)
            parts += [
                passage.after,
                passage.after - passage.before,
                passage.appears[:, None].astype(float),
            ]
            if is_disc(name):
                radius, before = passage.radius_after, passage.radius_before
                parts += [radius[:, None], (radius - before)[:, None]]
        for name in viewed_directions(self.suite):
            vectors, at = self.direction(name)
            parts.append(vectors)
            if is_disc(name):
                parts += [np.cos(at)[:, None], np.sin(at)[:, None]]
        return np.hstack([*parts, self.influences, self.available[:, self.gated]])

    @cached_property
    def traits(self) -> Traits:
        """What its kernel is made for."""
        limits = [(watch.direction, watch.inside) for watch in self.monitors.limits]
        views = [view for sensor in self.suite.sensors for view in sensor.views()]
        return Traits(
            self.suite.blocks,
            tuple(self.suite.considered.tolist()),
            (*limits, *((view.direction, view.inside) for view in views)),
            len(self.instrument_constants),
            tuple(slopes(sensor, self.suite.world) for sensor in self.suite.sensors),
        )

    @cached_property
    def instrument_constants(self) -> Floats:
        """Those of a filter step; see `codegen.instrument_constants`."""
        return instrument_constants(self.suite, self.step, self.path_limits)

    def schedule(self, designs: ArrayLike, n_steps: int | None = None) -> Schedule:
        """What is flown of designs, shape (n, 4 m), until the end or step `n_steps`."""
        last = self.n_steps if n_steps is None else n_steps
        return schedule(designs, self.step, self.slew_limits, last)

    @cached_property
    def gated(self) -> tuple[bool, ...]:
        """Which sensors are not available at every sample."""
        return tuple(bool(column.any()) for column in ~self.available.T)


def sampled(sensor: Sensor, step: float, n: int) -> Bools:
    """At which of n samples, one every `step` [s], a sensor has one."""
    every = 1 if sensor.sample_interval is None else round(sensor.sample_interval / step)
    samples: Bools = np.arange(n) % every == 0
    return samples


def inertial_vectors(suite: Suite, environment: Environment) -> tuple[Floats, Bools]:
    """`FilterModel.references` and `FilterModel.available` of all samples, at whatever interval."""
    n, environment = len(environment.times), suite.world.around(environment)
    references = np.zeros((n, suite.n_vectors, 3))
    for index, sensor in enumerate(suite.sensors):
        reference = sensor.inertial_vector(environment)
        if reference is not None:
            references[:, index] = reference
        references[:, suite.gradient_rows(index)] = suite.gradient(sensor, environment)
    return references, availability(suite, environment)


def availability(suite: Suite, environment: Environment) -> Bools:
    """Where each of s sensors has something to measure, whatever the attitude, shape (n, s)."""
    there = np.ones((len(environment.times), len(suite.sensors)), dtype=bool)
    for column, sensor in zip(there.T, suite.sensors, strict=True):
        mask = sensor.available(environment)
        if mask is not None:
            column[:] = mask
    return there
