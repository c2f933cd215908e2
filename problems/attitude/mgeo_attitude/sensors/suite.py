"""A sensor suite as one error state: blocks and units, columns as named vectors, dense twins."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.fields.units import DEG, DIMENSIONLESS, Unit
from mgeo_attitude.geometry.vector import Vec3
from mgeo_attitude.sensors import GaussMarkov, Gyro, Sensor, sigma_of


def state_units(gyro: Gyro, sensors: Iterable[Sensor]) -> dict[str, Unit]:
    """Unit of each 3-vector of the error state for people and scenario files, by its name."""
    owners: dict[str, Gyro | Sensor] = {"gyro": gyro} | {sensor.name: sensor for sensor in sensors}
    units = {
        f"{name}.{state}": owner.units.get(state, DIMENSIONLESS)
        for name, owner in owners.items()
        for state in owner.states()
    }
    varying, own = processes(owners.values()), [f"gyro.{state}" for state in gyro.states()]
    first = {block: units[block] for block in (*own, *varying)}  # the filter has them before others
    return {"attitude": DEG} | first | units


def processes(owners: Iterable[Gyro | Sensor]) -> dict[str, GaussMarkov]:
    """States of sensors that are Gauss-Markov processes, by the names of their blocks."""
    return {
        f"{owner.name}.{state}": value
        for owner in owners
        if isinstance(owner, Sensor)
        for state, value in owner.states().items()
        if isinstance(value, GaussMarkov)
    }


def considered_blocks(gyro: Gyro, sensors: Iterable[Sensor]) -> tuple[str, ...]:
    """Blocks of the state that are considered, not estimated."""
    own = [f"gyro.{state}" for state in gyro.considered]
    return (*own, *(f"{each.name}.{state}" for each in sensors for state in each.considered))


def uncalibrated(gyro: Gyro, sensors: Sequence[Sensor]) -> frozenset[str]:
    """Blocks of the state that no plan makes smaller for good: they vary, or are considered."""
    return frozenset((*processes(sensors), *considered_blocks(gyro, sensors)))


@dataclass(frozen=True)
class Suite:
    """A gyro and the sensors that aid it.

    The error state is a list of 3-vectors, here called blocks: the attitude error, the gyro's
    states, then those of each sensor in turn. For the paper's suite these are θ, b, φ, δs, ψ, δB.
    Errors of sensors that vary (`GaussMarkov`) come before all constants of sensors.
    """

    gyro: Gyro
    sensors: tuple[Sensor, ...]

    @cached_property
    def blocks(self) -> tuple[str, ...]:
        """Names of the 3-vectors of the state, in order: ``attitude``, ``gyro.bias``..."""
        return tuple(self.units)

    @cached_property
    def units(self) -> dict[str, Unit]:
        """Unit of each block for people, in the order of `blocks`."""
        return state_units(self.gyro, self.sensors)

    @property
    def n_states(self) -> int:
        return 3 * len(self.blocks)

    @property
    def n_kinematic(self) -> int:
        """Number of leading states that enter the attitude kinematics: attitude and gyro."""
        return 3 * (1 + len(self.gyro.states()))

    @property
    def n_dynamic(self) -> int:
        """Number of leading states that are not constant by nature: with the sensors' processes."""
        return self.n_kinematic + 3 * len(self.processes)

    @cached_property
    def processes(self) -> dict[str, GaussMarkov]:
        """Gauss-Markov processes of sensors by their blocks, which follow the kinematic ones."""
        return processes(self.sensors)

    @cached_property
    def considered(self) -> Ints:
        """States that are considered: not estimated, but their covariance counts."""
        return self._states(considered_blocks(self.gyro, self.sensors))

    @cached_property
    def calibrated(self) -> Ints:
        """States that a plan calibrates: neither processes of sensors nor considered."""
        left_out = uncalibrated(self.gyro, self.sensors)
        return self._states([block for block in self.blocks if block not in left_out])

    @cached_property
    def n_vectors(self) -> int:
        """Number of vectors that the orbit gives: one for each sensor, then all gradients."""
        return len(self.sensors) + sum(sensor.n_gradient for sensor in self.sensors)

    def gradient_rows(self, index: int) -> slice:
        """Which of these vectors are the columns of a sensor's gradient; empty if it has none."""
        first = len(self.sensors) + sum(s.n_gradient for s in self.sensors[:index])
        return slice(first, first + self.sensors[index].n_gradient)

    @cached_property
    def rotations(self) -> tuple[int, ...]:
        """First states of the blocks that are rotations, that of the attitude first."""
        owners: tuple[Gyro | Sensor, ...] = (self.gyro, *self.sensors)
        placed = ((state, first, o) for o in owners for state, first in self.places(o).items())
        return (0, *(first for state, first, owner in placed if state in owner.rotations))

    def places(self, owner: Gyro | Sensor) -> dict[str, int]:
        """Number of the first of the three states of each of the gyro's or a sensor's states."""
        name = "gyro" if isinstance(owner, Gyro) else owner.name
        return {state: 3 * self.blocks.index(f"{name}.{state}") for state in owner.states()}

    def initial_sigma(self, attitude_sigma: float) -> Floats:
        """Initial 1-sigma of every state, shape (n_states,), for an attitude 1-sigma [rad]."""
        sigmas = np.full(self.n_states, attitude_sigma)
        owners: tuple[Gyro | Sensor, ...] = (self.gyro, *self.sensors)
        for owner in owners:
            for state, value in owner.states().items():
                first = self.places(owner)[state]
                sigmas[first : first + 3] = sigma_of(value)
        return sigmas

    def measure(
        self,
        sensor: Sensor,
        v: Vec3,
        column: Sequence[Any],
        to_body: Callable[[Vec3], Vec3] = lambda vector: vector,
        gradient: Sequence[Vec3] = (),
    ) -> tuple[Any, ...]:
        """Apply a sensor's H to a state column: the numbers of `Sensor.measure`.

        Parameters
        ----------
        v : Vec3
            Its reference vector in body axes.
        to_body : function
            From GCRS to body axes; default: they are the same.
        gradient : sequence of Vec3
            Columns of its gradient in body axes.
        """
        own = {state: self._block(column, f"{sensor.name}.{state}") for state in sensor.states()}
        theta = self._block(column, "attitude")
        x = SimpleNamespace(theta=theta, to_body=to_body, gradient=gradient, **own)
        return tuple(sensor.measure(x, v))

    def derivative(self, column: Sequence[Any], omega: Vec3) -> list[Any]:
        """Apply equation (2)'s dynamics to the `n_kinematic` leading states; floats only."""
        own = {state: self._block(column, f"gyro.{state}") for state in self.gyro.states()}
        rates = self.gyro.derivative(
            SimpleNamespace(theta=self._block(column, "attitude"), **own), omega
        )
        zero = Vec3(0.0, 0.0, 0.0)
        return [entry for state in ("theta", *own) for entry in rates.get(state, zero)]

    def dynamics_matrix(self, omega: Floats) -> Floats:
        """A in x' = A x for the dynamic states at body rate `omega` [rad/s]."""
        A, k = np.zeros((self.n_dynamic, self.n_dynamic)), self.n_kinematic
        for j, unit in enumerate(np.eye(k)):
            A[:k, j] = self.derivative(list(unit), Vec3(*omega))
        times = [process.correlation_time for process in self.processes.values()]
        A[range(k, len(A)), range(k, len(A))] = -1.0 / np.repeat(times, 3)
        return A

    def measurement_matrix(
        self,
        sensor: Sensor,
        v: Floats,
        attitude: Floats | None = None,
        gradient: Sequence[Floats] = (),
    ) -> Floats:
        """H of one sensor for its reference vector in body axes.

        Parameters
        ----------
        v : array, shape (..., 3)
        attitude : array, shape (..., 3, 3), optional
            GCRS to body; default: body axes along those of GCRS.
        gradient : sequence of arrays, shape (..., 3)
            The columns of the sensor's gradient, body axes; none if it has none.

        Returns
        -------
        array, shape (..., m, n_states), of the m numbers that it measures
        """
        H = np.zeros((*v.shape[:-1], len(sensor.noise()), self.n_states))
        components = Vec3(*np.moveaxis(v, -1, 0))
        columns = [Vec3(*np.moveaxis(column, -1, 0)) for column in gradient]
        C = np.eye(3) if attitude is None else attitude

        def to_body(vector: Vec3) -> Vec3:
            return Vec3(*(sum(C[..., i, k] * vk for k, vk in enumerate(vector)) for i in range(3)))

        for j, unit in enumerate(np.eye(self.n_states)):
            y = self.measure(sensor, components, list(unit), to_body, columns)
            for i, entry in enumerate(y):
                H[..., i, j] = entry
        return H

    def diffusion(self) -> Floats:
        """Diagonal of the process-noise density of the dynamic states, shape (n_dynamic,)."""
        density = self.gyro.diffusion()
        gyro = [density.get(state, 0.0) for state in ("theta", *self.gyro.states())]
        return np.repeat([*gyro, *(process.density for process in self.processes.values())], 3)

    def _states(self, blocks: Iterable[str]) -> Ints:
        """States of blocks, one after the other."""
        first = np.array([3 * self.blocks.index(block) for block in blocks], dtype=np.int64)
        return np.add.outer(first, np.arange(3)).ravel()

    def _block(self, column: Sequence[Any], name: str) -> Vec3:
        start = 3 * self.blocks.index(name)
        return Vec3(*column[start : start + 3])


@dataclass(frozen=True)
class BlockUnit:
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
