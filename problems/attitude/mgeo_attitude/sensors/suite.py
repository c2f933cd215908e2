"""A sensor suite as one error state: blocks and units, columns as named vectors, dense twins."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.geometry.vector import Vec3, scale
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.errors import Alike, GaussMarkov, Influence, State, influenced, sigma_of
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.world import World
from mgeo_attitude.settings.types import DEG, DIMENSIONLESS, Unit

Owner = Gyro | Sensor | World
STILL = Vec3(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Suite:
    """A gyro, the sensors that aid it, and the world that they see.

    The error state is a list of 3-vectors, here called blocks: the attitude error, the gyro's
    states, then those of the world, which all sensors share, and of each sensor in turn. For the
    paper's suite these are θ, b, φ, δs, ψ, δB. Errors of world and sensors that vary
    (`GaussMarkov`) come before all constants of sensors.

    Parameters
    ----------
    gyro : Gyro
    sensors : tuple of Sensor
        With names of their own.
    world : World, optional

    Examples
    --------
    >>> from mgeo_attitude import Gyro, Magnetometer, Suite, SunSensor
    >>> suite = Suite(Gyro(), (SunSensor(), Magnetometer()))
    >>> suite.n_states, suite.blocks[:3]
    (18, ('attitude', 'gyro.bias', 'sun.misalignment'))
    """

    gyro: Gyro
    sensors: tuple[Sensor, ...]
    world: World = field(default_factory=World)

    @cached_property
    def owners(self) -> dict[str, Owner]:
        """Whose the states are, by the names that prefix their blocks."""
        sensors = {sensor.name: sensor for sensor in self.sensors}
        return {"gyro": self.gyro, "world": self.world, **sensors}

    @cached_property
    def blocks(self) -> tuple[str, ...]:
        """Names of the 3-vectors of the state, in order: ``attitude``, ``gyro.bias``..."""
        return tuple(self.units)

    @cached_property
    def units(self) -> dict[str, Unit]:
        """Unit of each block for people and scenario files, in the order of `blocks`."""
        units = {
            f"{name}.{state}": unit
            for name, owner in self.owners.items()
            for state, unit in units_of(owner).items()
        }
        first = (*(f"gyro.{state}" for state in self.gyro.states()), *self.processes)
        return {"attitude": DEG} | {block: units[block] for block in first} | units

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Places of the three states of each block."""
        return {block: slice(3 * i, 3 * i + 3) for i, block in enumerate(self.blocks)}

    @cached_property
    def states(self) -> dict[str, State]:
        """What gyro, world and sensors say of the states of their blocks at the start."""
        return {
            f"{name}.{state}": value
            for name, owner in self.owners.items()
            for state, value in owner.states().items()
        }

    @property
    def n_states(self) -> int:
        return 3 * len(self.blocks)

    @property
    def n_kinematic(self) -> int:
        """Number of leading states that enter the attitude kinematics: attitude and gyro."""
        return 3 * (1 + len(self.gyro.states()))

    @property
    def n_dynamic(self) -> int:
        """Number of leading states that are not constant by nature: with the processes."""
        return self.n_kinematic + 3 * len(self.processes)

    @cached_property
    def processes(self) -> dict[str, GaussMarkov]:
        """Gauss-Markov processes by their blocks, which follow the kinematic ones."""
        return {b: value for b, value in self.states.items() if isinstance(value, GaussMarkov)}

    @cached_property
    def considered_blocks(self) -> tuple[str, ...]:
        """Blocks that are considered: not estimated, but their covariance counts."""
        owners = self.owners.items()
        return tuple(f"{name}.{state}" for name, owner in owners for state in owner.considered)

    @cached_property
    def considered(self) -> Ints:
        """Their states."""
        return self._states(self.considered_blocks)

    @cached_property
    def uncalibrated(self) -> frozenset[str]:
        """Blocks that no plan makes smaller for good: they vary, or are considered."""
        return frozenset((*self.processes, *self.considered_blocks))

    @cached_property
    def calibrated(self) -> Ints:
        """States of all others."""
        return self._states([block for block in self.blocks if block not in self.uncalibrated])

    def n_gradient(self, sensor: Sensor) -> int:
        """How many columns the `gradient` of a sensor has here."""
        orbit = 3 * ("orbit_error" in self.blocks_of(sensor))
        return sensor.n_gradient + orbit + len(sensor.delay())

    def gradient(self, sensor: Sensor, environment: Environment) -> Floats:
        """Columns of its `Sensor.gradient`, then those by an orbit error that it sees.

        Of a sensor with a delay the last one is the derivative of its vector by time.

        Shape (n_steps + 1, `n_gradient`, 3), GCRS.
        """
        parts = [np.zeros((len(environment.times), 3, 0))]
        if sensor.n_gradient:
            parts.append(sensor.gradient(environment))
        if "orbit_error" in self.blocks_of(sensor):
            by_position = sensor.by_position(environment)
            parts.append(self.world.by_orbit_error(by_position, environment))
        if sensor.delay():
            vector, change = sensor.inertial_vector(environment), np.zeros(parts[0].shape[:2])
            if vector is not None and len(change) > 1:
                change = np.gradient(vector, environment.times, axis=0)
            parts.append(change[:, :, None])
        return np.concatenate(parts, axis=2).swapaxes(1, 2)

    @cached_property
    def n_vectors(self) -> int:
        """Number of vectors that the orbit gives: one for each sensor, then all gradients."""
        return len(self.sensors) + sum(map(self.n_gradient, self.sensors))

    def gradient_rows(self, index: int) -> slice:
        """Which of these vectors are the columns of a sensor's `gradient`; empty if it has none."""
        first = len(self.sensors) + sum(map(self.n_gradient, self.sensors[:index]))
        return slice(first, first + self.n_gradient(self.sensors[index]))

    def looks(self, index: int) -> list[int]:
        """All of these vectors that are a sensor's, in this order."""
        rows = self.gradient_rows(index)
        return [index, *range(rows.start, rows.stop)]

    @cached_property
    def influence_keys(self) -> dict[str, Influence]:
        """All influences by their keys in a scenario: the gyro's, then those of sensors."""
        places: dict[str, Gyro | Sensor] = {"gyro": self.gyro}
        places |= {f"sensors[{i}]": sensor for i, sensor in enumerate(self.sensors)}
        return {
            f"{place}.influences[{i}]": influence
            for place, owner in places.items()
            for i, influence in enumerate(owner.influences)
        }

    def influence_columns(self, owner: Gyro | Sensor) -> slice:
        """Which of all influences are an owner's."""
        first = 0
        if isinstance(owner, Sensor):
            place = [sensor.name for sensor in self.sensors].index(owner.name)
            before: list[Gyro | Sensor] = [self.gyro, *self.sensors[:place]]
            first = sum(len(each.influences) for each in before)
        return slice(first, first + len(owner.influences))

    def influence_values(self, channels: Mapping[str, Floats], n: int) -> Floats:
        """What all influences are times, shape (n, n_influences), of channels at n samples.

        Of the gyro it is the mean over the step to a sample.
        """
        found = [channels[each.channel] - each.reference for each in self.influence_keys.values()]
        values: Floats = np.column_stack(found) if found else np.zeros((n, 0))
        own = slice(len(self.gyro.influences))
        values[1:, own] = 0.5 * (values[1:, own] + values[:-1, own])
        return values

    @cached_property
    def rotations(self) -> tuple[int, ...]:
        """First states of the blocks that are rotations, that of the attitude first."""
        owners: tuple[Gyro | Sensor, ...] = (self.gyro, *self.sensors)
        placed = ((state, first, o) for o in owners for state, first in self.places(o).items())
        return (0, *(first for state, first, owner in placed if state in owner.rotations))

    def blocks_of(self, owner: Gyro | Sensor) -> dict[str, str]:
        """Blocks that the gyro adds, or that enter what a sensor measures, by their states.

        A sensor's are its own and those of the world that it sees.
        """
        if isinstance(owner, Gyro):
            return {state: f"gyro.{state}" for state in owner.states()}
        seen = {state: f"world.{state}" for state in owner.sees()}
        seen = {state: block for state, block in seen.items() if block in self.slices}
        return {state: f"{owner.name}.{state}" for state in owner.states()} | seen

    def places(self, owner: Gyro | Sensor) -> dict[str, int]:
        """Number of the first of the three states of each of `blocks_of`."""
        return {state: self.slices[b].start for state, b in self.blocks_of(owner).items()}

    def initial_sigma(self, attitude_sigma: float) -> Floats:
        """Initial 1-sigma of every state, shape (n_states,), for an attitude 1-sigma [rad]."""
        sigmas = np.full(self.n_states, attitude_sigma)
        for block, value in self.states.items():
            sigmas[self.slices[block]] = sigma_of(value)
        return sigmas

    @cached_property
    def initial_correlation(self) -> Floats:
        """Of the errors at the start, shape (n_states, n_states)."""
        correlation = np.eye(self.n_states)
        for block, value in self.states.items():
            if isinstance(value, Alike):
                own = self.slices[block]
                correlation[own, own] += value.correlation * (1.0 - np.eye(3))
        return correlation

    def measure(
        self,
        sensor: Sensor,
        v: Vec3,
        column: Sequence[Any],
        to_body: Callable[[Vec3], Vec3] = lambda vector: vector,
        gradient: Sequence[Vec3] = (),
        rate: Vec3 = STILL,
        influences: Sequence[Any] = (),
    ) -> tuple[Any, ...]:
        """Apply a sensor's H to a state column: the numbers of `Sensor.measure`.

        Parameters
        ----------
        v : Vec3
            Its reference vector in body axes.
        to_body : function
            From GCRS to body axes; default: they are the same.
        gradient : sequence of Vec3
            Columns of its gradient in body axes, see `gradient_rows`.
        rate : Vec3
            Of the body [rad/s], which matters where there is a delay: see `readings.taken`.
        influences : sequence
            Its columns of `influence_values`.
        """
        own = {s: self._block(column, block) for s, block in self.blocks_of(sensor).items()}
        theta, moved = self._block(column, "attitude"), STILL
        if late := own.pop("delay", None):
            *gradient, change = gradient
            theta, moved = theta - scale(late, rate), -scale(late, change)
        influenced(sensor.influences, own, influences, lambda u, c: scale(Vec3(u, u, u), c))
        x = SimpleNamespace(theta=theta, moved=moved, to_body=to_body, gradient=gradient, **own)
        return tuple(sensor.measure(x, v))

    def derivative(self, column: Sequence[Any], omega: Vec3) -> list[Any]:
        """Apply equation (2)'s dynamics to the `n_kinematic` leading states; floats only."""
        own = {state: self._block(column, f"gyro.{state}") for state in self.gyro.states()}
        rates = self.gyro.derivative(
            SimpleNamespace(theta=self._block(column, "attitude"), **own), omega
        )
        return [entry for state in ("theta", *own) for entry in rates.get(state, STILL)]

    def dynamics_matrix(self, omega: Floats, influences: Sequence[float] = ()) -> Floats:
        """A in x' = A x for the dynamic states at body rate `omega` [rad/s].

        Parameters
        ----------
        influences : sequence of float
            The gyro's columns of `influence_values`; default: ones.
        """
        A, k = np.zeros((self.n_dynamic, self.n_dynamic)), self.n_kinematic
        for j, unit in enumerate(np.eye(k)):
            A[:k, j] = self.derivative(list(unit), Vec3(*omega))
        for columns, value in zip(self.following, influences, strict=bool(influences)):
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
        influences: Sequence[Any] = (),
    ) -> Floats:
        """H of one sensor for its reference vector in body axes.

        Parameters
        ----------
        v : array, shape (..., 3)
        attitude : array, shape (..., 3, 3), optional
            GCRS to body; default: body axes along those of GCRS.
        gradient : sequence of arrays, shape (..., 3)
            The columns of the sensor's gradient, body axes; none if it has none.
        rate : array, shape (..., 3), optional
            Of the body [rad/s]; default: at rest.
        influences : sequence of floats or arrays, shape (...)
            Its columns of `influence_values`.

        Returns
        -------
        array, shape (..., m, n_states), of the m numbers that it measures
        """
        H = np.zeros((*v.shape[:-1], len(sensor.noise()), self.n_states))
        components = Vec3(*np.moveaxis(v, -1, 0))
        columns = [Vec3(*np.moveaxis(column, -1, 0)) for column in gradient]
        C = np.eye(3) if attitude is None else attitude
        turning = STILL if rate is None else Vec3(*np.moveaxis(rate, -1, 0))

        def to_body(vector: Vec3) -> Vec3:
            return Vec3(*(sum(C[..., i, k] * vk for k, vk in enumerate(vector)) for i in range(3)))

        for j, unit in enumerate(np.eye(self.n_states)):
            y = self.measure(sensor, components, list(unit), to_body, columns, turning, influences)
            for i, entry in enumerate(y):
                H[..., i, j] = entry
        return H

    def diffusion(self) -> Floats:
        """Diagonal of the process-noise density of the dynamic states, shape (n_dynamic,)."""
        density = self.gyro.diffusion()
        gyro = [density.get(state, (0.0,) * 3) for state in ("theta", *self.gyro.states())]
        varying = [np.broadcast_to(each.density, 3) for each in self.processes.values()]
        return np.concatenate([np.ravel(gyro), *varying])

    @property
    def following(self) -> tuple[slice, ...]:
        """States of each of the gyro's influences."""
        return tuple(self.slices[f"gyro.{each.state}"] for each in self.gyro.influences)

    def _states(self, blocks: Iterable[str]) -> Ints:
        """States of blocks, one after the other."""
        every = np.arange(self.n_states).reshape(-1, 3)
        return every[[self.blocks.index(block) for block in blocks]].ravel()

    def _block(self, column: Sequence[Any], name: str) -> Vec3:
        return Vec3(*column[self.slices[name]])


def units_of(owner: Owner) -> dict[str, Unit]:
    """Unit of each state of an owner for people and scenario files."""
    units = {state: owner.units.get(state, DIMENSIONLESS) for state in owner.states()}
    for influence in () if isinstance(owner, World) else owner.influences:
        units[influence.state] = influence.unit_of(units[influence.error])
    return units


class BlockUnit(NamedTuple):
    """How a 3-vector of the state is shown: `unit`, and `factor` from the filter's unit to it."""

    label: str
    unit: str
    factor: float


def block_units(suite: Suite) -> list[BlockUnit]:
    """Label, unit and factor of each 3-vector of the state, in the order of ``suite.blocks``.

    Units are those that gyro and sensors declare, and those of the keys of ``required_sigma`` that
    end in one.
    """
    units = []
    for block, unit in suite.units.items():
        owner, _, state = block.rpartition(".")
        label = f"{owner} {state.replace('_', ' ')}".strip()
        units.append(BlockUnit(label, unit.text, unit.factor))
    return units
