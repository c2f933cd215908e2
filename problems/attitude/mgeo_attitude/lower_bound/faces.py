"""Upper bound on the attitude information of photodiodes, few of which the Sun illuminates at
once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.photodiode import Photodiode

#: Approximate number of points on the sphere.
_N_POINTS = 60000


def bound_joint_information(diodes: Sequence[Photodiode]) -> float:
    """Return an upper bound on the Fisher information about the attitude that several photodiodes
    provide in one sample.

    At any attitude, the joint information of a sample is at most κ (I - s sᵀ), where κ is the
    returned value and s the Sun direction. A diode with relative noise r has the information w (n ×
    s) (n × s)ᵀ with w = 1 / r² if the angle between the Sun and its normal n is less than its
    half-angle. The largest eigenvalue of the sum is the squared norm of the matrix of all √w (n ×
    s), which changes by at most √(Σ w) δ over an angle δ. The sum is evaluated at points so dense
    that every direction is within δ of a point. A diode is included at a point if it is illuminated
    anywhere within δ.
    """
    return _compute_bound(
        tuple((tuple(d.axes[2].tolist()), d.half_angle_deg, d.noise_sigmas()[0]) for d in diodes)
    )


@cache
def _compute_bound(diodes: tuple[tuple[tuple[float, ...], float, float], ...]) -> float:
    """Return the upper bound of `bound_joint_information`. The hashable arguments make the result
    cacheable.

    The properties of a diode are its normal, half-angle [deg] and relative noise.
    """
    points, radius = _build_points()
    normals = np.array([normal for normal, _, _ in diodes])
    weights = np.array([1.0 / noise for _, _, noise in diodes])
    is_illuminated = points @ normals.T >= np.cos(
        np.radians([half for _, half, _ in diodes]) + radius
    )
    rows = np.where(
        is_illuminated[:, :, None], weights[:, None] * np.cross(normals, points[:, None]), 0.0
    )
    norms = np.sqrt(np.linalg.eigvalsh(np.einsum("pia,pib->pab", rows, rows))[:, -1])
    slopes = np.sqrt(is_illuminated @ weights**2)
    return float((norms + radius * slopes).max() ** 2)


@cache
def _build_points() -> tuple[Floats, float]:
    """Return points that cover the unit sphere, shape (n, 3), and the covering angle [rad].

    Every direction is within this angle of at least one point. The points are the centers of cells
    between parallels and meridians. A direction is at most half a cell width, along its parallel,
    from the central meridian of its cell, and then half a cell height from the center.
    """
    n = round(np.sqrt(_N_POINTS * np.pi / 4.0))
    step = np.pi / n
    points = []
    for latitude in -0.5 * np.pi + step * (np.arange(n) + 0.5):
        widest = np.cos(max(abs(latitude) - 0.5 * step, 0.0))
        count = max(3, int(np.ceil(2.0 * n * widest)))
        longitude = 2.0 * np.pi / count * np.arange(count)
        points.append(
            np.column_stack(
                [
                    np.cos(latitude) * np.cos(longitude),
                    np.cos(latitude) * np.sin(longitude),
                    np.full(count, np.sin(latitude)),
                ]
            )
        )
    return np.concatenate(points), step
