"""Positions and velocities of others, taken from their reference frame to GCRS."""

from __future__ import annotations

import re

import erfa
import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.time_frames import Instants, gcrs_to_itrs, rotate, teme_to_gcrs

#: Reference frames by the names that files have for them, as regular expressions: upper case and
#: without hyphens, blanks and underscores. The realizations of one frame differ by centimeters.
_NAMES = {
    "GCRF": r"(GCRF|GCRS|ICRF)\d*",
    "EME2000": r"EME2000|J2000",
    "TEME": r"TEME(OFDATE)?",
    "ITRF": r"(ITRF|ITRS)\d*|WGS84",
}

#: Rotation of the Earth [rad/s]: rate of its rotation angle (IERS Conventions 2010, eq. 5.15).
_EARTH_RATE = 2.0 * np.pi * 1.00273781191135448 / erfa.DAYSEC


def frame_name(text: str) -> str:
    """GCRF, EME2000, TEME or ITRF for any name of it; another frame is a ValueError."""
    plain = re.sub(r"[-_ ]", "", text.upper())
    for name, pattern in _NAMES.items():
        if re.fullmatch(pattern, plain):
            return name
    raise ValueError(
        f"reference frame {text!r:.60}: expected GCRF (ICRF, GCRS), EME2000 (J2000), TEME or ITRF "
        "(any of its years, WGS-84)"
    )


def to_gcrs(
    frame: str, at: Instants, position: Floats, velocity: Floats | None
) -> tuple[Floats, Floats | None]:
    """Position [m] and velocity [m/s], shape (n, 3), from a frame by `frame_name` to GCRS.

    The velocity is relative to the frame. TEME counts as inertial, as in `sgp4_gcrs`; ITRF turns.
    """
    rotation = _rotation(frame, at)
    if velocity is not None:
        if frame == "ITRF":
            x, y, _ = position.T
            velocity = velocity + _EARTH_RATE * np.stack([-y, x, np.zeros_like(x)], axis=1)
        velocity = rotate(rotation, velocity)
    return rotate(rotation, position), velocity


def _rotation(frame: str, at: Instants) -> Floats:
    """Matrices, shape (n, 3, 3), that take vectors of a frame to GCRS."""
    if frame == "TEME":
        return teme_to_gcrs(at)
    if frame == "ITRF":
        return np.swapaxes(gcrs_to_itrs(at), -1, -2)
    # EME2000's axes are 0.02 arc seconds from those of GCRS: the frame bias
    bias = np.eye(3) if frame == "GCRF" else erfa.bp06(at.midnight, at.tt[0])[0].T
    return np.broadcast_to(bias, (len(at.tt), 3, 3))
