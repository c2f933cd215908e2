"""Sensors that measure a direction by two angles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.directions import Cone
from mgeo_attitude.geometry.rotation import (
    cross,
    dot,
    euclidean_norm,
    normalize,
    rotate,
    tangent_vectors,
)
from mgeo_attitude.geometry.vector import Vec3, unit_vector
from mgeo_attitude.geometry.vector import dot as inner
from mgeo_attitude.sensors.base import Boresight, Exclusion
from mgeo_attitude.sensors.environment_errors import POSITION_UNIT
from mgeo_attitude.sensors.error_models import Misalignment, State, select_nonzero
from mgeo_attitude.sensors.vector_sensors import SunSensor, VectorSensor, apply_orbit_error
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import Degrees, Identifier, Unit, UsualRange

if TYPE_CHECKING:
    from mgeo_attitude.environment.environment import Environment


class DirectionSensor(VectorSensor):
    """Sensor of a direction, measured on the tangent plane of the unit vector v.

    y = Tᵀ ([v×](θ - μ) + b + w), where the two columns of T are perpendicular to v and the noise w
    has no component along v. With noise of 1-sigma r, a measurement has the information matrix (I -
    v vᵀ) / r² with respect to an additive error such as the bias: the component of the bias along v
    becomes observable only when v changes. The choice of T is arbitrary, since the noise is
    isotropic.

    The innovation is a rotation: twice the tangent of half the angle between measured and predicted
    direction, which increases up to opposite directions. Its axes belong to the prediction, since
    axes that depend on the noise would correlate the innovations.
    """

    has_unit_length: ClassVar[bool] = True

    def linearize_measurement(self, x: Any, v: Vec3) -> Any:
        y = super().linearize_measurement(x, v)
        return tuple(inner(axis, y) for axis in x.gradient[: self.n_gradient])

    def predict_measurement(self, x: Any, v: Any) -> Any:
        return normalize(super().predict_measurement(x, v))

    def add_noise(self, measurement: Any, noise: Floats) -> Any:
        across = sum(axis * noise[..., [k]] for k, axis in enumerate(tangent_vectors(measurement)))
        return rotate(cross(measurement, across), measurement)

    def innovation(self, measured: Any, predicted: Any) -> Any:
        known = predicted if isinstance(predicted, np.ndarray) else predicted.value.T
        columns = np.moveaxis(rotate_tangents(known, measured), -2, 0)
        off = sum(column * predicted[..., [k]] for k, column in enumerate(columns))
        return -2.0 * off / (1.0 + dot(measured, predicted))

    @property
    def n_gradient(self) -> int:
        return 2

    def gradient(self, environment: Environment) -> Floats:
        """Return two unit vectors across the direction, divided by the vector's length."""
        v = self.inertial_vector(environment)
        assert v is not None
        length = np.linalg.norm(v, axis=1, keepdims=True)  # differs from 1 with albedo
        across: Floats = np.stack(tangent_vectors(v / length), axis=-1) / length[:, :, None]
        return across


def rotate_tangents(v: Floats, w: Floats) -> Floats:
    """Return axes perpendicular to the unit vector v, rotated with v to w by the smallest rotation.

    The shape is (..., 3, 2).
    """
    turn = 2.0 * cross(v, w) / (1.0 + dot(v, w))
    return np.stack([rotate(turn, axis) for axis in tangent_vectors(v)], axis=-1)


@dataclass(frozen=True)
class TwoAxisSunSensor(DirectionSensor, SunSensor):
    """Sun sensor that measures two angles or a normalized vector; no measurements in eclipse.

    The measured direction is that of R(φ) s + δs; see `DirectionSensor`.

    Examples
    --------
    >>> from mgeo_attitude import TwoAxisSunSensor
    >>> list(TwoAxisSunSensor(noise_deg=0.1).states())
    ['misalignment', 'bias']
    """

    kind: ClassVar[str] = "two-axis-sun-sensor"

    name: Identifier = "sun"
    noise_deg: Annotated[Degrees, UsualRange(0.001, 10.0)] = Field(default=0.5, gt=0.0)
    """noise per sample, 1-sigma of each angle"""

    def noise_sigmas(self) -> tuple[float, ...]:
        return super().noise_sigmas()[:2]

    def predict_measurement(self, x: Any, v: Any) -> Any:
        """Return the direction to the Sun, rotated by the perpendicular part of the albedo.

        The part along the Sun direction changes the angles in second order only and is omitted. In
        the model, it would scale all other parts, and the maximum a posteriori estimate would
        shrink them.
        """
        seen = normalize(VectorSensor.predict_measurement(self, x, v))
        if not hasattr(x, "albedo"):
            return seen
        light = x.to_body(x.albedo)
        if hasattr(x, "misalignment"):
            light = rotate(x.misalignment, light)
        return rotate(cross(seen, light / euclidean_norm(v)), seen)


