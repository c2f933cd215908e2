"""Where the Moon is: the truncated lunar theory of Meeus, as erfa's moon98, in GCRS axes.

J. Meeus, Astronomical Algorithms, 2nd edition (1998), chapter 47. Against ELP/MPP02 its direction
is off by 2.9 arcsec rms and 18 at worst (1950 to 2100), which is less than a hundredth of the disc.
"""

from __future__ import annotations

import erfa
import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import ASTRONOMICAL_UNIT
from mgeo_attitude.environment.time_frames import Instants


def moon_position(at: Instants) -> Floats:
    """Vectors from the Earth's center to the Moon's [m], GCRS, shape (n, 3); geometric."""
    return np.asarray(ASTRONOMICAL_UNIT * erfa.moon98(at.midnight, at.tt)["p"])
