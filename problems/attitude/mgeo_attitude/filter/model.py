"""Inputs of the covariance filter that follow from the scenario and not from the design.

The compiled filter, the reference filter, the lower bound and the local refinement use the model.
"""

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
from mgeo_attitude.environment.directions import (
    DirectionMotion,
    SatelliteState,
    compute_directions,
    compute_radii,
)
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.codegen import compute_instrument_constants
from mgeo_attitude.filter.layout import (
    KernelTraits,
    Monitors,
    PathMonitor,
    is_disc,
    list_directions,
    list_path_directions,
    list_view_directions,
    serialize_measurement_matrix,
)
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive
from mgeo_attitude.maneuvers.schedule import RotationDynamics, Schedule, build_schedule
from mgeo_attitude.scenario.constraints import PathConstraint
from mgeo_attitude.scenario.criteria import RequiredSigma, TraceWeights
from mgeo_attitude.scenario.housekeeping import compute_channel_values
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.suite import Suite


@dataclass(frozen=True)
class FilterModel:
    """Scenario-dependent inputs of the covariance filter, such as sensors and orbit tables.

    Attributes
    ----------
    suite : Suite
        Gyro and sensors.
    step : float
        Filter step [s].
    references : array, shape (n_steps + 1, n_vectors, 3)
        Reference vector of each sensor in GCRS, zero for a sensor without a vector; then the
        auxiliary vectors of the sensors, see `Suite.find_auxiliary_rows`.
    available : array of bool, shape (n_steps + 1, n_sensors)
        Whether each sensor can measure at each sample if its field-of-view and rate conditions are
        satisfied.
    initial_sigma : array, shape (n_states,)
        Initial 1-sigmas.
    initial_correlation : array, shape (n_states, n_states)
        Correlation of the initial errors; the identity without an earlier calibration.
    initial_states : array, shape (n_states,)
        Initial estimates of the calibration parameters; zero without an earlier calibration.
        Rotations are vectors as in `geometry.rotation`. The covariance does not depend on them.
    weights : array, shape (n_states,)
        Weight of each state's variance in the trace.
    window_steps : int
        Convergence window [steps].
    relative_decrease : float
        A run has converged when the trace of the covariance fell by less than this fraction over
        the window and did not rise.
    allow_rise : bool
        Whether a run has also converged when the trace rose over the window.
    rule : {"trace", "required", "settling", "end"}
        End of a run: when the trace has converged ("trace"); when all required 1-sigmas are
        satisfied for the rest of the scenario ("required"); when the trace stays below
        `settling_factor` times its final value ("settling"); or with the last maneuver ("end").
    settling_factor : float
        Factor of the rule "settling".
    initial_attitude : array, shape (3, 3)
        GCRS-to-body matrix at the start.
    initial_rate : array, shape (3,)
        Body rate before the first maneuver [rad/s], from which the first ramp starts.
    slew_limits : SlewLimits or MagnetorquerDrive, optional
        Limits on rate changes, or a model of magnetorquer control. Without either, rates change
        instantly.
    path_constraints : tuple of PathConstraint
        Path constraints.
    directions : array, shape (n_steps + 1, n_directions, 3)
        Unit vectors of path constraints and fields of view in GCRS, in the order of
        `layout.list_directions`; zero where not visible, such as the Sun in eclipse.
    radii : array, shape (n_steps + 1, n_directions)
        Apparent radii of the directions [rad]; zero for a direction that is not a disc.
    momentum_budget : MomentumBudget, optional
        Inputs of the wheel loads; None if the loads follow from the rates alone.
    required_sigma : array, shape (n_states,)
        1-sigma that a plan must reach; infinite for a state without requirement.
    channels : mapping of str to array, shape (n_steps + 1,)
        Values of the housekeeping channels on which biases depend.
    use_polynomials : bool
        Whether to discretize with `filter.polynomials` where possible. The method is nine times as
        fast as the default and differs by rounding.

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
    settling_factor: float
    initial_attitude: Floats
    initial_rate: Floats
    slew_limits: RotationDynamics
    path_constraints: tuple[PathConstraint, ...]
    directions: Floats
    radii: Floats
    momentum_budget: MomentumBudget | None
    required_sigma: Floats
    channels: Mapping[str, Floats]
    use_polynomials: bool = False

    @classmethod
    def from_scenario(
        cls,
        scenario: Scenario,
        environment: Environment | None = None,
        epoch: datetime | None = None,
    ) -> FilterModel:
        """Build the filter model of a scenario.

        Parameters
        ----------
        scenario : Scenario
        environment : Environment, optional
            Environment of the scenario, if already computed.
        epoch : datetime, optional
            Time from which the times of `environment` count. Default: the scenario's epoch.

        Raises
        ------
        ValueError
            If `environment` has another orbit, epoch, duration or step than the scenario, the
            initial pointing does not determine the clock angle, or a bias sensitivity refers
            to an undefined housekeeping channel.
        """
        if environment is None:
            environment = Environment.from_scenario(scenario)
        else:
            environment.validate_scenario(scenario)
        if not scenario.eclipse:
            environment = environment.without_eclipses()
        suite = scenario.suite
        references, available = compute_references(suite, environment)
        for index, sensor in enumerate(suite.sensors):
            available[:, index] &= find_sample_instants(sensor, scenario.step, len(available))
        weights = TraceWeights(scenario.trace_weights).list_weights(
            suite.blocks, suite.uncalibrated_blocks
        )
        required = RequiredSigma(scenario.required_sigma)
        path_monitors = tuple(map(PathMonitor.from_constraint, scenario.path_constraints))
        names = list_directions(suite, Monitors(path_monitors))
        initial_state, prior = SatelliteState.from_first_instant(environment), scenario.prior
        attitude, rate = (
            scenario.compute_initial_attitude(initial_state),
            scenario.compute_initial_rate(initial_state),
        )
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
            settling_factor=scenario.convergence.factor,
            initial_attitude=attitude,
            initial_rate=rate,
            slew_limits=scenario.build_rotation_dynamics(environment.field_tesla, attitude, rate),
            path_constraints=scenario.path_constraints,
            directions=compute_directions(names, environment, epoch or scenario.epoch),
            radii=compute_radii(names, environment),
            momentum_budget=MomentumBudget.from_scenario(scenario, environment, attitude, rate),
            required_sigma=np.repeat(required.list_sigmas(suite.units), 3),
            channels=compute_channel_values(
                scenario.housekeeping_channels, suite, environment.times, environment.sunlit
            ),
        )

    def rotate_initial_attitude(self, rotation: Floats) -> FilterModel:
        """Return a copy of the model with a rotated initial attitude.

        The argument is a rotation matrix in GCRS, shape (3, 3). The attribute `initial_attitude`
        stays unchanged, and all GCRS vectors are rotated by the inverse instead. The new initial
        body axes in GCRS are the columns of ``rotation @ initial_attitude.T``.
        """
        limits = self.slew_limits
        return dataclasses.replace(
            self,
            slew_limits=limits.rotate(rotation)
            if isinstance(limits, MagnetorquerDrive)
            else limits,
            references=self.references @ rotation,
            directions=(self.directions.reshape(-1, 3) @ rotation).reshape(self.directions.shape),
            momentum_budget=self.momentum_budget
            and self.momentum_budget.rotate_initial_attitude(rotation),
        )

    @property
    def n_steps(self) -> int:
        return len(self.references) - 1

    @property
    def duration(self) -> float:
        """Duration of the scenario [s], after which a run stops even without convergence."""
        return self.n_steps * self.step

    @property
    def ends_with_last_maneuver(self) -> bool:
        """True if each run ends with its last maneuver, even without convergence."""
        return self.rule == "end"

    @property
    def nonconvergence_time(self) -> float:
        """End time [s] of a run that does not converge.

        The end time is the scenario's duration, or infinity if every run ends with its last
        maneuver.
        """
        return np.inf if self.ends_with_last_maneuver else self.duration

    @cached_property
    def full_duration_model(self) -> FilterModel:
        """Copy of the model that runs to the end of the scenario, without a convergence test."""
        return dataclasses.replace(self, window_steps=self.n_steps + 1, rule="trace")

    @cached_property
    def nonconverging_model(self) -> FilterModel:
        """Copy of the model that never converges, for runs that end at a given step."""
        # A trace that does not rise cannot fall by less than zero, so the rule is never satisfied.
        return dataclasses.replace(
            self, window_steps=1, relative_decrease=0.0, allow_rise=False, rule="trace"
        )

    @property
    def initial_covariance(self) -> Floats:
        """Covariance matrix of the initial errors, shape (n_states, n_states)."""
        sigma = self.initial_sigma
        return sigma[:, None] * self.initial_correlation * sigma

    def select_samples(self, samples: slice, **changes: Any) -> FilterModel:
        """Return a copy of the model that is restricted to a slice of the samples.

        Keyword arguments replace further attributes of the model.
        """

        def select_rows(table: NDArray[Any]) -> NDArray[Any]:
            return np.ascontiguousarray(table[samples])

        tables: dict[str, Any] = {
            "references": select_rows(self.references),
            "available": select_rows(self.available),
            "directions": select_rows(self.directions),
            "radii": select_rows(self.radii),
            "channels": {name: select_rows(values) for name, values in self.channels.items()},
        }
        return dataclasses.replace(self, **(tables | changes))

    @property
    def times(self) -> Floats:
        """Times of the filter samples [s], shape (n_steps + 1,)."""
        return self.step * np.arange(self.n_steps + 1, dtype=float)

    @cached_property
    def sensitivity_factors(self) -> Floats:
        """Deviation of each housekeeping value, such as a temperature, from its reference value.

        The array has shape (n_steps + 1, n_sensitivities), with one column per bias sensitivity.
        """
        return self.suite.compute_channel_deviations(self.channels, len(self.references))

    @cached_property
    def monitors(self) -> Monitors:
        """Path constraints and required 1-sigmas that the compiled filter checks in every step."""
        states = np.flatnonzero(self.required_sigma < np.inf)
        path_monitors = tuple(map(PathMonitor.from_constraint, self.path_constraints))
        return Monitors(path_monitors, tuple(int(state) for state in states))

    def select_direction(self, name: str, samples: slice = slice(None)) -> tuple[Floats, Floats]:
        """Return the unit vectors and apparent radii [rad] of a reference direction, such as the
        Sun.

        The unit vectors are in GCRS, shape (n, 3). The radii have shape (n,). Both cover a slice of
        the samples.
        """
        index = list_directions(self.suite, self.monitors).index(name)
        return self.directions[samples, index], self.radii[samples, index]

    def compute_direction_motion(self, name: str, samples: slice = slice(None)) -> DirectionMotion:
        """Return the motion of a direction, such as the Sun, in the filter step before each sample.

        The first sample has no step before it.
        """
        return DirectionMotion.from_samples(*self.select_direction(name, samples))

    @cached_property
    def orbit_table(self) -> Floats:
        """Orbit table of the compiled filter, with one row of vectors and flags per sample.

        `layout.compute_table_columns` describes the columns.
        """
        parts = [self.references.reshape(len(self.references), -1)]
        for name in list_path_directions(self.monitors):
            motion = self.compute_direction_motion(name)
            parts += [
                motion.end,
                motion.end - motion.start,
                motion.appears[:, None].astype(float),
            ]
            if is_disc(name):
                radius, start_radius = motion.end_radius, motion.start_radius
                parts += [radius[:, None], (radius - start_radius)[:, None]]
        for name in list_view_directions(self.suite):
            vectors, radii = self.select_direction(name)
            parts.append(vectors)
            if is_disc(name):
                parts += [np.cos(radii)[:, None], np.sin(radii)[:, None]]
        return np.hstack([*parts, self.sensitivity_factors, self.available[:, self.gated]])

    @cached_property
    def traits(self) -> KernelTraits:
        """Properties that two models must have in common to share one compiled filter."""
        constrained_directions = [
            (monitor.direction, monitor.keep_in) for monitor in self.monitors.paths
        ]
        cones = [cone for sensor in self.suite.sensors for cone in sensor.list_visibility_cones()]
        return KernelTraits(
            self.suite.blocks,
            tuple(self.suite.considered_indices.tolist()),
            (*constrained_directions, *((cone.direction, cone.keep_in) for cone in cones)),
            len(self.instrument_constants),
            tuple(
                serialize_measurement_matrix(sensor, self.suite.environment_errors)
                for sensor in self.suite.sensors
            ),
        )

    @cached_property
    def instrument_constants(self) -> Floats:
        """Constants of a filter step that depend on instruments and path constraints.

        See `codegen.compute_instrument_constants`.
        """
        return compute_instrument_constants(self.suite, self.step, self.path_constraints)

    def build_schedule(self, designs: ArrayLike, n_steps: int | None = None) -> Schedule:
        """Convert designs, shape (n, 4 m), to a schedule of body rates.

        The schedule ends at the step `n_steps`, by default at the end of the scenario.
        """
        last = self.n_steps if n_steps is None else n_steps
        return build_schedule(designs, self.step, self.slew_limits, last)

    @cached_property
    def gated(self) -> tuple[bool, ...]:
        """Tuple with one flag per sensor, which is True if the sensor is unavailable at some
        samples.
        """
        return tuple(bool(column.any()) for column in ~self.available.T)


def find_sample_instants(sensor: Sensor, step: float, n_samples: int) -> Bools:
    """Return a mask of the filter samples at which a sensor measures, given its sample interval."""
    interval = 1 if sensor.sample_interval is None else round(sensor.sample_interval / step)
    samples: Bools = np.arange(n_samples) % interval == 0
    return samples


def compute_references(suite: Suite, environment: Environment) -> tuple[Floats, Bools]:
    """Compute the reference vectors and the availability of all sensors in an environment.

    The vectors are in GCRS, shape (n_times, n_vectors, 3), as in `FilterModel.references`. The
    availability has shape (n_times, n_sensors).
    """
    n_times, environment = (
        len(environment.times),
        suite.environment_errors.apply_to_environment(environment),
    )
    references = np.zeros((n_times, suite.n_vectors, 3))
    for index, sensor in enumerate(suite.sensors):
        reference = sensor.inertial_vector(environment)
        if reference is not None:
            references[:, index] = reference
        references[:, suite.find_auxiliary_rows(index)] = suite.compute_auxiliary_vectors(
            sensor, environment
        )
    return references, compute_availability(suite, environment)


def compute_availability(suite: Suite, environment: Environment) -> Bools:
    """Return a mask of the times at which the environment allows each sensor to measure.

    A Sun sensor, for example, is available in sunlight only. The field of view, the body rate and
    the sample interval are not considered.

    Returns
    -------
    array of bool, shape (n_times, n_sensors)
    """
    is_available = np.ones((len(environment.times), len(suite.sensors)), dtype=bool)
    for column, sensor in zip(is_available.T, suite.sensors, strict=True):
        mask = sensor.find_available_samples(environment)
        if mask is not None:
            column[:] = mask
    return is_available
