"""How near the Sun comes to body axes that must stay off it, with a margin for the attitude.

The attitude at a sample was flown on what the filter knew until then: the margin is taken from the
covariance as predicted, before the measurements of that sample. Equation (14) of docs/theory.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .model import FilterModel
    from .reference import FilterHistory

Floats = NDArray[np.float64]

#: Sine of the angle below which Sun and axis are parallel: no single turn changes the angle then.
PARALLEL = 1e-6


def sun_clearance(axis: Floats, sigmas: float, sun: Floats, covariance: Floats) -> Floats:
    """Angle between the Sun and an axis, less so many of its 1-sigmas [rad], shape (n,).

    Parameters
    ----------
    axis : array, shape (3,)
        Unit vector, body axes.
    sigmas : float
        Margin, in 1-sigmas of the angle.
    sun : array, shape (n, 3)
        Unit vector to the Sun, body axes; zero where it does not shine, and there is no angle:
        infinity.
    covariance : array, shape (n, 3, 3)
        Of the attitude error, body axes [rad²].
    """
    sine = np.linalg.norm(np.cross(axis, sun), axis=-1)
    angle = np.arctan2(sine, sun @ axis)
    clearance: Floats = np.where(
        sun.any(axis=-1), angle - sigmas * angle_sigma(axis, sun, covariance), np.inf
    )
    return clearance


def angle_sigma(axis: Floats, sun: Floats, covariance: Floats) -> Floats:
    """1-sigma of the angle between the Sun and an axis [rad], shape (n,); see `sun_clearance`.

    A turn about the normal of both changes the angle, and about no other direction to first order.
    Where they are parallel there is no normal: of all turns across the axis the least known counts.
    """
    normal = np.cross(axis, sun)
    sine = np.linalg.norm(normal, axis=-1)
    parallel = sine < PARALLEL
    unit = normal / np.where(parallel, 1.0, sine)[:, None]
    variance = np.einsum("ki,kij,kj->k", unit, covariance, unit)
    across = np.eye(3) - np.outer(axis, axis)
    variance[parallel] = np.linalg.eigvalsh(across @ covariance[parallel] @ across)[:, -1]
    sigma: Floats = np.sqrt(variance)
    return sigma


def sun_clearances(model: FilterModel, history: FilterHistory) -> Floats:
    """`sun_clearance` of every watched axis along a run of the filter, shape (n, n_cones)."""
    n = len(history.times)
    clearances = np.empty((n, len(model.cones)))
    if clearances.size:
        sun = np.einsum("kij,kj->ki", history.attitude, model.sun[:n])
        for i, (axis, sigmas) in enumerate(zip(model.cones, model.cone_sigmas, strict=True)):
            clearances[:, i] = sun_clearance(axis, sigmas, sun, history.predicted_attitude)
    return clearances
