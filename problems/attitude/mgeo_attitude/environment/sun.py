"""Where the Sun is: IAU SOFA's planetary theory (VSOP2000, as epv00), in GCRS axes.

The direction is geometric: light time and the aberration by the Earth's motion (0.0057°) are not
in it, as an ideal Sun sensor model would remove them.
"""

from __future__ import annotations

import erfa
import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.constants import ASTRONOMICAL_UNIT
from mgeo_attitude.environment.time_frames import Instants


def sun_position(at: Instants) -> Floats:
    """Vectors from the Earth's center to the Sun [m], GCRS, shape (n, 3)."""
    heliocentric_earth, _ = erfa.epv00(at.midnight, at.tt)
    return np.asarray(-ASTRONOMICAL_UNIT * heliocentric_earth["p"])


def sun_direction(position: Floats, sun: Floats) -> Floats:
    """Unit vectors from satellites at `position` to the Sun at `sun`, both (n, 3) in m."""
    to_sun = sun - position
    return np.asarray(to_sun / np.linalg.norm(to_sun, axis=-1, keepdims=True))
