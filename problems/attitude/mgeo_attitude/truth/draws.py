"""What chance decides in one run: true errors at the start and every noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..filter.discretization import discretize
from ..filter.model import FilterModel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Draws:
    """Numbers of one run of n steps.

    Attributes
    ----------
    errors : array, shape (n_states,)
        True attitude error, gyro and sensor states at the start. Those that are rotations are
        vectors of `rotation.rotate`.
    gyro_noise : array, shape (n, n_dynamic)
        What noise adds in each step to the attitude error and the gyro's states, at rest.
    noise : array, shape (n + 1, n_sensors, 3)
        Measurement noise of every sensor at every sample.
    """

    errors: Floats
    gyro_noise: Floats
    noise: Floats


def at_rest(model: FilterModel) -> tuple[Floats, Floats]:
    """Transition and process noise of one step without rotation, both (n_dynamic, n_dynamic).

    Exact, the Markov process of equation (2) and its integral over the step together.
    """
    A = model.suite.dynamics_matrix(np.zeros(3))
    F, Q = discretize(A, model.suite.diffusion(), model.step)
    return F, Q


def draw(model: FilterModel, n_steps: int, generator: np.random.Generator) -> Draws:
    """Draw one run of a scenario."""
    suite = model.suite
    _, Q = at_rest(model)
    variances, axes = np.linalg.eigh(Q)  # a bias that does not drift has no Cholesky factor
    root = axes * np.sqrt(np.maximum(variances, 0.0))
    sigma = np.array([sensor.noise() for sensor in suite.sensors])
    errors = model.initial_sigma * generator.standard_normal(suite.n_states)
    drive = generator.standard_normal((n_steps, suite.n_dynamic))
    noise = sigma * generator.standard_normal((n_steps + 1, len(suite.sensors), 3))
    return Draws(errors, np.einsum("kj,ij->ki", drive, root), noise)


def none(model: FilterModel, n_steps: int) -> Draws:
    """A run without any error or noise."""
    suite = model.suite
    return Draws(
        np.zeros(suite.n_states),
        np.zeros((n_steps, suite.n_dynamic)),
        np.zeros((n_steps + 1, len(suite.sensors), 3)),
    )
