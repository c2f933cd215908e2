"""Sun sensor that measures the unit vector to the Sun."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mgeo_attitude.fields import InvalidValue, positive, quantity
from mgeo_attitude.units import DEG, Unit
from mgeo_attitude.vector import unit
from mgeo_attitude.sensors.base import Surroundings, VectorSensor


@dataclass(frozen=True)
class SunSensor(VectorSensor):
    """y_s = [s×]θ - [s×]φ + δs + w_s (equation 2), blind in eclipse."""

    kind: ClassVar[str] = "sun-sensor"
    units: ClassVar[Mapping[str, Unit]] = {"misalignment": DEG}

    name: str = quantity("sun", doc="name, unique in the suite; prefixes the sensor's states")
    noise_deg: float = positive(2.0, unit="deg", doc="noise per sample, 1-sigma per axis")
    misalignment_deg: float = positive(
        1.0, unit="deg", doc="initial misalignment, 1-sigma per axis"
    )
    bias: float = positive(0.02, doc="initial bias of the unit vector, 1-sigma per axis")

    boresight: tuple[float, float, float] = quantity(
        (0.0, 0.0, 1.0), doc="direction it looks in, body axes (any length)"
    )
    field_of_view_deg: float = quantity(
        180.0,
        unit="deg",
        low=0.0,
        high=180.0,
        open_low=True,
        doc="half-angle of the field of view; 180 sees everywhere",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not any(self.boresight):
            raise InvalidValue("boresight", self.boresight, "expected a direction, not zero")

    def states(self) -> dict[str, float]:
        return {"misalignment": math.radians(self.misalignment_deg), "bias": self.bias}

    def noise(self) -> tuple[float, float, float]:
        sigma = math.radians(self.noise_deg)
        return (sigma, sigma, sigma)

    def reference(self, environment: Surroundings) -> NDArray[np.float64]:
        return environment.sun

    def field_of_view(self) -> tuple[tuple[float, float, float], float] | None:
        if self.field_of_view_deg == 180.0:
            return None
        return unit(self.boresight), math.radians(self.field_of_view_deg)

    def available(self, environment: Surroundings) -> NDArray[np.bool_] | None:
        return None if environment.sunlit.all() else environment.sunlit
