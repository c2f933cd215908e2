"""Quaternions and body rates of attitudes as the CCSDS writes them: 504.0-B-2, annex F."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from mgeo_attitude._typing import Floats


def quaternions(matrices: Floats) -> Floats:
    """Quaternions "from GCRF to body", vector first, shape (n, 4), of GCRS-to-body matrices.

    (e sin(φ/2), cos(φ/2)) for the rotation by φ about e that takes the axes of GCRF to those of the
    body; it is the transpose of a matrix that turns a vector's *coordinates* from the first frame
    to the second. Of the two quaternions the one whose scalar is not negative.
    """
    found: Floats = Rotation.from_matrix(np.swapaxes(matrices, -1, -2)).as_quat()
    return found * _signs(found)[:, None]


def sampled_quaternions(times: Floats, matrices: Floats, at: Floats) -> Floats:
    """Quaternions at times `at`, shape (k, 4), without jumps of sign between neighbors.

    Between the samples of `times` and GCRS-to-body `matrices`, less than 180 degrees from each to
    the next, the body turns at constant rate. The first scalar is not negative.
    """
    rotations = Rotation.from_matrix(np.swapaxes(matrices, -1, -2))
    found: Floats = Slerp(times, rotations)(at).as_quat()
    jumps = np.where(np.einsum("ki,ki->k", found[:-1], found[1:]) < 0.0, -1.0, 1.0)
    return found * np.cumprod(np.append(_signs(found[:1]), jumps))[:, None]


def body_rates(times: Floats, matrices: Floats, at: Floats) -> Floats:
    """Body rates [rad/s] at times `at`, shape (k, 3), of a stretch of constant rate or a ramp.

    Each step between the samples of `times` and GCRS-to-body `matrices` has the rate of its middle;
    between the middles, and to the ends, rates go linearly, as a ramp's do.
    """
    from scipy.interpolate import make_interp_spline  # which takes long to import

    turns = Rotation.from_matrix(matrices[:-1] @ np.swapaxes(matrices[1:], -1, -2))
    rates: Floats = turns.as_rotvec() / np.diff(times)[:, None]
    if len(rates) == 1:
        return np.repeat(rates, len(at), axis=0)
    middles = 0.5 * (times[:-1] + times[1:])
    found: Floats = make_interp_spline(middles, rates, k=1)(at)
    return found


def quaternion_derivatives(q: Floats, rates: Floats) -> Floats:
    """dq/dt [1/s] of `quaternions`, shape (k, 4), vector first, at body rates [rad/s], (k, 3).

    It is ½ q ⊗ (ω, 0).
    """
    vector, scalar = q[:, :3], q[:, 3:]
    turned = scalar * rates + np.cross(vector, rates)
    return 0.5 * np.hstack([turned, -np.einsum("ki,ki->k", vector, rates)[:, None]])


def _signs(q: Floats) -> Floats:
    """What makes scalars positive, or where they are zero the first other component that is not.

    Rounding decides nothing: a half turn has the same quaternion on every machine.
    """
    order = q[:, [3, 0, 1, 2]]
    first = np.argmax(np.abs(order) > 1e-9, axis=1)
    return np.where(order[np.arange(len(q)), first] < 0.0, -1.0, 1.0)
