"""Star tracker that measures the attitude itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ..fields import positive, quantity
from ..rotation import rotate
from ..units import DEG, Unit
from ..vector import AXES, ZERO, Vec3, cross, dot
from .base import Sensor

_ARCSEC_PER_DEG = 3600.0


@dataclass(frozen=True)
class StarTracker(Sensor):
    """y = θ - μ + w: small-angle attitude with the tracker's own misalignment μ.

    The boresight is body z; rotation about it is measured worse than the two cross axes.
    """

    kind: ClassVar[str] = "star-tracker"
    rotations: ClassVar[tuple[str, ...]] = ("misalignment",)
    units: ClassVar[Mapping[str, Unit]] = {"misalignment": DEG}

    name: str = quantity("tracker", doc="name, unique in the suite; prefixes the sensor's states")
    noise_arcsec: float = positive(10.0, unit="arcsec", doc="noise about the cross axes, 1-sigma")
    roll_noise_arcsec: float = positive(
        60.0, unit="arcsec", doc="noise about the boresight z, 1-sigma"
    )
    misalignment_deg: float = positive(
        0.2, unit="deg", doc="initial misalignment, 1-sigma per axis"
    )

    def states(self) -> dict[str, float]:
        return {"misalignment": math.radians(self.misalignment_deg)}

    def measure(self, x: Any, v: Vec3) -> Vec3:
        y: Vec3 = x.theta - x.misalignment
        return y

    def measured(self, x: Any, v: Vec3) -> tuple[Vec3, ...]:
        """The axes of GCRS, in the tracker's."""
        return tuple(rotate(x.misalignment, x.to_body(axis)) for axis in AXES)

    def innovation(self, measured: tuple[Vec3, ...], predicted: tuple[Vec3, ...]) -> Vec3:
        """The vector y of the rotation R(-y) that takes the predicted axes to the measured."""
        k = -2.0 / (1.0 + sum((dot(p, m) for p, m in zip(predicted, measured, strict=True)), 0.0))
        s = sum((cross(p, m) for p, m in zip(predicted, measured, strict=True)), ZERO)
        return Vec3(k * s.x, k * s.y, k * s.z)

    def noise(self) -> tuple[float, float, float]:
        cross_axis = math.radians(self.noise_arcsec / _ARCSEC_PER_DEG)
        roll = math.radians(self.roll_noise_arcsec / _ARCSEC_PER_DEG)
        return (cross_axis, cross_axis, roll)
