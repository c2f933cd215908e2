"""Sensors that measure the vector they look at: Sun sensor and three-axis magnetometer."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.directions import Cone
from mgeo_attitude.fields import InvalidValue, positive, quantity
from mgeo_attitude.rotation import rotate
from mgeo_attitude.sensors.base import NAME, Sensor
from mgeo_attitude.units import ARCMIN, DEG, Unit
from mgeo_attitude.vector import Vec3, cross, unit

if TYPE_CHECKING:
    from mgeo_attitude.environment import Environment

#: Unit of the field inside the filter [nT], so that every state is of order one or less.
FIELD_UNIT_NT = 50_000.0
_NT = Unit("nT", "nt", FIELD_UNIT_NT)


class VectorSensor(Sensor):
    """A sensor that measures the vector v it looks at: y = [v×]θ - [v×]μ + b (equation 2).

    Its states are a misalignment μ and a bias b.
    """

    rotations: ClassVar[tuple[str, ...]] = ("misalignment",)

    def measure(self, x: Any, v: Vec3) -> Vec3:
        y: Vec3 = cross(v, x.theta - x.misalignment) + x.bias
        return y

    def measured(self, x: Any, v: Any) -> Any:
        return rotate(x.misalignment, v) + x.bias


@dataclass(frozen=True)
class SunSensor(VectorSensor):
    """y_s = [s×]θ - [s×]φ + δs + w_s (equation 2), blind in eclipse."""

    kind: ClassVar[str] = "sun-sensor"
    units: ClassVar[Mapping[str, Unit]] = {"misalignment": DEG, "bias": ARCMIN}

    name: str = quantity("sun", doc=NAME)
    noise_deg: float = positive(2.0, unit="deg", doc="noise per sample, 1-sigma per axis")
    initial_misalignment_deg: float = positive(
        1.0,
        unit="deg",
        doc="initial misalignment, 1-sigma per axis",
        formerly="misalignment_deg",
    )
    initial_bias: float = positive(
        0.02, doc="initial bias of the unit vector, 1-sigma per axis", formerly="bias"
    )

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
        return {
            "misalignment": math.radians(self.initial_misalignment_deg),
            "bias": self.initial_bias,
        }

    def noise(self) -> tuple[float, float, float]:
        sigma = math.radians(self.noise_deg)
        return (sigma, sigma, sigma)

    def inertial_vector(self, environment: Environment) -> Floats:
        return environment.sun

    def views(self) -> tuple[Cone, ...]:
        if self.field_of_view_deg == 180.0:
            return ()
        half_angle = math.radians(self.field_of_view_deg)
        return (Cone("", unit(self.boresight), half_angle, inside=True),)

    def available(self, environment: Environment) -> Bools | None:
        return None if environment.sunlit.all() else environment.sunlit


@dataclass(frozen=True)
class Magnetometer(VectorSensor):
    """y_m = [B×]θ - [B×]ψ + δB + w_B (equation 2), with B in units of 50 µT."""

    kind: ClassVar[str] = "magnetometer"
    units: ClassVar[Mapping[str, Unit]] = {"misalignment": DEG, "bias": _NT}
    channel_unit: ClassVar[Unit] = _NT

    name: str = quantity("mag", doc=NAME)
    noise_nt: float = positive(500.0, unit="nT", doc="noise per sample, 1-sigma per axis")
    initial_misalignment_deg: float = positive(
        1.0,
        unit="deg",
        doc="initial misalignment, 1-sigma per axis",
        formerly="misalignment_deg",
    )
    initial_bias_nt: float = positive(
        2000.0, unit="nT", doc="initial bias, 1-sigma per axis", formerly="bias_nt"
    )

    def states(self) -> dict[str, float]:
        return {
            "misalignment": math.radians(self.initial_misalignment_deg),
            "bias": self.initial_bias_nt / FIELD_UNIT_NT,
        }

    def noise(self) -> tuple[float, float, float]:
        sigma = self.noise_nt / FIELD_UNIT_NT
        return (sigma, sigma, sigma)

    def inertial_vector(self, environment: Environment) -> Floats:
        return environment.field / FIELD_UNIT_NT
