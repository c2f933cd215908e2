"""Rotations between GCRS, EME2000, TOD, TEME, ITRS and LVLH.

Earth orientation parameters are neglected: UT1 equals UTC (the difference is below 0.9 s, or 0.004°
of Earth rotation), and there is no polar motion (below 1 arc second). The position error on the
ground is at most 420 m.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import erfa
import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import JulianDates


def gcrs_to_itrs(at: JulianDates) -> Floats:
    """Return the rotation matrix from GCRS to ITRS at each instant, shape (n, 3, 3)."""
    return np.asarray(erfa.rz(erfa.era00(at.midnight, at.ut), _gcrs_to_cirs(at)))


def teme_to_gcrs(at: JulianDates) -> Floats:
    """Return the rotation matrix from TEME to GCRS at each instant, shape (n, 3, 3).

    TEME is the frame of SGP4. TEME has no official definition. As in Vallado et al., "Revisiting
    Spacetrack Report #3" (AIAA 2006-6753), its x axis is in the equator of date, at an angle of
    GMST (1982) west of the Earth's prime meridian. The rotation passes through the Earth-fixed
    frame, which avoids the equation of the equinoxes, and its angle (GMST minus Earth rotation
    angle) hardly depends on UT1.
    """
    angle = erfa.gmst82(at.midnight, at.ut) - erfa.era00(at.midnight, at.ut)
    cirs_to_gcrs = np.swapaxes(_gcrs_to_cirs(at), -1, -2)
    return np.asarray(cirs_to_gcrs @ erfa.rz(angle, np.eye(3)))


def rotate(matrices: Floats, vectors: Floats) -> Floats:
    """Multiply n matrices, shape (n, 3, 3), by n vectors, shape (n, 3)."""
    rotated: Floats = np.einsum("nij,nj->ni", matrices, vectors)
    return rotated


def _gcrs_to_cirs(at: JulianDates) -> Floats:
    """Return the rotation matrix from GCRS to CIRS at each instant, shape (n, 3, 3).

    The precession-nutation model is IAU 2006/2000A. The matrices are interpolated linearly between
    the first and the last instant, since the 2000A series takes 0.04 ms per instant. The
    interpolation error is 2e-10 rad over a few hours, 3e-8 rad over a day and 1e-6 rad over two
    weeks (fortnightly nutation).
    """
    return _interpolate_matrices(erfa.c2i06a, at)


def _interpolate_matrices(matrix: Callable[[float, float], Floats], at: JulianDates) -> Floats:
    first, last = (matrix(at.midnight, at.tt[k]) for k in (0, -1))
    span = at.tt[-1] - at.tt[0]
    weight = (at.tt - at.tt[0]) / (span or 1.0)  # The span of a single instant is zero.
    return np.asarray(first + weight[:, None, None] * (last - first))


#: Patterns of the names of reference frames in files, in upper case and without hyphens, blanks and
#: underscores. Realizations of a frame differ by centimeters and are not distinguished.
_FRAME_PATTERNS = {
    "GCRF": r"(GCRF|GCRS|ICRF)\d*",
    "EME2000": r"EME2000|J2000",
    "TOD": r"TOD|TRUEOFDATE",
    "TEME": r"TEME(OFDATE)?",
    "ITRF": r"(ITRF|ITRS)\d*|WGS84",
}

#: Rotation rate of the Earth [rad/s], the rate of the Earth rotation angle (IERS Conventions 2010,
#: eq. 5.15).
_EARTH_RATE = 2.0 * np.pi * 1.00273781191135448 / erfa.DAYSEC


def parse_frame_name(text: str) -> str:
    """Convert the name of a reference frame in a file to its standard name.

    The standard names are GCRF, EME2000, TOD, TEME and ITRF.

    Raises
    ------
    ValueError
        If the frame is not supported.
    """
    plain = re.sub(r"[-_ ]", "", text.upper())
    for name, pattern in _FRAME_PATTERNS.items():
        if re.fullmatch(pattern, plain):
            return name
    raise ValueError(
        f"reference frame {text!r:.60}: expected GCRF (ICRF, GCRS), EME2000 (J2000), TOD, TEME "
        "or ITRF (any of its years, WGS-84)"
    )


def convert_to_gcrs(
    frame: str, at: JulianDates, position: Floats, velocity: Floats | None
) -> tuple[Floats, Floats | None]:
    """Convert positions [m] and velocities [m/s] from a named reference frame to GCRS.

    Both arrays have the shape (n, 3). The frame is one of `parse_frame_name`. The velocity is
    relative to the frame. ITRF rotates, and TEME is treated as inertial, as in
    `compute_gcrs_states`.
    """
    rotation = rotation_to_gcrs(frame, at)
    if velocity is not None:
        if frame == "ITRF":
            x, y, _ = position.T
            velocity = velocity + _EARTH_RATE * np.stack([-y, x, np.zeros_like(x)], axis=1)
        velocity = rotate(rotation, velocity)
    return rotate(rotation, position), velocity


def rotation_to_gcrs(frame: str, at: JulianDates) -> Floats:
    """Return the rotation matrix from a named frame to GCRS at each instant, shape (n, 3, 3)."""
    if frame == "TEME":
        return teme_to_gcrs(at)
    if frame == "ITRF":
        return np.swapaxes(gcrs_to_itrs(at), -1, -2)
    if frame == "TOD":  # The axes are the true equator and equinox of date, IAU 2006/2000A.
        return np.swapaxes(_interpolate_matrices(erfa.pnm06a, at), -1, -2)
    # The frame bias between EME2000 and GCRS is 0.02 arc seconds.
    fixed = np.eye(3) if frame == "GCRF" else erfa.bp06(at.midnight, at.tt[0])[0].T
    return np.broadcast_to(fixed, (len(at.tt), 3, 3))


def lvlh_to_gcrs(position: Floats, velocity: Floats) -> Floats:
    """Return the rotation matrix from LVLH to GCRS at each instant, shape (n, 3, 3).

    In LVLH (local vertical, local horizontal), z points to the Earth's center, y is opposite to the
    orbital angular momentum, and x = y × z points forward.
    """
    z = -position / np.linalg.norm(position, axis=1, keepdims=True)
    y = -np.cross(position, velocity)
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.stack([np.cross(y, z), y, z], axis=-1)
