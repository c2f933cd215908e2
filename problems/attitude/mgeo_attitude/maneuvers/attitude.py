"""Where stretches of constant body rate lead."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mgeo_attitude._typing import Floats, Ints


def attitudes(
    rates: Floats, starts: Ints, n_steps: int, step: float, initial: Floats | None = None
) -> Floats:
    """Attitude at every sample of one design: GCRS to body, shape (n_steps + 1, 3, 3).

    Parameters
    ----------
    rates : array, shape (m, 3)
        Body rates of the maneuvers [rad/s].
    starts : array, shape (m,)
        Their first steps.
    initial : array, shape (3, 3), optional
        Attitude at the start; default: body axes along those of GCRS.
    """
    C = np.empty((n_steps + 1, 3, 3))
    C[0] = np.eye(3) if initial is None else initial
    for omega, first, last in zip(rates, starts, [*starts[1:], n_steps], strict=True):
        steps = np.arange(first, min(last, n_steps) + 1)
        if steps.size:
            turns = Rotation.from_rotvec(-np.outer((steps - first) * step, omega))
            C[steps] = turns.as_matrix() @ C[first]
    return C
