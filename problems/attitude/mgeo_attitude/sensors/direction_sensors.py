"""Sensors that measure a direction by two angles: Sun sensor and horizon sensor."""

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
    """Base class for sensors that measure a direction as two angles.

    The measurement is on the tangent plane of the unit vector v: y = Tᵀ ([v×](θ - μ) + b + w), with
    attitude error θ, misalignment μ and bias b. The two columns of T are perpendicular to v, and
    the noise w has no component along v. With noise of 1-sigma r, a measurement has the information
    matrix (I - v vᵀ) / r² with respect to an additive error such as the bias: the component of the
    bias along v becomes observable only when v changes. The choice of T is arbitrary, since the
    noise is isotropic.

    The innovation is a rotation: twice the tangent of half the angle between measured and predicted
    direction, which increases up to opposite directions. Its axes belong to the prediction, since
    axes that depend on the noise would correlate the innovations.
    """

    has_unit_length: ClassVar[bool] = True

    def linearize_measurement(self, x: Any, v: Vec3) -> Any:
        y = super().linearize_measurement(x, v)
        return tuple(inner(axis, y) for axis in x.auxiliary_vectors[: self.n_auxiliary_vectors])

    def predict_measurement(self, x: Any, v: Any) -> Any:
        return normalize(super().predict_measurement(x, v))

    def add_noise(self, measurement: Any, noise: Floats) -> Any:
        tangent_noise = sum(
            axis * noise[..., [k]] for k, axis in enumerate(tangent_vectors(measurement))
        )
        return rotate(cross(measurement, tangent_noise), measurement)

    def innovation(self, measured: Any, predicted: Any) -> Any:
        predicted_values = predicted if isinstance(predicted, np.ndarray) else predicted.value.T
        columns = np.moveaxis(rotate_tangents(predicted_values, measured), -2, 0)
        difference = sum(column * predicted[..., [k]] for k, column in enumerate(columns))
        return -2.0 * difference / (1.0 + dot(measured, predicted))

    @property
    def n_auxiliary_vectors(self) -> int:
        return 2

    def auxiliary_vectors(self, environment: Environment) -> Floats:
        """Return two orthogonal vectors perpendicular to the reference vector at each sample.

        Their length is the reciprocal of the length of the reference vector. The scalar product of
        such a vector and an error of the reference vector is therefore an angle [rad].
        """
        v = self.inertial_vector(environment)
        assert v is not None
        length = np.linalg.norm(v, axis=1, keepdims=True)  # With albedo, it differs from 1.
        tangents: Floats = np.stack(tangent_vectors(v / length), axis=-1) / length[:, :, None]
        return tangents


def rotate_tangents(v: Floats, w: Floats) -> Floats:
    """Rotate the tangent vectors of v by the smallest rotation that takes v to w.

    Parameters
    ----------
    v, w : array, shape (..., 3)
        Unit vectors. The tangent vectors are those of `rotation.tangent_vectors`.

    Returns
    -------
    array, shape (..., 3, 2)
        One tangent vector per column.
    """
    rotation = 2.0 * cross(v, w) / (1.0 + dot(v, w))
    return np.stack([rotate(rotation, axis) for axis in tangent_vectors(v)], axis=-1)


@dataclass(frozen=True)
class TwoAxisSunSensor(DirectionSensor, SunSensor):
    """Sun sensor that measures the direction of the Sun as two angles, except in eclipse.

    The measured direction is that of R(φ) s + δs with Sun direction s, misalignment φ and bias δs;
    see `DirectionSensor`.

    Examples
    --------
    >>> from mgeo_attitude import TwoAxisSunSensor
    >>> list(TwoAxisSunSensor(noise_deg=0.1).states())
    ['misalignment', 'bias']
    """

    kind: ClassVar[str] = "two-axis-sun-sensor"

    name: Identifier = "sun"
    noise_deg: Annotated[Degrees, UsualRange(0.001, 10.0)] = Field(default=0.5, gt=0.0)
    """noise of each of the two angles in one sample, 1-sigma"""

    def noise_sigmas(self) -> tuple[float, ...]:
        return super().noise_sigmas()[:2]

    def predict_measurement(self, x: Any, v: Any) -> Any:
        """Return the Sun direction predicted by the nonlinear sensor model, as a unit vector.

        The prediction includes misalignment, bias and albedo. Only the part of the albedo
        perpendicular to the Sun direction is used. The part along the Sun direction changes the
        angles in second order only. In the model, it would scale all other parts, and the maximum a
        posteriori estimate would shrink them.
        """
        direction = normalize(VectorSensor.predict_measurement(self, x, v))
        if not hasattr(x, "albedo"):
            return direction
        albedo = x.to_body(x.albedo)
        if hasattr(x, "misalignment"):
            albedo = rotate(x.misalignment, albedo)
        return rotate(cross(direction, albedo / euclidean_norm(v)), direction)


@dataclass(frozen=True)
class HorizonSensor(DirectionSensor):
    """Horizon sensor that measures the direction to the Earth's center as two angles.

    The sensor also measures in eclipse. An orbit error changes the direction by 0.8 deg per 100 km.
    Nadir is geocentric: the oblateness of the Earth and of its infrared layer is assumed to be
    corrected, with the residual as part of the bias. The sensor measures in a range of altitudes,
    and while the Sun is outside of an exclusion angle from the boresight.

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
    """noise of each of the two angles in one sample, 1-sigma"""
    initial_misalignment_deg: Misalignment = 0.5
    initial_bias: float = Field(default=0.002, gt=0.0)
    """initial bias of the measured unit vector, 1-sigma per axis"""
    boresight: Boresight = (0.0, 0.0, 1.0)
    half_angle_deg: Degrees = Field(default=180.0, gt=0.0, le=180.0)
    """half-angle of the cone about the boresight that must contain nadir; 180 for an unlimited
    field of view"""
    sun_exclusion_deg: Exclusion = None
    """smallest angle between boresight and Sun, in sunlight, at which the sensor measures; default:
    any angle"""
    lowest_altitude_km: Annotated[float, Unit("km")] = Field(default=0.0, ge=0.0)
    """lowest altitude above the Earth's equatorial radius at which the sensor measures"""
    highest_altitude_km: Annotated[float | None, Unit("km")] = Field(default=None, gt=0.0)
    """highest altitude above the Earth's equatorial radius at which the sensor measures; default:
    any altitude"""

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
        states = select_nonzero(misalignment=tilt, bias=self.initial_bias)
        return states | self.sensitivity_states() | self.latency_states()

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
        projection = np.eye(3) - n[:, :, None] * n[:, None, :]
        derivative: Floats = -POSITION_UNIT / distance[:, None, None] * projection
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
        available: Bools = (altitude >= self.lowest_altitude_km) & (altitude <= highest)
        return None if available.all() else available
