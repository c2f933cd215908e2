"""Star tracker that measures the attitude itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from ..fields import quantity
from ..vector import Vec3
from .base import Sensor

_ARCSEC_PER_DEG = 3600.0


@dataclass(frozen=True)
class StarTracker(Sensor):
    """y = θ - μ + w: small-angle attitude with the tracker's own misalignment μ.

    The boresight is body z; rotation about it is measured worse than the two cross axes.
    """

    kind: ClassVar[str] = "star-tracker"

    name: str = quantity("tracker", doc="name, unique in the suite; prefixes the sensor's states")
    noise_arcsec: float = quantity(
        10.0, unit="arcsec", low=0.0, open_low=True, doc="noise about the cross axes, 1-sigma"
    )
    roll_noise_arcsec: float = quantity(
        60.0, unit="arcsec", low=0.0, open_low=True, doc="noise about the boresight z, 1-sigma"
    )
    misalignment_deg: float = quantity(
        0.2, unit="deg", low=0.0, open_low=True, doc="initial misalignment, 1-sigma per axis"
    )

    def states(self) -> dict[str, float]:
        return {"misalignment": math.radians(self.misalignment_deg)}

    def measure(self, x: Any, v: Vec3) -> Vec3:
        y: Vec3 = x.theta - x.misalignment
        return y

    def noise(self) -> tuple[float, float, float]:
        cross_axis = math.radians(self.noise_arcsec / _ARCSEC_PER_DEG)
        roll = math.radians(self.roll_noise_arcsec / _ARCSEC_PER_DEG)
        return (cross_axis, cross_axis, roll)
