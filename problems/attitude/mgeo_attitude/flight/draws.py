"""What chance decides in a run: true errors at the start and every noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.discretization import discretize
from mgeo_attitude.filter.model import FilterModel


@dataclass(frozen=True)
class Draws:
    """Numbers of a run of n steps.

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


def draw(model: FilterModel, n_steps: int, generator: np.random.Generator) -> Draws:
    """Draw a run of a scenario."""
    suite = model.suite
    _, Q = at_rest(model)
    variances, axes = np.linalg.eigh(Q)  # a bias that does not drift has no Cholesky factor
    root = axes * np.sqrt(np.maximum(variances, 0.0))
    sigma = np.array([sensor.noise() for sensor in suite.sensors])
    return Draws(
        model.initial_sigma * generator.standard_normal(suite.n_states),
        np.einsum("kj,ij->ki", generator.standard_normal((n_steps, suite.n_dynamic)), root),
        sigma * generator.standard_normal((n_steps + 1, *sigma.shape)),
    )


def at_rest(model: FilterModel) -> tuple[Floats, Floats]:
    """Transition and process noise of one step without rotation, both (n_dynamic, n_dynamic).

    Exact, the Markov process of equation (2) and its integral over the step together.
    """
    A = model.suite.dynamics_matrix(np.zeros(3))
    F, Q = discretize(A, model.suite.diffusion(), model.step)
    return F, Q
