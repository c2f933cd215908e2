"""Sensors that measure a reference vector: Sun sensor and three-axis magnetometer."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.directions import Cone
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.geometry.rotation import rotate, shear
from mgeo_attitude.geometry.vector import Vec3, componentwise_product, cross, unit_vector
from mgeo_attitude.geometry.vector import shear as shear_components
from mgeo_attitude.sensors.base import Boresight, Sensor
from mgeo_attitude.sensors.environment_errors import FIELD_UNIT_NT, NT, POSITION_UNIT
from mgeo_attitude.sensors.error_models import (
    Misalignment,
    Nonorthogonality,
    ScaleFactor,
    State,
    expand_per_axis,
    select_nonzero,
)
from mgeo_attitude.settings.types import (
    ARCMIN,
    DEG,
    PPM,
    Degrees,
    Identifier,
    PerAxis,
    Positive,
    Unit,
    UsualRange,
)


class VectorSensor(Sensor):
    """Base class for sensors that measure all three components of a vector in body axes.

    The linear model is y = [v×]θ - [v×]μ + b (equation 2) with reference vector v, attitude error
    θ, misalignment μ and bias b. Misalignment and bias are optional error states, present if
    `states` contains them.
    """

    rotations: ClassVar[tuple[str, ...]] = ("misalignment",)
    units: ClassVar[dict[str, Unit]] = Sensor.units | {"bias": ARCMIN}

    def linearize_measurement(self, x: Any, v: Vec3) -> Any:
        rotation = x.theta - x.misalignment if hasattr(x, "misalignment") else x.theta
        y = cross(v, rotation)
        y = y + x.bias + x.reference_change if hasattr(x, "bias") else y + x.reference_change
        if hasattr(x, "orbit_error"):
            for error, column in zip(x.orbit_error, x.auxiliary_vectors[-3:], strict=True):
                y = y + Vec3(*(error * component for component in column))
        return y

    def predict_measurement(self, x: Any, v: Any) -> Any:
        measured = rotate(x.misalignment, v) if hasattr(x, "misalignment") else v
        return measured + x.bias if hasattr(x, "bias") else measured


def apply_orbit_error(x: Any, v: Any) -> Any:
    """Add the first-order effect of the orbit error to a reference vector in body axes.

    Parameters
    ----------
    x : namespace
        Argument of `Sensor.predict_measurement`; has the attribute ``orbit_error`` if it is
        modeled.
    v : array, shape (..., 3)
        Reference vector in body axes at the nominal position.
    """
    if hasattr(x, "orbit_error"):
        for axis, column in enumerate(x.auxiliary_vectors[-3:]):
            v = v + x.orbit_error[..., [axis]] * column
    return v


@dataclass(frozen=True)
class SunSensor(VectorSensor):
    """Sun sensor that measures the Sun vector in body axes, except in eclipse.

    The linear model is y_s = [s×]θ - [s×]φ + δs + w_s (equation 2) with Sun vector s, attitude
    error θ, misalignment φ, bias δs and noise w_s. Albedo adds to the vector of a coarse sensor;
    see `EnvironmentErrors`.

    Examples
    --------
    >>> from mgeo_attitude import SunSensor
    >>> SunSensor(noise_deg=0.3, boresight=(0.0, 0.0, -1.0), half_angle_deg=60.0).states()
    {'misalignment': 0.017453292519943295, 'bias': 0.02}
    """

    kind: ClassVar[str] = "sun-sensor"
    needs_field: ClassVar[bool] = False
    noise_parameters: ClassVar[tuple[str, ...]] = ("noise_deg",)

    name: Identifier = "sun"
    noise_deg: Annotated[PerAxis[Positive], Unit("deg"), UsualRange(0.005, 50.0)] = 2.0
    """noise of one sample, 1-sigma, one number for all axes or one per axis"""
    initial_misalignment_deg: Misalignment = 1.0
    initial_bias: float = Field(default=0.02, gt=0.0)
    """initial bias of the measured unit vector, 1-sigma per axis"""

    boresight: Boresight = (0.0, 0.0, 1.0)
    half_angle_deg: Degrees = Field(default=180.0, gt=0.0, le=180.0)
    """half-angle of the field of view about the boresight; 180 for an unlimited field of view"""
    includes_albedo: bool = True
    """true if albedo affects the measurements, if the scenario models albedo"""

    def states(self) -> dict[str, State]:
        tilt = math.radians(self.initial_misalignment_deg)
        states = select_nonzero(misalignment=tilt, bias=self.initial_bias)
        return states | self.sensitivity_states() | self.latency_states()

    def list_environment_errors(self) -> tuple[str, ...]:
        return ("albedo",) if self.includes_albedo else ()

    def linearize_measurement(self, x: Any, v: Vec3) -> Any:
        y = super().linearize_measurement(x, v)
        return y + x.to_body(x.albedo) if hasattr(x, "albedo") else y

    def predict_measurement(self, x: Any, v: Any) -> Any:
        return super().predict_measurement(
            x, v + x.to_body(x.albedo) if hasattr(x, "albedo") else v
        )

    def noise_sigmas(self) -> tuple[float, ...]:
        x, y, z = expand_per_axis(self.noise_deg)
        return (math.radians(x), math.radians(y), math.radians(z))

    def inertial_vector(self, environment: Environment) -> Floats:
        albedo = environment.albedo if self.includes_albedo else None
        return environment.sun if albedo is None else environment.sun + albedo

    def list_visibility_cones(self) -> tuple[Cone, ...]:
        if self.half_angle_deg == 180.0:
            return ()
        half_angle = math.radians(self.half_angle_deg)
        return (Cone("sun", unit_vector(self.boresight), half_angle, keep_in=True),)

    def find_available_samples(self, environment: Environment) -> Bools | None:
        return None if environment.sunlit.all() else environment.sunlit


@dataclass(frozen=True)
class Magnetometer(VectorSensor):
    """Three-axis magnetometer, which measures the geomagnetic field in body axes.

    The linear model is y_m = [B×]θ - [B×]ψ + δB + w_B (equation 2) with field B in units of 50 µT,
    attitude error θ, misalignment ψ, bias δB and noise w_B. Errors of scale factor and
    non-orthogonality, as caused by soft iron, are optional. Field model errors and orbit errors
    affect the magnetometer if `EnvironmentErrors` models them; see `predict_measurement`.

    Examples
    --------
    >>> from mgeo_attitude import Magnetometer
    >>> list(Magnetometer(noise_nt=100.0, initial_scale_factor=0.01).states())
    ['misalignment', 'bias', 'scale_factor']
    """

    kind: ClassVar[str] = "magnetometer"
    noise_parameters: ClassVar[tuple[str, ...]] = ("noise_nt",)
    units: ClassVar[dict[str, Unit]] = Sensor.units | {
        "bias": NT,
        "scale_factor": PPM,
        "nonorthogonality": DEG,
    }
    telemetry_unit: ClassVar[Unit] = NT

    name: Identifier = "mag"
    noise_nt: Annotated[PerAxis[Positive], Unit("nT"), UsualRange(1.0, 1e4)] = 500.0
    """noise of one sample, 1-sigma, one number for all axes or one per axis"""
    initial_misalignment_deg: Misalignment = 1.0
    initial_bias_nt: Annotated[float, Unit("nT")] = Field(default=2000.0, gt=0.0)
    """initial bias, 1-sigma per axis"""
    initial_scale_factor: ScaleFactor = 0.0
    initial_nonorthogonality_deg: Nonorthogonality = 0.0

    def states(self) -> dict[str, State]:
        states = select_nonzero(
            misalignment=math.radians(self.initial_misalignment_deg),
            bias=self.initial_bias_nt / FIELD_UNIT_NT,
            scale_factor=self.initial_scale_factor,
            nonorthogonality=math.radians(self.initial_nonorthogonality_deg),
        )
        return states | self.sensitivity_states() | self.latency_states()

    def list_environment_errors(self) -> tuple[str, ...]:
        return ("field_error", "orbit_error")

    def linearize_measurement(self, x: Any, v: Vec3) -> Any:
        y = super().linearize_measurement(x, v)
        if self.initial_scale_factor:
            y = y + componentwise_product(v, x.scale_factor)
        if self.initial_nonorthogonality_deg:
            y = y + shear_components(v, x.nonorthogonality)
        if hasattr(x, "field_error"):
            y = y + x.to_body(x.field_error)
        return y

    def predict_measurement(self, x: Any, v: Any) -> Any:
        """Return the noise-free field predicted by the nonlinear magnetometer model.

        B_m = R(ψ) (B + k ∘ B + N(η) B) + δB with B = C (B_model + e + G r). C is the attitude, e
        the field model error, G the `position_gradient` of the field and r the orbit error. I +
        diag(k) + N(η), with N of `vector.shear`, is the symmetric part of the effect of soft iron,
        gains and non-orthogonal axes; the rotational part is the misalignment ψ (R. Alonso, M. D.
        Shuster, Complete Linear Attitude-Independent Magnetometer Calibration, Journal of the
        Astronautical Sciences 50 (2002) 477-490).
        """
        if hasattr(x, "field_error"):
            v = v + x.to_body(x.field_error)
        field = v = apply_orbit_error(x, v)
        if self.initial_scale_factor:
            field = field + x.scale_factor * v
        if self.initial_nonorthogonality_deg:
            field = field + shear(x.nonorthogonality, v)
        return super().predict_measurement(x, field)

    def noise_sigmas(self) -> tuple[float, float, float]:
        x, y, z = expand_per_axis(self.noise_nt)
        return (x / FIELD_UNIT_NT, y / FIELD_UNIT_NT, z / FIELD_UNIT_NT)

    def inertial_vector(self, environment: Environment) -> Floats:
        return environment.field / FIELD_UNIT_NT

    def position_gradient(self, environment: Environment) -> Floats:
        return POSITION_UNIT / FIELD_UNIT_NT * environment.field_gradient()
