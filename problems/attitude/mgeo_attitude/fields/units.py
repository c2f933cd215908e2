"""Units in which people read and write the error states; the filter has its own."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Unit:
    """An engineer's unit of a 3-vector of the state."""

    text: str  # as it is shown: deg/h
    suffix: str  # as it ends the names of keys, deg_h; empty for none
    factor: float  # from the filter's unit to this one

    def key(self, name: str) -> str:
        """The key under which a scenario file gives the quantity `name`."""
        return f"{name}_{self.suffix}" if self.suffix else name

    @property
    def key_factor(self) -> float:
        """From the filter's unit to that of the key: a key without a suffix has the filter's."""
        return self.factor if self.suffix else 1.0


DIMENSIONLESS = Unit("-", "", 1.0)
#: Of a part of a unit vector: the angle by which it turns the vector, if it is small.
ARCMIN = Unit("arcmin", "", 60.0 * math.degrees(1.0))
PPM = Unit("ppm", "", 1e6)
SECOND = Unit("s", "s", 1.0)
DEG = Unit("deg", "deg", math.degrees(1.0))
DEG_H = Unit("deg/h", "deg_h", 3600.0 * math.degrees(1.0))