@dataclass(frozen=True)
class HorizonSensor(DirectionSensor):
    """Horizon sensor, which measures two angles of the Earth's center, day and night.

    An orbit error changes the direction by 0.8 deg per 100 km. Nadir is geocentric: the oblateness
    of the Earth and of its infrared layer is assumed to be corrected, with the residual as part of
    the bias. The sensor measures in a range of altitudes, and while the Sun is outside of an
    exclusion angle from the boresight.

    Examples
    --------
    >>> from mgeo_attitude import HorizonSensor
    >>> HorizonSensor(noise_deg=0.2, sun_exclusion_deg=20.0).lowest_altitude_km
    0.0
    """

    kind: ClassVar[str] = "horizon-sensor"
    needs_field: ClassVar[bool] = False
    noise_parameters: ClassVar[tuple[str, ...]] = ("noise_deg",)

    name: Identifier = "horizon"
    noise_deg: Annotated[Degrees, UsualRange(0.001, 10.0)] = Field(default=0.1, gt=0.0)
    """noise per sample, 1-sigma of each angle"""
    initial_misalignment_deg: Misalignment = 0.5
    initial_bias: float = Field(default=0.002, gt=0.0)
    """initial bias of the unit vector, 1-sigma per axis"""
    boresight: Boresight = (0.0, 0.0, 1.0)
    half_angle_deg: Degrees = Field(default=180.0, gt=0.0, le=180.0)
    """half-angle of the cone about the boresight that must contain nadir; 180 for no limit"""
    sun_exclusion_deg: Exclusion = None
    """least angle between boresight and Sun, in sunlight; default: no limit"""
    lowest_altitude_km: Annotated[float, Unit("km")] = Field(default=0.0, ge=0.0)
    """lowest altitude above the equatorial radius at which the sensor measures"""
    highest_altitude_km: Annotated[float | None, Unit("km")] = Field(default=None, gt=0.0)
    """highest altitude above the equatorial radius at which the sensor measures; default: no
    limit"""

    def __post_init__(self) -> None:
        super().__post_init__()
        low, high = self.lowest_altitude_km, self.highest_altitude_km
        expect(
            high is None or high > low,
            "highest_altitude_km",
            high,
            f"more than lowest_altitude_km = {low!r}",
        )

    def states(self) -> dict[str, State]:
        tilt = math.radians(self.initial_misalignment_deg)
        own = select_nonzero(misalignment=tilt, bias=self.initial_bias)
        return own | self.sensitivity_states() | self.latency_states()

    def list_environment_errors(self) -> tuple[str, ...]:
        return ("orbit_error",)

    def predict_measurement(self, x: Any, v: Any) -> Any:
        return super().predict_measurement(x, apply_orbit_error(x, v))

    def noise_sigmas(self) -> tuple[float, ...]:
        return (math.radians(self.noise_deg),) * 2

    def inertial_vector(self, environment: Environment) -> Floats:
        distance = np.linalg.norm(environment.position, axis=1, keepdims=True)
        nadir: Floats = -environment.position / distance
        return nadir

    def position_gradient(self, environment: Environment) -> Floats:
        n, distance = (
            self.inertial_vector(environment),
            np.linalg.norm(environment.position, axis=1),
        )
        across = np.eye(3) - n[:, :, None] * n[:, None, :]
        derivative: Floats = -POSITION_UNIT / distance[:, None, None] * across
        return derivative

    def list_visibility_cones(self) -> tuple[Cone, ...]:
        axis, cones = unit_vector(self.boresight), []
        if self.half_angle_deg < 180.0:
            cones.append(Cone("", axis, math.radians(self.half_angle_deg), keep_in=True))
        if self.sun_exclusion_deg is not None:
            cones.append(Cone("sun", axis, math.radians(self.sun_exclusion_deg), keep_in=False))
        return tuple(cones)

    def find_available_samples(self, environment: Environment) -> Bools | None:
        altitude = 1e-3 * (np.linalg.norm(environment.position, axis=1) - EARTH_RADIUS)
        highest = math.inf if self.highest_altitude_km is None else self.highest_altitude_km
        there: Bools = (altitude >= self.lowest_altitude_km) & (altitude <= highest)
        return None if there.all() else there
