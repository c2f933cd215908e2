"""Transition and process noise of a step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.kernel import load_driver
from mgeo_attitude.sensors.suite import Suite


def transition(suite: Suite, rate: Sequence[float], duration: float) -> tuple[Floats, Floats]:
    """F and Q of the dynamic states over a step at constant rate, equation (7).

    Parameters
    ----------
    suite : Suite
    rate : sequence of 3 floats
        Of the body [rad/s].
    duration : float
        Of the step [s].

    Returns
    -------
    F, Q : arrays, shape (n_dynamic, n_dynamic)
    """
    A, density = suite.dynamics_matrix(np.array(rate)), suite.diffusion()
    F, Q = load_driver().discretized(A, density, duration)
    return F, Q
