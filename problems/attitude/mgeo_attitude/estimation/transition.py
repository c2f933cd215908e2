"""How errors and estimates go on from one sample to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mgeo_attitude.filter.discretization import discretize
from mgeo_attitude.filter.suite import Suite

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Transition:
    """A step of the states of attitude and gyro, the n_dynamic first; the last axis is for runs.

    Attributes
    ----------
    duration : float
        [s]
    F : array, shape (3, n_dynamic - 3, 1)
        What the gyro's errors add to that of the attitude, equation (7).
    Q : array, shape (n_dynamic, n_dynamic, 1)
        Process noise.
    decay : array, shape (n_dynamic - 3, 1)
        What a gyro state of one becomes, and its error.
    mean_bias : array, shape (3, 1)
        Mean over the step of a bias that is one at first.
    """

    duration: float
    F: Floats
    Q: Floats
    decay: Floats
    mean_bias: Floats

    @classmethod
    def of(cls, suite: Suite, rate: Sequence[float], duration: float) -> Transition:
        """At a body rate [rad/s]."""
        density = suite.diffusion()
        F, Q = discretize(suite.dynamics_matrix(np.array(rate)), density, duration)
        rest, _ = discretize(suite.dynamics_matrix(np.zeros(3)), density, duration)
        mean_bias = -np.diag(rest[:3, 3:6]) / duration
        F, Q = F[:3, 3:, None], Q[..., None]
        return cls(duration, F, Q, np.diag(rest)[3:, None], mean_bias[:, None])
