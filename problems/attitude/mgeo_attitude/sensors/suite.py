"""Sensor suite with its combined error state: state blocks, their units and the model matrices."""

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
    """Gyro, attitude sensors and environment model errors, with their combined error state.

    The error state is a sequence of 3-vectors, called blocks: the attitude error, the gyro's
    states, then the environment model errors, which all sensors share, and the states of each
    sensor. The blocks of the paper's suite are θ, b, φ, δs, ψ, δB. Gauss-Markov errors precede the
    constants of the sensors.

    Parameters
    ----------
    gyro : Gyro
    sensors : tuple of Sensor
        Sensors with unique names.
    environment_errors : EnvironmentErrors, optional
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
        """Gyro, environment model errors and sensors, keyed by name.

        The names are prefixes of block names: ``gyro``, ``environment_errors`` and the name of each
        sensor.
        """
        sensors = {sensor.name: sensor for sensor in self.sensors}
        return {"gyro": self.gyro, "environment_errors": self.environment_errors, **sensors}

    @cached_property
    def blocks(self) -> tuple[str, ...]:
        """Names of the 3-vectors in the error state, such as ``attitude`` and ``gyro.bias``.

        The 3-vectors are called blocks.
        """
        return tuple(self.units)

    @cached_property
    def units(self) -> dict[str, Unit]:
        """Display unit of each 3-vector in the error state, keyed by its name.

        The dict has the order of the error state. Scenario files use the same units.
        """
        units = {
            f"{name}.{state}": unit
            for name, source in self.error_sources.items()
            for state, unit in list_units(source).items()
        }
        leading = (*(f"gyro.{state}" for state in self.gyro.states()), *self.processes)
        return {"attitude": DEG} | {block: units[block] for block in leading} | units

    @cached_property
    def block_slices(self) -> dict[str, slice]:
        """Slice of each 3-vector in the error state, keyed by its name."""
        return {block: slice(3 * i, 3 * i + 3) for i, block in enumerate(self.blocks)}

    @cached_property
    def states(self) -> dict[str, State]:
        """Initial 1-sigma or Gauss-Markov process of each 3-vector in the error state, by name.

        The attitude is left out, because its initial 1-sigma belongs to the scenario.
        """
        return {
            f"{name}.{state}": value
            for name, source in self.error_sources.items()
            for state, value in source.states().items()
        }

    @property
    def n_states(self) -> int:
        """Number of components of the error state."""
        return 3 * len(self.blocks)

    @property
    def n_kinematic(self) -> int:
        """Number of error-state components for the attitude error and the gyro states.

        These components come first in the error state.
        """
        return 3 * (1 + len(self.gyro.states()))

    @property
    def n_dynamic(self) -> int:
        """Number of error-state components that the dynamics matrix describes.

        These components come first in the error state. They are the attitude error, the gyro states
        and the Gauss-Markov errors.
        """
        return self.n_kinematic + 3 * len(self.processes)

    @cached_property
    def processes(self) -> dict[str, GaussMarkov]:
        """Gauss-Markov process of each time-varying error, keyed by block name.

        In the error state, these blocks follow those of attitude and gyro.
        """
        return {b: value for b, value in self.states.items() if isinstance(value, GaussMarkov)}

    @cached_property
    def considered_blocks(self) -> tuple[str, ...]:
        """Names of the 3-vectors that the Schmidt-Kalman filter considers but does not estimate.

        The filter accounts for the uncertainty of these blocks.
        """
        sources = self.error_sources.items()
        return tuple(f"{name}.{state}" for name, source in sources for state in source.considered)

    @cached_property
    def considered_indices(self) -> Ints:
        """Indices of the error-state components that are considered but not estimated."""
        return self._list_state_indices(self.considered_blocks)

    @cached_property
    def uncalibrated_blocks(self) -> frozenset[str]:
        """Names of the 3-vectors that a calibration cannot determine permanently.

        These are the Gauss-Markov errors, which vary with time, and the considered blocks.
        """
        return frozenset((*self.processes, *self.considered_blocks))

    @cached_property
    def calibrated_indices(self) -> Ints:
        """Indices of the error-state components that a calibration can determine permanently.

        Gauss-Markov errors and considered blocks are excluded.
        """
        return self._list_state_indices(
            [block for block in self.blocks if block not in self.uncalibrated_blocks]
        )

    def count_auxiliary_vectors(self, sensor: Sensor) -> int:
        """Return the number of vectors that a sensor needs besides its reference vector.

        See `compute_auxiliary_vectors`.
        """
        orbit = 3 * ("orbit_error" in self.list_blocks(sensor))
        return sensor.n_auxiliary_vectors + orbit + len(sensor.latency_states())

    def compute_auxiliary_vectors(self, sensor: Sensor, environment: Environment) -> Floats:
        """Return the vectors that a sensor needs besides its reference vector, at each sample.

        The vectors are the columns of `Sensor.auxiliary_vectors`, then the derivatives with respect
        to the orbit error if it affects the sensor, and last, for a sensor with latency, the time
        derivative of its reference vector.

        Returns
        -------
        array, shape (n_steps + 1, k, 3)
            GCRS axes; k is the result of `count_auxiliary_vectors`.
        """
        parts = [np.zeros((len(environment.times), 3, 0))]
        if sensor.n_auxiliary_vectors:
            parts.append(sensor.auxiliary_vectors(environment))
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
        """Total number of reference and auxiliary vectors of all sensors at a sample."""
        return len(self.sensors) + sum(map(self.count_auxiliary_vectors, self.sensors))

    def find_auxiliary_rows(self, index: int) -> slice:
        """Return the slice of one sensor's auxiliary vectors in the array of all vectors.

        The array contains the reference vector of every sensor, then the auxiliary vectors, sensor
        by sensor.

        Parameters
        ----------
        index : int
            Index of the sensor.
        """
        first = len(self.sensors) + sum(map(self.count_auxiliary_vectors, self.sensors[:index]))
        return slice(first, first + self.count_auxiliary_vectors(self.sensors[index]))

    def list_vector_indices(self, index: int) -> list[int]:
        """Return the indices of one sensor's vectors in the array of all vectors.

        The index of the reference vector comes first.
        """
        rows = self.find_auxiliary_rows(index)
        return [index, *range(rows.start, rows.stop)]

    @cached_property
    def sensitivities_by_key(self) -> dict[str, BiasSensitivity]:
        """Bias sensitivities of the gyro and all sensors, keyed by their path in a scenario file.

        An example of a key is ``gyro.bias_sensitivities[0]``.
        """
        sources: dict[str, Gyro | Sensor] = {"gyro": self.gyro}
        sources |= {f"sensors[{i}]": sensor for i, sensor in enumerate(self.sensors)}
        return {
            f"{key}.bias_sensitivities[{i}]": sensitivity
            for key, source in sources.items()
            for i, sensitivity in enumerate(source.bias_sensitivities)
        }

    def find_sensitivity_columns(self, source: Gyro | Sensor) -> slice:
        """Return the columns of `compute_channel_deviations` that belong to one gyro or sensor.

        There is one column per bias sensitivity.
        """
        first = 0
        if isinstance(source, Sensor):
            index = [sensor.name for sensor in self.sensors].index(source.name)
            earlier: list[Gyro | Sensor] = [self.gyro, *self.sensors[:index]]
            first = sum(len(each.bias_sensitivities) for each in earlier)
        return slice(first, first + len(source.bias_sensitivities))

    def compute_channel_deviations(self, channels: Mapping[str, Floats], n: int) -> Floats:
        """Return the deviations of housekeeping channels from their reference values.

        The array has one row per sample and one column per bias sensitivity. The deviations for the
        gyro are means over the step before each sample.

        Parameters
        ----------
        channels : mapping
            Values of each housekeeping channel at every sample, shape (n,).
        n : int
            Number of samples.

        Returns
        -------
        array, shape (n, number of bias sensitivities)
        """
        columns = [
            channels[each.channel] - each.reference for each in self.sensitivities_by_key.values()
        ]
        values: Floats = np.column_stack(columns) if columns else np.zeros((n, 0))
        gyro = slice(len(self.gyro.bias_sensitivities))
        values[1:, gyro] = 0.5 * (values[1:, gyro] + values[:-1, gyro])
        return values

    @cached_property
    def rotation_indices(self) -> tuple[int, ...]:
        """Index of the first component of each rotation vector in the error state.

        The first rotation vector is the attitude error.
        """
        sources: tuple[Gyro | Sensor, ...] = (self.gyro, *self.sensors)
        indices = (
            first
            for source in sources
            for state, first in self.get_first_indices(source).items()
            if state in source.rotations
        )
        return (0, *indices)

    def list_blocks(self, source: Gyro | Sensor) -> dict[str, str]:
        """Return a dict that maps each error of a gyro or sensor to its name in the error state.

        For a Sun sensor, for example, ``bias`` is mapped to ``sun.bias``. Blocks of environment
        model errors are included if they affect the sensor.
        """
        if isinstance(source, Gyro):
            return {state: f"gyro.{state}" for state in source.states()}
        shared = {name: f"environment_errors.{name}" for name in source.list_environment_errors()}
        shared = {name: block for name, block in shared.items() if block in self.block_slices}
        return {state: f"{source.name}.{state}" for state in source.states()} | shared

    def get_first_indices(self, source: Gyro | Sensor) -> dict[str, int]:
        """Return the error-state index at which each error of a gyro or sensor begins.

        The dict is keyed by the name of the error, such as ``bias``.
        """
        return {state: self.block_slices[b].start for state, b in self.list_blocks(source).items()}

    def initial_sigma(self, attitude_sigma: float) -> Floats:
        """Return the initial 1-sigma of every error-state component, shape (n_states,).

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
        """Initial correlation matrix of the error state, shape (n_states, n_states)."""
        correlation = np.eye(self.n_states)
        for block, value in self.states.items():
            if isinstance(value, ScalarConstant):
                rows = self.block_slices[block]
                correlation[rows, rows] += value.correlation * (1.0 - np.eye(3))
        return correlation

    def apply_measurement_matrix(
        self,
        sensor: Sensor,
        v: Vec3,
        error_state: Sequence[Any],
        to_body: Callable[[Vec3], Vec3] = lambda vector: vector,
        auxiliary_vectors: Sequence[Vec3] = (),
        rate: Vec3 = ZERO_VECTOR,
        channel_deviations: Sequence[Any] = (),
    ) -> tuple[Any, ...]:
        """Return the product H x of the measurement matrix H of a sensor and an error state x.

        Numbers, arrays or symbols of the code generator are possible; see
        `Sensor.linearize_measurement`.

        Parameters
        ----------
        sensor : Sensor
        v : Vec3
            Reference vector in body axes.
        error_state : sequence
            Error state, n_states components.
        to_body : function
            Rotation from GCRS to body axes; default: identity.
        auxiliary_vectors : sequence of Vec3
            Vectors of `compute_auxiliary_vectors` in body axes.
        rate : Vec3
            Body rate [rad/s], for sensors with latency; see `measurements.apply_latency`.
        channel_deviations : sequence
            The sensor's columns of `compute_channel_deviations`.

        Returns
        -------
        tuple
            The m components of the measurement error.
        """
        errors = {
            state: self._select_block(error_state, block)
            for state, block in self.list_blocks(sensor).items()
        }
        theta, reference_change = self._select_block(error_state, "attitude"), ZERO_VECTOR
        if latency := errors.pop("latency", None):
            *auxiliary_vectors, change = auxiliary_vectors
            theta, reference_change = (
                theta - componentwise_product(latency, rate),
                -componentwise_product(latency, change),
            )
        apply_bias_sensitivities(
            sensor.bias_sensitivities,
            errors,
            channel_deviations,
            lambda u, c: componentwise_product(Vec3(u, u, u), c),
        )
        x = SimpleNamespace(
            theta=theta,
            reference_change=reference_change,
            to_body=to_body,
            auxiliary_vectors=auxiliary_vectors,
            **errors,
        )
        return tuple(sensor.linearize_measurement(x, v))

    def apply_dynamics(self, error_state: Sequence[Any], omega: Vec3) -> list[Any]:
        """Return the time derivatives of the attitude error and the gyro states.

        The list has `n_kinematic` components. This is equation (2) without noise. Numbers, arrays
        or symbols of the code generator are possible.

        Parameters
        ----------
        error_state : sequence
            Error state; only the first `n_kinematic` components are used.
        omega : Vec3
            Body rate [rad/s].
        """
        errors = {s: self._select_block(error_state, f"gyro.{s}") for s in self.gyro.states()}
        rates = self.gyro.compute_error_derivative(
            SimpleNamespace(theta=self._select_block(error_state, "attitude"), **errors), omega
        )
        return [entry for state in ("theta", *errors) for entry in rates.get(state, ZERO_VECTOR)]

    def dynamics_matrix(self, omega: Floats, channel_deviations: Sequence[float] = ()) -> Floats:
        """Return the dynamics matrix A in x' = A x for the error state x at a given body rate.

        Parameters
        ----------
        omega : array, shape (3,)
            Body rate [rad/s].
        channel_deviations : sequence of float
            The gyro's columns of `compute_channel_deviations`; default: ones.

        Returns
        -------
        array, shape (n_dynamic, n_dynamic)
            Attitude, gyro and Gauss-Markov errors; all further states are constant.
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
        auxiliary_vectors: Sequence[Floats] = (),
        rate: Floats | None = None,
        channel_deviations: Sequence[Any] = (),
    ) -> Floats:
        """Return the measurement matrix H of a sensor for the complete error state.

        Parameters
        ----------
        sensor : Sensor
            Sensor of the suite.
        v : array, shape (..., 3)
            Reference vector in body axes.
        attitude : array, shape (..., 3, 3), optional
            Attitude matrix, GCRS to body; default: identity.
        auxiliary_vectors : sequence of arrays, shape (..., 3)
            Vectors of `compute_auxiliary_vectors` in body axes.
        rate : array, shape (..., 3), optional
            Body rate [rad/s]; default: zero.
        channel_deviations : sequence of floats or arrays, shape (...)
            The sensor's columns of `compute_channel_deviations`.

        Returns
        -------
        array, shape (..., m, n_states)
            One row for each of the m components of the measurement.
        """
        H = np.zeros((*v.shape[:-1], len(sensor.noise_sigmas()), self.n_states))
        components = Vec3(*np.moveaxis(v, -1, 0))
        columns = [Vec3(*np.moveaxis(column, -1, 0)) for column in auxiliary_vectors]
        C = np.eye(3) if attitude is None else attitude
        body_rate = ZERO_VECTOR if rate is None else Vec3(*np.moveaxis(rate, -1, 0))

        def to_body(vector: Vec3) -> Vec3:
            return Vec3(*(sum(C[..., i, k] * vk for k, vk in enumerate(vector)) for i in range(3)))

        for j, unit in enumerate(np.eye(self.n_states)):
            y = self.apply_measurement_matrix(
                sensor, components, list(unit), to_body, columns, body_rate, channel_deviations
            )
            for i, entry in enumerate(y):
                H[..., i, j] = entry
        return H

    def compute_noise_density(self) -> Floats:
        """Return the power spectral density of the process noise on each dynamic error state.

        Returns
        -------
        array, shape (n_dynamic,)
            Diagonal of the process noise density, in squared filter units per second.
        """
        density = self.gyro.compute_noise_density()
        gyro = [density.get(state, (0.0,) * 3) for state in ("theta", *self.gyro.states())]
        varying = [np.broadcast_to(each.noise_density, 3) for each in self.processes.values()]
        return np.concatenate([np.ravel(gyro), *varying])

    @property
    def gyro_sensitivity_slices(self) -> tuple[slice, ...]:
        """Slices of the gyro's bias-sensitivity coefficients in the error state.

        There is one slice per sensitivity.
        """
        return tuple(
            self.block_slices[f"gyro.{each.state_name}"] for each in self.gyro.bias_sensitivities
        )

    def _list_state_indices(self, blocks: Iterable[str]) -> Ints:
        indices = np.arange(self.n_states).reshape(-1, 3)
        return indices[[self.blocks.index(block) for block in blocks]].ravel()

    def _select_block(self, error_state: Sequence[Any], name: str) -> Vec3:
        return Vec3(*error_state[self.block_slices[name]])


def list_units(source: ErrorSource) -> dict[str, Unit]:
    """Return a dict with the display unit of each error of a gyro or sensor.

    `source` is a gyro, a sensor or the environment model errors.
    """
    units = {state: source.units.get(state, DIMENSIONLESS) for state in source.states()}
    if not isinstance(source, EnvironmentErrors):
        for sensitivity in source.bias_sensitivities:
            error_unit = units[sensitivity.error]
            units[sensitivity.state_name] = sensitivity.coefficient_unit(error_unit)
    return units


class BlockUnit(NamedTuple):
    """Display name and display unit of a 3-vector in the error state.

    Attributes
    ----------
    label : str
        Name for display, such as ``gyro bias``.
    unit : str
        Unit for display, such as ``deg/h``.
    factor : float
        Factor from the filter's unit to the display unit.
    """

    label: str
    unit: str
    factor: float


def list_block_units(suite: Suite) -> list[BlockUnit]:
    """Return the display name and unit of each 3-vector in the error state, in order.

    The units also apply to keys of ``required_sigma`` that end in a unit.
    """
    units = []
    for block, unit in suite.units.items():
        source, _, state = block.rpartition(".")
        owner = source.removeprefix("environment_errors")
        label = f"{owner} {state.replace('_', ' ')}".strip()
        units.append(BlockUnit(label, unit.text, unit.factor))
    return units
