"""Star tracker that measures the attitude itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.fields import positive, quantity
from mgeo_attitude.rotation import cross, dot, rotate, unrotate
from mgeo_attitude.sensors.base import NAME, Sensor
from mgeo_attitude.units import DEG, Unit
from mgeo_attitude.vector import Vec3

_ARCSEC_PER_DEG = 3600.0


@dataclass(frozen=True)
class StarTracker(Sensor):
    """y = θ - μ + w: small-angle attitude with the tracker's own misalignment μ.

    The boresight is body z; rotation about it is measured worse than the two cross axes.
    """

    kind: ClassVar[str] = "star-tracker"
    rotations: ClassVar[tuple[str, ...]] = ("misalignment",)
    units: ClassVar[Mapping[str, Unit]] = {"misalignment": DEG}
    channels: ClassVar[tuple[str, ...]] = ("q1", "q2", "q3", "q4")

    name: str = quantity("tracker", doc=NAME)
    noise_arcsec: float = positive(10.0, unit="arcsec", doc="noise about the cross axes, 1-sigma")
    roll_noise_arcsec: float = positive(
        60.0, unit="arcsec", doc="noise about the boresight z, 1-sigma"
    )
    initial_misalignment_deg: float = positive(
        0.2,
        unit="deg",
        doc="initial misalignment, 1-sigma per axis",
        formerly="misalignment_deg",
    )

    def states(self) -> dict[str, float]:
        return {"misalignment": math.radians(self.initial_misalignment_deg)}

    def measure(self, x: Any, v: Vec3) -> Vec3:
        y: Vec3 = x.theta - x.misalignment
        return y

    def measured(self, x: Any, v: Any) -> tuple[Any, ...]:
        """The axes of GCRS, in the tracker's."""
        return tuple(rotate(x.misalignment, x.to_body(axis)) for axis in np.eye(3))

    def with_noise(self, measured: tuple[Any, ...], noise: Floats) -> tuple[Floats, ...]:
        """The axes turned by R(-noise), so that the `innovation` is the noise."""
        return tuple(unrotate(noise, axis) for axis in measured)

    def innovation(self, measured: tuple[Any, ...], predicted: tuple[Any, ...]) -> Any:
        """The vector y of the rotation R(-y) that takes the predicted axes to the measured."""
        pairs = list(zip(predicted, measured, strict=True))
        cosines, axis = sum(dot(p, m) for p, m in pairs), sum(cross(p, m) for p, m in pairs)
        return -2.0 * axis / (1.0 + cosines)

    def noise(self) -> tuple[float, float, float]:
        cross_axis = math.radians(self.noise_arcsec / _ARCSEC_PER_DEG)
        roll = math.radians(self.roll_noise_arcsec / _ARCSEC_PER_DEG)
        return (cross_axis, cross_axis, roll)
