"""Sensor suite with its combined error state: blocks, units and model matrices."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.geometry.vector import Vec3, componentwise_product
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.environment_errors import EnvironmentErrors
from mgeo_attitude.sensors.error_models import (
    BiasSensitivity,
    GaussMarkov,
    ScalarConstant,
    State,
    apply_bias_sensitivities,
    get_initial_sigma,
)
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.settings.types import DEG, DIMENSIONLESS, Unit

ErrorSource = Gyro | Sensor | EnvironmentErrors
ZERO_VECTOR = Vec3(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Suite:
    """A gyro, its aiding sensors, and the environment model errors that affect them.

    The error state is a sequence of 3-vectors, called blocks: the attitude error, the gyro's
    states, then the environment model errors, which all sensors share, and the states of each
    sensor. The blocks of the paper's suite are θ, b, φ, δs, ψ, δB. Gauss-Markov errors precede the
    constants of the sensors.

    Parameters
    ----------
    gyro : Gyro
    sensors : tuple of Sensor
        Sensors with unique names.
    environment_errors : World, optional
        Environment model errors.

    Examples
    --------
    >>> from mgeo_attitude import Gyro, Magnetometer, Suite, SunSensor
    >>> suite = Suite(Gyro(), (SunSensor(), Magnetometer()))
    >>> suite.n_states, suite.blocks[:3]
    (18, ('attitude', 'gyro.bias', 'sun.misalignment'))
    """

    gyro: Gyro
    sensors: tuple[Sensor, ...]
    environment_errors: EnvironmentErrors = field(default_factory=EnvironmentErrors)

    @cached_property
    def error_sources(self) -> dict[str, ErrorSource]:
        """Gyro, environment models and sensors by the names that prefix their blocks."""
        sensors = {sensor.name: sensor for sensor in self.sensors}
        return {"gyro": self.gyro, "environment_errors": self.environment_errors, **sensors}

    @cached_property
    def blocks(self) -> tuple[str, ...]:
        """Names of the 3-vectors of the state, in order, such as ``attitude`` and ``gyro.bias``."""
        return tuple(self.units)

    @cached_property
    def units(self) -> dict[str, Unit]:
        """Unit of each block for display and scenario files, in the order of `blocks`."""
        units = {
            f"{name}.{state}": unit
            for name, owner in self.error_sources.items()
            for state, unit in list_units(owner).items()
        }
        first = (*(f"gyro.{state}" for state in self.gyro.states()), *self.processes)
        return {"attitude": DEG} | {block: units[block] for block in first} | units

    @cached_property
    def block_slices(self) -> dict[str, slice]:
        """Slice of the three states of each block."""
        return {block: slice(3 * i, 3 * i + 3) for i, block in enumerate(self.blocks)}

    @cached_property
    def states(self) -> dict[str, State]:
        """Initial 1-sigma or process of each block but the attitude."""
        return {
            f"{name}.{state}": value
            for name, owner in self.error_sources.items()
            for state, value in owner.states().items()
        }

    @property
    def n_states(self) -> int:
        return 3 * len(self.blocks)

    @property
    def n_kinematic(self) -> int:
        """Number of leading states of the attitude kinematics: attitude and gyro."""
        return 3 * (1 + len(self.gyro.states()))

    @property
    def n_dynamic(self) -> int:
        """Number of leading states with dynamics: attitude, gyro and Gauss-Markov errors."""
        return self.n_kinematic + 3 * len(self.processes)

    @cached_property
    def processes(self) -> dict[str, GaussMarkov]:
        """Gauss-Markov processes by block; their states follow the kinematic ones."""
        return {b: value for b, value in self.states.items() if isinstance(value, GaussMarkov)}

    @cached_property
    def considered_blocks(self) -> tuple[str, ...]:
        """Blocks that the filter considers but does not estimate (Schmidt-Kalman)."""
        owners = self.error_sources.items()
        return tuple(f"{name}.{state}" for name, owner in owners for state in owner.considered)

    @cached_property
    def considered_indices(self) -> Ints:
        """State indices of the considered blocks."""
        return self._list_state_indices(self.considered_blocks)

    @cached_property
    def uncalibrated_blocks(self) -> frozenset[str]:
        """Blocks that no plan reduces permanently: Gauss-Markov errors and considered blocks."""
        return frozenset((*self.processes, *self.considered_blocks))

    @cached_property
    def calibrated_indices(self) -> Ints:
        """State indices of the blocks that are not `uncalibrated`."""
        return self._list_state_indices(
            [block for block in self.blocks if block not in self.uncalibrated_blocks]
        )

    def count_gradient_vectors(self, sensor: Sensor) -> int:
        """Return the number of vectors of `gradient` for a sensor."""
        orbit = 3 * ("orbit_error" in self.list_blocks(sensor))
        return sensor.n_gradient + orbit + len(sensor.latency_states())

    def compute_gradient(self, sensor: Sensor, environment: Environment) -> Floats:
        """Return the additional reference vectors of a sensor.

        These are the columns of `Sensor.gradient`, then the derivatives with respect to the orbit
        error, if the sensor is affected by it, and last, for a sensor with latency, the time
        derivative of its reference vector.

        Returns
        -------
        array, shape (n_steps + 1, n_gradient, 3)
            GCRS axes.
        """
        parts = [np.zeros((len(environment.times), 3, 0))]
        if sensor.n_gradient:
            parts.append(sensor.gradient(environment))
        if "orbit_error" in self.list_blocks(sensor):
            by_position = sensor.position_gradient(environment)
            parts.append(
                self.environment_errors.convert_position_gradient(by_position, environment)
            )
        if sensor.latency_states():
            vector, change = sensor.inertial_vector(environment), np.zeros(parts[0].shape[:2])
            if vector is not None and len(change) > 1:
                change = np.gradient(vector, environment.times, axis=0)
            parts.append(change[:, :, None])
        return np.concatenate(parts, axis=2).swapaxes(1, 2)

    @cached_property
    def n_vectors(self) -> int:
        """Number of reference vectors: one per sensor, then the vectors of all gradients."""
        return len(self.sensors) + sum(map(self.count_gradient_vectors, self.sensors))

    def gradient_rows(self, index: int) -> slice:
        """Return the slice of a sensor's `gradient` among the reference vectors."""
        first = len(self.sensors) + sum(map(self.count_gradient_vectors, self.sensors[:index]))
        return slice(first, first + self.count_gradient_vectors(self.sensors[index]))

    def list_vector_indices(self, index: int) -> list[int]:
        """Return the indices of all reference vectors of a sensor."""
        rows = self.gradient_rows(index)
        return [index, *range(rows.start, rows.stop)]

    @cached_property
    def sensitivities_by_key(self) -> dict[str, BiasSensitivity]:
        """Influences of the gyro and of the sensors, by key in a scenario."""
        places: dict[str, Gyro | Sensor] = {"gyro": self.gyro}
        places |= {f"sensors[{i}]": sensor for i, sensor in enumerate(self.sensors)}
        return {
            f"{place}.bias_sensitivities[{i}]": influence
            for place, owner in places.items()
            for i, influence in enumerate(owner.bias_sensitivities)
        }

    def find_sensitivity_columns(self, source: Gyro | Sensor) -> slice:
        """Return the slice of the influences of a gyro or sensor among all influences."""
        first = 0
        if isinstance(source, Sensor):
            place = [sensor.name for sensor in self.sensors].index(source.name)
            before: list[Gyro | Sensor] = [self.gyro, *self.sensors[:place]]
            first = sum(len(each.bias_sensitivities) for each in before)
        return slice(first, first + len(source.bias_sensitivities))

    def compute_channel_deviations(self, channels: Mapping[str, Floats], n: int) -> Floats:
        """Return channel minus reference value of all influences, shape (n, n_influences).

        The gyro's factors are means over the step before each sample.

        Parameters
        ----------
        channels : mapping
            Values of each channel, shape (n,).
        n : int
            Number of samples.
        """
        columns = [
            channels[each.channel] - each.reference for each in self.sensitivities_by_key.values()
        ]
        values: Floats = np.column_stack(columns) if columns else np.zeros((n, 0))
        own = slice(len(self.gyro.bias_sensitivities))
        values[1:, own] = 0.5 * (values[1:, own] + values[:-1, own])
        return values

    @cached_property
    def rotation_indices(self) -> tuple[int, ...]:
        """First state index of each block that is a rotation, the attitude first."""
        owners: tuple[Gyro | Sensor, ...] = (self.gyro, *self.sensors)
        placed = (
            (state, first, o) for o in owners for state, first in self.get_first_indices(o).items()
        )
        return (0, *(first for state, first, owner in placed if state in owner.rotations))

    def list_blocks(self, source: Gyro | Sensor) -> dict[str, str]:
        """Return the blocks of a gyro, or the blocks that affect a sensor, by state.

        The blocks of a sensor are its own and those of the environment model errors that affect it.
        """
        if isinstance(source, Gyro):
            return {state: f"gyro.{state}" for state in source.states()}
        seen = {state: f"environment_errors.{state}" for state in source.list_environment_errors()}
        seen = {state: block for state, block in seen.items() if block in self.block_slices}
        return {state: f"{source.name}.{state}" for state in source.states()} | seen

    def get_first_indices(self, source: Gyro | Sensor) -> dict[str, int]:
        """Return the first state index of each of `blocks_of`, by state."""
        return {state: self.block_slices[b].start for state, b in self.list_blocks(source).items()}

    def initial_sigma(self, attitude_sigma: float) -> Floats:
        """Return the initial 1-sigma of every state, shape (n_states,).

        Parameters
        ----------
        attitude_sigma : float
            Initial attitude 1-sigma [rad].
        """
        sigmas = np.full(self.n_states, attitude_sigma)
        for block, value in self.states.items():
            sigmas[self.block_slices[block]] = get_initial_sigma(value)
        return sigmas

    @cached_property
    def initial_correlation(self) -> Floats:
        """Initial correlation of the errors, shape (n_states, n_states)."""
        correlation = np.eye(self.n_states)
        for block, value in self.states.items():
            if isinstance(value, ScalarConstant):
                own = self.block_slices[block]
                correlation[own, own] += value.correlation * (1.0 - np.eye(3))
        return correlation

    def apply_measurement_matrix(
        self,
        sensor: Sensor,
        v: Vec3,
        column: Sequence[Any],
        to_body: Callable[[Vec3], Vec3] = lambda vector: vector,
        gradient: Sequence[Vec3] = (),
        rate: Vec3 = ZERO_VECTOR,
        channel_deviations: Sequence[Any] = (),
    ) -> tuple[Any, ...]:
        """Multiply a sensor's measurement matrix H by a column of states; see `Sensor.measure`.

        Parameters
        ----------
        sensor : Sensor
        v : Vec3
            Reference vector in body axes.
        column : sequence
            Error state, n_states entries.
        to_body : function
            Rotation from GCRS to body axes; default: identity.
        gradient : sequence of Vec3
            Vectors of `gradient` in body axes.
        rate : Vec3
            Body rate [rad/s], for sensors with latency; see `readings.taken`.
        channel_deviations : sequence
            The sensor's columns of `compute_channel_deviations`.
        """
        own = {
            s: self._select_block(column, block) for s, block in self.list_blocks(sensor).items()
        }
        theta, reference_change = self._select_block(column, "attitude"), ZERO_VECTOR
        if late := own.pop("latency", None):
            *gradient, change = gradient
            theta, reference_change = (
                theta - componentwise_product(late, rate),
                -componentwise_product(late, change),
            )
        apply_bias_sensitivities(
            sensor.bias_sensitivities,
            own,
            channel_deviations,
            lambda u, c: componentwise_product(Vec3(u, u, u), c),
        )
        x = SimpleNamespace(
            theta=theta,
            reference_change=reference_change,
            to_body=to_body,
            gradient=gradient,
            **own,
        )
        return tuple(sensor.linearize_measurement(x, v))

    def apply_dynamics(self, column: Sequence[Any], omega: Vec3) -> list[Any]:
        """Apply the dynamics of equation (2) to the `n_kinematic` leading states."""
        own = {state: self._select_block(column, f"gyro.{state}") for state in self.gyro.states()}
        rates = self.gyro.compute_error_derivative(
            SimpleNamespace(theta=self._select_block(column, "attitude"), **own), omega
        )
        return [entry for state in ("theta", *own) for entry in rates.get(state, ZERO_VECTOR)]

    def dynamics_matrix(self, omega: Floats, channel_deviations: Sequence[float] = ()) -> Floats:
        """Return A in x' = A x for the dynamic states at a body rate.

        Parameters
        ----------
        omega : array, shape (3,)
            Body rate [rad/s].
        channel_deviations : sequence of float
            The gyro's columns of `compute_channel_deviations`; default: ones.
        """
        A, k = np.zeros((self.n_dynamic, self.n_dynamic)), self.n_kinematic
        for j, unit in enumerate(np.eye(k)):
            A[:k, j] = self.apply_dynamics(list(unit), Vec3(*omega))
        for columns, value in zip(
            self.gyro_sensitivity_slices, channel_deviations, strict=bool(channel_deviations)
        ):
            A[:3, columns] *= value
        times = [process.correlation_time for process in self.processes.values()]
        A[range(k, len(A)), range(k, len(A))] = -1.0 / np.repeat(times, 3)
        return A

    def measurement_matrix(
        self,
        sensor: Sensor,
        v: Floats,
        attitude: Floats | None = None,
        gradient: Sequence[Floats] = (),
        rate: Floats | None = None,
        channel_deviations: Sequence[Any] = (),
    ) -> Floats:
        """Return the measurement matrix H of a sensor.

        Parameters
        ----------
        sensor : Sensor
        v : array, shape (..., 3)
            Reference vector in body axes.
        attitude : array, shape (..., 3, 3), optional
            GCRS to body; default: identity.
        gradient : sequence of arrays, shape (..., 3)
            Vectors of `gradient` in body axes.
        rate : array, shape (..., 3), optional
            Body rate [rad/s]; default: zero.
        channel_deviations : sequence of floats or arrays, shape (...)
            The sensor's columns of `compute_channel_deviations`.

        Returns
        -------
        array, shape (..., m, n_states)
            One row for each of the m numbers that the sensor measures.
        """
        H = np.zeros((*v.shape[:-1], len(sensor.noise_sigmas()), self.n_states))
        components = Vec3(*np.moveaxis(v, -1, 0))
        columns = [Vec3(*np.moveaxis(column, -1, 0)) for column in gradient]
        C = np.eye(3) if attitude is None else attitude
        turning = ZERO_VECTOR if rate is None else Vec3(*np.moveaxis(rate, -1, 0))

        def to_body(vector: Vec3) -> Vec3:
            return Vec3(*(sum(C[..., i, k] * vk for k, vk in enumerate(vector)) for i in range(3)))

        for j, unit in enumerate(np.eye(self.n_states)):
            y = self.apply_measurement_matrix(
                sensor, components, list(unit), to_body, columns, turning, channel_deviations
            )
            for i, entry in enumerate(y):
                H[..., i, j] = entry
        return H

    def compute_noise_density(self) -> Floats:
        """Return the diagonal of the dynamic states' process noise density, shape (n_dynamic,)."""
        density = self.gyro.compute_noise_density()
        gyro = [density.get(state, (0.0,) * 3) for state in ("theta", *self.gyro.states())]
        varying = [np.broadcast_to(each.noise_density, 3) for each in self.processes.values()]
        return np.concatenate([np.ravel(gyro), *varying])

    @property
    def gyro_sensitivity_slices(self) -> tuple[slice, ...]:
        """Slice of the states of each of the gyro's influences."""
        return tuple(
            self.block_slices[f"gyro.{each.state_name}"] for each in self.gyro.bias_sensitivities
        )

    def _list_state_indices(self, blocks: Iterable[str]) -> Ints:
        every = np.arange(self.n_states).reshape(-1, 3)
        return every[[self.blocks.index(block) for block in blocks]].ravel()

    def _select_block(self, column: Sequence[Any], name: str) -> Vec3:
        return Vec3(*column[self.block_slices[name]])


def list_units(source: ErrorSource) -> dict[str, Unit]:
    """Return the unit of each state of a gyro, sensor or environment model, by state."""
    units = {state: source.units.get(state, DIMENSIONLESS) for state in source.states()}
    for influence in () if isinstance(source, EnvironmentErrors) else source.bias_sensitivities:
        units[influence.state_name] = influence.coefficient_unit(units[influence.error])
    return units


class BlockUnit(NamedTuple):
    """Label and display unit of a state block; `factor` converts from the filter's unit."""

    label: str
    unit: str
    factor: float


def list_block_units(suite: Suite) -> list[BlockUnit]:
    """Return label, unit and factor of each state block, in the order of ``suite.blocks``.

    The units also apply to keys of ``required_sigma`` that end in a unit.
    """
    units = []
    for block, unit in suite.units.items():
        owner, _, state = block.rpartition(".")
        label = f"{owner} {state.replace('_', ' ')}".strip()
        units.append(BlockUnit(label, unit.text, unit.factor))
    return units
