"""Three-axis magnetometer."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mgeo_attitude.fields import positive, quantity
from mgeo_attitude.units import DEG, Unit
from mgeo_attitude.sensors.base import Surroundings, VectorSensor

#: Unit of the field inside the filter [nT], so that every state is of order one or less.
FIELD_UNIT_NT = 50_000.0


@dataclass(frozen=True)
class Magnetometer(VectorSensor):
    """y_m = [B×]θ - [B×]ψ + δB + w_B (equation 2), with B in units of 50 µT."""

    kind: ClassVar[str] = "magnetometer"
    units: ClassVar[Mapping[str, Unit]] = {
        "misalignment": DEG,
        "bias": Unit("nT", "nt", FIELD_UNIT_NT),
    }

    name: str = quantity("mag", doc="name, unique in the suite; prefixes the sensor's states")
    noise_nt: float = positive(500.0, unit="nT", doc="noise per sample, 1-sigma per axis")
    misalignment_deg: float = positive(
        1.0, unit="deg", doc="initial misalignment, 1-sigma per axis"
    )
    bias_nt: float = positive(2000.0, unit="nT", doc="initial bias, 1-sigma per axis")

    def states(self) -> dict[str, float]:
        return {
            "misalignment": math.radians(self.misalignment_deg),
            "bias": self.bias_nt / FIELD_UNIT_NT,
        }

    def noise(self) -> tuple[float, float, float]:
        sigma = self.noise_nt / FIELD_UNIT_NT
        return (sigma, sigma, sigma)

    def reference(self, environment: Surroundings) -> NDArray[np.float64]:
        return environment.field / FIELD_UNIT_NT
