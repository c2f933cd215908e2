"""Positions and velocities of others, taken from their reference frame to GCRS."""

from __future__ import annotations

import re

import erfa
import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.time_frames import (
    Instants,
    gcrs_to_itrs,
    mean_of_date_to_gcrs,
    rotate,
    teme_to_gcrs,
    true_of_date_to_gcrs,
)

#: Reference frames by the names that files have for them, as regular expressions: upper case and
#: without hyphens, blanks and underscores. The realizations of one frame differ by centimeters.
_NAMES = {
    "GCRF": r"(GCRF|GCRS|ICRF)\d*",
    "EME2000": r"EME2000|J2000",
    "TEME": r"TEME(OF(DATE|EPOCH))?",
    "TOD": r"TOD(EARTH)?|TRUEOFDATE",
    "MOD": r"MOD(EARTH)?|MEANOFDATE",
    "ITRF": r"(ITRF|ITRS)\d*|WGS84",
}

_OF_DATE = {"TEME": teme_to_gcrs, "TOD": true_of_date_to_gcrs, "MOD": mean_of_date_to_gcrs}

#: Rotation of the Earth [rad/s]: rate of its rotation angle (IERS Conventions 2010, eq. 5.15).
_EARTH_RATE = 2.0 * np.pi * 1.00273781191135448 / erfa.DAYSEC


def frame_name(text: str) -> str:
    """GCRF, EME2000, TEME, TOD, MOD or ITRF for any name of it; another is a ValueError."""
    plain = re.sub(r"[-_ ]", "", text.upper())
    for name, pattern in _NAMES.items():
        if re.fullmatch(pattern, plain):
            return name
    raise ValueError(
        f"reference frame {text!r:.60}: expected GCRF (ICRF, GCRS), EME2000 (J2000), TEME, TOD, "
        "MOD or ITRF (any of its years, WGS-84)"
    )


def of_epoch(text: str) -> bool:
    """Whether a frame, by any of its names, is that of one instant, which a file has to name."""
    return re.sub(r"[-_ ]", "", text.upper()) == "TEMEOFEPOCH"


def to_gcrs(
    frame: str,
    at: Instants,
    position: Floats,
    velocity: Floats | None,
    frozen: Instants | None = None,
) -> tuple[Floats, Floats | None]:
    """Position [m] and velocity [m/s], shape (n, 3), from a frame by `frame_name` to GCRS.

    The velocity is relative to the frame. Those of date count as inertial, as in `gcrs_of`, and
    their axes may be those of one instant, `frozen`; ITRF turns, and with one is a ValueError.
    """
    if frozen is not None and frame == "ITRF":
        raise ValueError("REF_FRAME_EPOCH: expected none for a frame that turns with the Earth")
    rotation = _rotation(frame, at if frozen is None else frozen)
    rotation = np.broadcast_to(rotation, (len(position), 3, 3))
    if velocity is not None:
        if frame == "ITRF":
            x, y, _ = position.T
            velocity = velocity + _EARTH_RATE * np.stack([-y, x, np.zeros_like(x)], axis=1)
        velocity = rotate(rotation, velocity)
    return rotate(rotation, position), velocity


def _rotation(frame: str, at: Instants) -> Floats:
    """Matrices, shape (n, 3, 3) or (3, 3), that take vectors of a frame to GCRS."""
    if frame in _OF_DATE:
        return _OF_DATE[frame](at)
    if frame == "ITRF":
        return np.swapaxes(gcrs_to_itrs(at), -1, -2)
    # EME2000's axes are 0.02 arc seconds from those of GCRS: the frame bias
    return np.eye(3) if frame == "GCRF" else np.asarray(erfa.bp06(at.midnight, at.tt[0])[0].T)
