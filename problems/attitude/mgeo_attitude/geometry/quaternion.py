"""Quaternions and body rates in the convention of CCSDS 504.0-B-2, annex F."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from mgeo_attitude._typing import Floats


def quaternions_from_matrices(matrices: Floats) -> Floats:
    """Convert GCRS-to-body matrices to quaternions "from GCRF to body", vector part first.

    The quaternion (e sin(φ/2), cos(φ/2)) belongs to the rotation by φ about e that takes the GCRF
    axes to the body axes. Its matrix is the transpose of the matrix that transforms coordinates.
    The scalar part is not negative.

    Parameters
    ----------
    matrices : array, shape (n, 3, 3)

    Returns
    -------
    array, shape (n, 4)
    """
    q: Floats = Rotation.from_matrix(np.swapaxes(matrices, -1, -2)).as_quat()
    return q * _compute_signs(q)[:, None]


def interpolate_quaternions(times: Floats, matrices: Floats, output_times: Floats) -> Floats:
    """Interpolate an attitude history to quaternions at given times, without sign jumps.

    The body rate is constant between samples. The first scalar part is not negative.

    Parameters
    ----------
    times : array, shape (n,)
        Sample times [s].
    matrices : array, shape (n, 3, 3)
        GCRS-to-body matrices, less than 180 degrees apart.
    at : array, shape (k,)
        Output times [s].

    Returns
    -------
    array, shape (k, 4)
        Quaternions, vector part first; see `quaternions_from_matrices`.
    """
    rotations = Rotation.from_matrix(np.swapaxes(matrices, -1, -2))
    q: Floats = Slerp(times, rotations)(output_times).as_quat()
    jumps = np.where(np.einsum("ki,ki->k", q[:-1], q[1:]) < 0.0, -1.0, 1.0)
    return q * np.cumprod(np.append(_compute_signs(q[:1]), jumps))[:, None]


def interpolate_body_rates(times: Floats, matrices: Floats, output_times: Floats) -> Floats:
    """Return body rates [rad/s] at given times of a constant-rate maneuver or ramp, shape (k, 3).

    The rate between two samples applies at the middle of the interval. Other times are interpolated
    or extrapolated linearly, which is exact for a ramp.

    Parameters
    ----------
    times, matrices, at
        See `interpolate_quaternions`.
    """
    from scipy.interpolate import make_interp_spline  # This import takes long.

    turns = Rotation.from_matrix(matrices[:-1] @ np.swapaxes(matrices[1:], -1, -2))
    rates: Floats = turns.as_rotvec() / np.diff(times)[:, None]
    if len(rates) == 1:
        return np.repeat(rates, len(output_times), axis=0)
    middles = 0.5 * (times[:-1] + times[1:])
    interpolated: Floats = make_interp_spline(middles, rates, k=1)(output_times)
    return interpolated


def quaternion_derivatives(q: Floats, rates: Floats) -> Floats:
    """Return the time derivatives ½ q ⊗ (ω, 0) of quaternions [1/s], shape (k, 4).

    Parameters
    ----------
    q : array, shape (k, 4)
        Quaternions, vector part first; see `quaternions_from_matrices`.
    rates : array, shape (k, 3)
        Body rates [rad/s].
    """
    vector, scalar = q[:, :3], q[:, 3:]
    vector_part = scalar * rates + np.cross(vector, rates)
    return 0.5 * np.hstack([vector_part, -np.einsum("ki,ki->k", vector, rates)[:, None]])


def _compute_signs(q: Floats) -> Floats:
    """Return the sign, ±1, of the scalar part, or of the first other nonzero component.

    A threshold makes the choice for half turns independent of rounding.
    """
    order = q[:, [3, 0, 1, 2]]
    first = np.argmax(np.abs(order) > 1e-9, axis=1)
    return np.where(order[np.arange(len(q)), first] < 0.0, -1.0, 1.0)
