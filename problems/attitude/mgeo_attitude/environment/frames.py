"""Rotations between GCRS, TEME, the rotating Earth (ITRS) and frames of others.

No Earth orientation parameters are used: UT1 = UTC (they differ by less than 0.9 s, 0.004° of
Earth rotation) and no polar motion (below 1 arc second). On the ground that is up to 420 m.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import erfa
import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import Instants


def gcrs_to_itrs(at: Instants) -> Floats:
    """Rotation matrices, shape (n, 3, 3), that take GCRS vectors to ITRS."""
    return np.asarray(erfa.rz(erfa.era00(at.midnight, at.ut), _chord(erfa.c2i06a, at)))


def teme_to_gcrs(at: Instants) -> Floats:
    """Rotation matrices, shape (n, 3, 3), that take TEME vectors (SGP4) to GCRS.

    TEME has no official definition. As in Vallado et al., "Revisiting Spacetrack Report #3" (AIAA
    2006-6753), its x axis lies GMST (1982) west of the Earth's prime meridian, in the equator of
    date. Going through the Earth's rotation needs no equation of the equinoxes, and the angle used
    (GMST less Earth rotation angle) hardly depends on UT1.
    """
    angle = erfa.gmst82(at.midnight, at.ut) - erfa.era00(at.midnight, at.ut)
    cirs_to_gcrs = np.swapaxes(_chord(erfa.c2i06a, at), -1, -2)
    return np.asarray(cirs_to_gcrs @ erfa.rz(angle, np.eye(3)))


def rotate(matrices: Floats, vectors: Floats) -> Floats:
    """Apply matrices (n, 3, 3) to vectors (n, 3), one by one."""
    rotated: Floats = np.einsum("nij,nj->ni", matrices, vectors)
    return rotated


def _chord(series: Callable[[float, float], Floats], at: Instants) -> Floats:
    """Matrices of a series of IAU 2006/2000A, from GCRS, shape (n, 3, 3).

    They are linear between the first and last instant.
    The 2000A series takes 0.04 ms an instant. A chord differs from it by 2e-10 rad over a few
    hours, 3e-8 over a day and 1e-6 over two weeks (the fortnightly nutation).
    """
    first, last = (series(at.midnight, at.tt[k]) for k in (0, -1))
    span = at.tt[-1] - at.tt[0]
    weight = (at.tt - at.tt[0]) / (span or 1.0)  # a single instant has no span
    return np.asarray(first + weight[:, None, None] * (last - first))


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

#: What takes GCRS to the true or the mean equator and equinox of date: bias, precession and, for
#: the true one, nutation. The series of 1976 and 1980, of older software, are off by 3 m.
_OF_DATE = {"TOD": erfa.pnm06a, "MOD": erfa.pmat06}

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
        return np.swapaxes(_chord(_OF_DATE[frame], at), -1, -2)
    if frame == "TEME":
        return teme_to_gcrs(at)
    if frame == "ITRF":
        return np.swapaxes(gcrs_to_itrs(at), -1, -2)
    # EME2000's axes are 0.02 arc seconds from those of GCRS: the frame bias
    return np.eye(3) if frame == "GCRF" else np.asarray(erfa.bp06(at.midnight, at.tt[0])[0].T)
