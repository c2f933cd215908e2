"""A sensor suite as one error state: names, columns as named vectors, dense twins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np

from .._typing import Floats
from ..scenario.settings import state_units
from ..sensors import Gyro, Sensor
from ..units import Unit
from ..vector import Vec3


@dataclass(frozen=True)
class Suite:
    """A gyro and the sensors that aid it.

    The error state is a list of 3-vectors, here called blocks: the attitude error, the gyro's
    states, then those of each sensor in turn. For the paper's suite these are θ, b, φ, δs, ψ, δB.
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
    def n_dynamic(self) -> int:
        """Number of leading states that enter the attitude kinematics: attitude and gyro."""
        return 3 * (1 + len(self.gyro.states()))

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
        sigmas = [attitude_sigma, *self.gyro.states().values()]
        for sensor in self.sensors:
            sigmas.extend(sensor.states().values())
        return np.repeat(np.asarray(sigmas, dtype=float), 3)

    def measure(self, sensor: Sensor, v: Vec3, column: Sequence[Any]) -> Vec3:
        """Apply a sensor's H, at reference vector `v` in body axes, to a state column."""
        own = {state: self._block(column, f"{sensor.name}.{state}") for state in sensor.states()}
        return sensor.measure(SimpleNamespace(theta=self._block(column, "attitude"), **own), v)

    def derivative(self, column: Sequence[Any], omega: Vec3) -> list[Any]:
        """Apply equation (2)'s dynamics to the `n_dynamic` leading states; floats only."""
        own = {state: self._block(column, f"gyro.{state}") for state in self.gyro.states()}
        rates = self.gyro.derivative(
            SimpleNamespace(theta=self._block(column, "attitude"), **own), omega
        )
        zero = Vec3(0.0, 0.0, 0.0)
        return [entry for state in ("theta", *own) for entry in rates.get(state, zero)]

    def dynamics_matrix(self, omega: Floats) -> Floats:
        """A in x' = A x for the dynamic states at body rate `omega` [rad/s]."""
        columns = [self.derivative(list(unit), Vec3(*omega)) for unit in np.eye(self.n_dynamic)]
        return np.array(columns, dtype=float).T.copy()

    def measurement_matrix(self, sensor: Sensor, v: Floats) -> Floats:
        """H of one sensor for its reference vector in body axes.

        Parameters
        ----------
        v : array, shape (..., 3)

        Returns
        -------
        array, shape (..., 3, n_states)
        """
        H = np.zeros((*v.shape, self.n_states))
        components = Vec3(*np.moveaxis(v, -1, 0))
        for j, unit in enumerate(np.eye(self.n_states)):
            for i, entry in enumerate(self.measure(sensor, components, list(unit))):
                H[..., i, j] = entry
        return H

    def diffusion(self) -> Floats:
        """Diagonal of the process-noise density of the dynamic states, shape (n_dynamic,)."""
        density = self.gyro.diffusion()
        return np.repeat([density.get(state, 0.0) for state in ("theta", *self.gyro.states())], 3)

    def _block(self, column: Sequence[Any], name: str) -> Vec3:
        start = 3 * self.blocks.index(name)
        return Vec3(*column[start : start + 3])
