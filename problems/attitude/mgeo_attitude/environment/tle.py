"""Two-line element sets by SGP4 (package `sgp4`, an extra), in GCRS.

SGP4 itself is good to about 1 km at the epoch of the set and loses 1 to 3 km a day; the rotation
from its frame adds less than 1 m.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..constants import DAY
from .time_frames import Instants, rotate, teme_to_gcrs

if TYPE_CHECKING:
    from sgp4.api import Satrec

Array = NDArray[np.float64]


class SGP4Error(ArithmeticError):
    """SGP4 cannot propagate an element set to the wanted instant."""


def sgp4_gcrs(line1: str, line2: str, at: Instants) -> tuple[Array, Array]:
    """Position [m] and velocity [m/s], GCRS, shape (n, 3), from the two (checked) lines of a set.

    The velocity takes TEME as inertial, which costs 1e-4 m/s in a low orbit.

    Raises
    ------
    ImportError
        If the package sgp4 is not installed.
    SGP4Error
        If SGP4 reports an error at some instant, such as a decayed satellite.
    """
    position, velocity = sgp4_teme(line1, line2, at)
    rotation = teme_to_gcrs(at)
    return rotate(rotation, position), rotate(rotation, velocity)


def sgp4_teme(line1: str, line2: str, at: Instants) -> tuple[Array, Array]:
    """As `sgp4_gcrs`, in SGP4's own frame, the true equator and mean equinox of date."""
    satellite = _satellite(line1, line2)
    codes, position, velocity = satellite.sgp4_array(np.full_like(at.ut, at.midnight), at.ut)
    failed = np.flatnonzero(codes)
    if failed.size:
        from sgp4.api import SGP4_ERRORS

        seconds = (at.ut[failed[0]] - at.ut[0]) * DAY
        raise SGP4Error(
            f"satellite {line1[2:7]}: SGP4 error {codes[failed[0]]} at t = {seconds:.1f} s, "
            f"{SGP4_ERRORS[int(codes[failed[0]])]}"
        )
    return 1e3 * position, 1e3 * velocity


def _satellite(line1: str, line2: str) -> Satrec:
    try:
        from sgp4.api import Satrec
    except ImportError as error:
        raise ImportError(
            'a two-line element set needs the package sgp4: pip install "mgeo-attitude[tle]"'
        ) from error
    return Satrec.twoline2rv(line1, line2)  # with WGS72, for which element sets are made
