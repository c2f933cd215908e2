"""Photodiode: a scalar sensor of the cosine of the angle between normal and Sun direction."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.directions import Cone
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.geometry.rotation import build_frame, dot
from mgeo_attitude.geometry.vector import Vec3, choose, componentwise_product, cross, unit_vector
from mgeo_attitude.geometry.vector import dot as inner
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.error_models import State
from mgeo_attitude.settings.types import Degrees, Direction, Identifier, UsualRange


@dataclass(frozen=True)
class Photodiode(Sensor):
    """Photodiode whose signal follows the cosine law.

    The signal is the scalar product of a sensitivity vector and the Sun direction. The signal is y
    = (n + e) · s + w with normal n, Sun direction s, error e of the sensitivity vector and noise w.
    Each photodiode is one sensor. In the diode's axes, whose z axis is the normal, the first two
    components of e tilt the normal [rad] and the third is the gain error. These are the parameters
    that are calibrated in orbit (J. C. Springmann, J. W. Cutler, On-Orbit Calibration of
    Photodiodes for Attitude Determination, Journal of Guidance, Control, and Dynamics 37 (2014)
    1808-1823).

    The diode measures while the Sun is within a half-angle of the normal. With `includes_albedo`,
    albedo that arrives in front of the face adds to sunlight.

    Examples
    --------
    >>> from mgeo_attitude import Photodiode
    >>> Photodiode("sun_px", normal=(1.0, 0.0, 0.0)).states()["sensitivity"][2]
    0.05
    """

    kind: ClassVar[str] = "photodiode"
    needs_field: ClassVar[bool] = False
    noise_parameters: ClassVar[tuple[str, ...]] = ("relative_noise",)
    offset_state: ClassVar[str] = "sensitivity"
    telemetry_suffixes: ClassVar[tuple[str, ...]] = ("",)

    name: Identifier = "diode"
    normal: Direction = (0.0, 0.0, 1.0)
    """outward normal of the photodiode, body axes (any length)"""
    relative_noise: Annotated[float, UsualRange(1e-4, 0.5)] = Field(default=0.02, gt=0.0)
    """noise of one sample, 1-sigma, relative to the signal with the Sun along the normal"""
    initial_scale_factor: Annotated[float, UsualRange(1e-4, 0.5)] = Field(default=0.05, gt=0.0)
    """initial gain error, 1-sigma"""
    initial_misalignment_deg: Degrees = Field(default=2.0, gt=0.0)
    """initial misalignment of the normal, 1-sigma about each transverse axis"""
    half_angle_deg: Degrees = Field(default=70.0, gt=0.0, le=89.0)
    """largest angle between Sun and normal at which the signal is used; beyond this angle, albedo
    and reflections are no longer small compared to the signal"""
    includes_albedo: bool = True
    """true if albedo affects the measurements, if the scenario models albedo"""

    @cached_property
    def axes(self) -> Floats:
        """Axes of the photodiode as unit vectors in body axes, shape (3, 3).

        The array has one axis per row. The last row is the normal.
        """
        return build_frame(np.array(unit_vector(self.normal)))

    def states(self) -> dict[str, State]:
        tilt = math.radians(self.initial_misalignment_deg)
        return {"sensitivity": (tilt, tilt, self.initial_scale_factor)} | self.latency_states()

    def list_environment_errors(self) -> tuple[str, ...]:
        return ("albedo",) if self.includes_albedo else ()

    def linearize_measurement(self, x: Any, v: Vec3) -> Any:
        *_, n = axes = [Vec3(*axis) for axis in self.axes.tolist()]
        light, change = v, x.reference_change
        if self.includes_albedo:
            albedo = x.auxiliary_vectors[0]
            is_front = Vec3(*[_select_front_light(inner(n, albedo))] * 3)
            light = v + componentwise_product(is_front, albedo)
            if hasattr(x, "albedo"):
                change = change + componentwise_product(is_front, x.to_body(x.albedo))
        y = inner(n, cross(light, x.theta) + change)
        return (sum((e * inner(a, light) for e, a in zip(x.sensitivity, axes, strict=True)), y),)

    def predict_measurement(self, x: Any, v: Any) -> Any:
        """Return the noise-free signal due to sunlight and albedo.

        The model is valid while the Sun is within the half-angle of the normal.
        """
        errors = (x.sensitivity[..., [k]] * axis for k, axis in enumerate(self.axes))
        sensitivity = sum(errors, self.axes[2])
        if self.includes_albedo:
            albedo = x.auxiliary_vectors[0]
            is_front = _select_front_light(dot(self.axes[2], albedo))
            if hasattr(x, "albedo"):
                albedo = albedo + x.to_body(x.albedo)
            v = v + is_front * albedo
        return dot(sensitivity, v)

    def noise_sigmas(self) -> tuple[float, ...]:
        return (self.relative_noise,)

    def inertial_vector(self, environment: Environment) -> Floats:
        return environment.sun

    @property
    def n_auxiliary_vectors(self) -> int:
        return int(self.includes_albedo)

    def auxiliary_vectors(self, environment: Environment) -> Floats:
        """Return the albedo vector at each sample.

        The vector adds to the Sun direction. It is zero without an albedo model.

        Returns
        -------
        array, shape (n_steps + 1, 3, 1)
            GCRS axes.
        """
        albedo, sun = environment.albedo, environment.sun
        return (np.zeros_like(sun) if albedo is None else albedo)[:, :, None]

    def list_visibility_cones(self) -> tuple[Cone, ...]:
        return (
            Cone("", unit_vector(self.normal), math.radians(self.half_angle_deg), keep_in=True),
        )

    def find_available_samples(self, environment: Environment) -> Bools | None:
        return None if environment.sunlit.all() else environment.sunlit


def _select_front_light(cosine: Any) -> Any:
    """Return 1 if light arrives in front of the face, and 0 otherwise.

    The cosine of the angle to the normal is positive for light from the front. The cosine may be an
    array, a symbol of the code generator or a `TaylorPolynomial`.
    """
    return choose(cosine.value.T if hasattr(cosine, "value") else cosine, 0.0, 1.0, 0.0)
