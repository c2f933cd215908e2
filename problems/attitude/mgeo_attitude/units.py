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
        """The key under which a scenario file gives the quantity `name` in this unit."""
        return f"{name}_{self.suffix}" if self.suffix else name


DIMENSIONLESS = Unit("-", "", 1.0)
DEG = Unit("deg", "deg", math.degrees(1.0))
DEG_H = Unit("deg/h", "deg_h", 3600.0 * math.degrees(1.0))
