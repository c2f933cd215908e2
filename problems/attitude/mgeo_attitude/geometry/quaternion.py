"""Attitude quaternions and body rates in the convention of CCSDS 504.0-B-2, annex F."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from mgeo_attitude._typing import Floats


def quaternions_from_matrices(matrices: Floats) -> Floats:
    """Convert GCRS-to-body matrices to attitude quaternions with the vector part first.

    The quaternion (e sin(φ/2), cos(φ/2)) represents the rotation by φ about e that rotates the GCRF
    axes to the body axes. The matrix of this rotation is the transpose of the matrix that
    transforms coordinates. The scalar part is not negative.

    Parameters
    ----------
    matrices : array, shape (n, 3, 3)
        GCRS-to-body matrices.

    Returns
    -------
    array, shape (n, 4)
        Quaternions from GCRF to body, vector part first.
    """
    q: Floats = Rotation.from_matrix(np.swapaxes(matrices, -1, -2)).as_quat()
    return q * _compute_signs(q)[:, None]


def interpolate_quaternions(times: Floats, matrices: Floats, output_times: Floats) -> Floats:
    """Interpolate attitude quaternions between the samples of an attitude history.

    The body rate is constant between samples. The scalar part of the first quaternion is not
    negative, and the sign does not jump between output times.

    Parameters
    ----------
    times : array, shape (n,)
        Sample times [s].
    matrices : array, shape (n, 3, 3)
        GCRS-to-body matrices, less than 180 degrees apart.
    output_times : array, shape (k,)
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
    """Derive body rates [rad/s] at given times, shape (k, 3), from an attitude history.

    The history is that of a constant-rate maneuver or a ramp. The mean rate between two samples is
    assigned to the middle of the interval. The rates at other times are interpolated or
    extrapolated linearly, which is exact for a constant rate and for a ramp.

    Parameters
    ----------
    times, matrices, output_times
        See `interpolate_quaternions`.
    """
    from scipy.interpolate import make_interp_spline  # This import takes long.

    step_rotations = Rotation.from_matrix(matrices[:-1] @ np.swapaxes(matrices[1:], -1, -2))
    rates: Floats = step_rotations.as_rotvec() / np.diff(times)[:, None]
    if len(rates) == 1:
        return np.repeat(rates, len(output_times), axis=0)
    middles = 0.5 * (times[:-1] + times[1:])
    interpolated: Floats = make_interp_spline(middles, rates, k=1)(output_times)
    return interpolated


def quaternion_derivatives(q: Floats, rates: Floats) -> Floats:
    """Return the time derivatives of attitude quaternions [1/s] for given body rates.

    The result has shape (k, 4). The derivative is ½ q ⊗ (ω, 0).

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
    """Return the sign of the scalar part of each quaternion.

    If the scalar part is zero, the sign is that of the next nonzero component. With a threshold,
    the sign at a rotation by 180 degrees does not depend on rounding.
    """
    order = q[:, [3, 0, 1, 2]]
    first = np.argmax(np.abs(order) > 1e-9, axis=1)
    return np.where(order[np.arange(len(q)), first] < 0.0, -1.0, 1.0)
