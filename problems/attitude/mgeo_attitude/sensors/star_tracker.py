"""Star tracker: an attitude sensor."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import Cone
from mgeo_attitude.geometry.rotation import build_frame, cross, dot, rotate, unrotate
from mgeo_attitude.geometry.vector import Vec3, unit_vector
from mgeo_attitude.geometry.vector import dot as inner
from mgeo_attitude.sensors.base import Boresight, Exclusion, Sensor
from mgeo_attitude.sensors.error_models import Misalignment, State, select_nonzero
from mgeo_attitude.settings.types import DegreesPerSecond, Identifier, Unit, UsualRange

_ARCSEC_PER_DEG = 3600.0


@dataclass(frozen=True)
class StarTracker(Sensor):
    """Star tracker that measures the attitude about all three axes.

    The noise is larger about the boresight than about the cross axes. The small-angle model is y =
    T (θ - μ) + w with attitude error θ, misalignment μ and noise w. T rotates from body axes to the
    tracker's axes, whose z axis is the boresight. Measurements are in body axes. The tracker
    measures below a maximum body rate, and while Sun, Moon and the Earth's limb are outside of
    their exclusion angles from the boresight.

    Examples
    --------
    >>> from mgeo_attitude import StarTracker
    >>> StarTracker(noise_arcsec=8.0, max_rate_deg_s=1.0, sun_exclusion_deg=40.0).states()
    {'misalignment': 0.003490658503988659}
    """

    kind: ClassVar[str] = "star-tracker"
    needs_field: ClassVar[bool] = False
    noise_parameters: ClassVar[tuple[str, ...]] = ("noise_arcsec", "roll_noise_arcsec")
    rotations: ClassVar[tuple[str, ...]] = ("misalignment",)
    offset_state: ClassVar[str] = "misalignment"
    telemetry_suffixes: ClassVar[tuple[str, ...]] = ("q1", "q2", "q3", "q4")

    name: Identifier = "tracker"
    noise_arcsec: Annotated[float, Unit("arcsec"), UsualRange(0.1, 1000.0)] = Field(
        default=10.0, gt=0.0
    )
    """noise about the cross axes, 1-sigma"""
    roll_noise_arcsec: Annotated[float, Unit("arcsec"), UsualRange(0.5, 6000.0)] = Field(
        default=60.0, gt=0.0
    )
    """noise about the boresight, 1-sigma"""
    initial_misalignment_deg: Misalignment = 0.2

    boresight: Boresight = (0.0, 0.0, 1.0)
    max_rate_deg_s: DegreesPerSecond | None = Field(default=None, gt=0.0)
    """largest body rate at which the tracker measures; default: any rate"""
    sun_exclusion_deg: Exclusion = None
    """smallest angle between boresight and Sun, in sunlight, at which the tracker measures;
    default: any angle"""
    earth_exclusion_deg: Exclusion = None
    """smallest angle between boresight and the Earth's limb at which the tracker measures; default:
    any angle"""
    moon_exclusion_deg: Exclusion = None
    """smallest angle between boresight and Moon at which the tracker measures; default: any
    angle"""

    @cached_property
    def axes(self) -> Floats:
        """Axes of the star tracker as unit vectors in body axes, shape (3, 3).

        The array has one axis per row. The last row is the boresight. The array is the matrix T
        from body axes to the tracker's axes.
        """
        return build_frame(np.array(unit_vector(self.boresight)))

    def states(self) -> dict[str, State]:
        states = select_nonzero(misalignment=math.radians(self.initial_misalignment_deg))
        return states | self.sensitivity_states() | self.latency_states()

    def linearize_measurement(self, x: Any, v: Vec3) -> Vec3:
        error: Vec3 = x.theta - x.misalignment if hasattr(x, "misalignment") else x.theta
        return Vec3(*(inner(error, Vec3(*axis)) for axis in self.axes.tolist()))

    def predict_measurement(self, x: Any, v: Any) -> tuple[Any, ...]:
        """Return the noise-free attitude predicted by the nonlinear star tracker model.

        The attitude is a tuple of three unit vectors: the GCRS axes in body axes, rotated by the
        misalignment.
        """
        axes = tuple(map(x.to_body, np.eye(3)))
        if not hasattr(x, "misalignment"):
            return axes
        return tuple(rotate(x.misalignment, axis) for axis in axes)

    def add_noise(self, measurement: tuple[Any, ...], noise: Floats) -> tuple[Floats, ...]:
        """Rotate a measured attitude by a noise rotation vector in the tracker's axes.

        The rotation is R(-Tᵀ noise), so that the `innovation` equals the noise.
        """
        return tuple(unrotate(noise @ self.axes, axis) for axis in measurement)

    def innovation(self, measured: tuple[Any, ...], predicted: tuple[Any, ...]) -> Any:
        """Return the rotation vector from the predicted to the measured attitude.

        The vector is in the tracker's axes. The result is T y for the rotation R(-y) from the
        predicted to the measured axes.
        """
        pairs = list(zip(predicted, measured, strict=True))
        cosines, axis = sum(dot(p, m) for p, m in pairs), sum(cross(p, m) for p, m in pairs)
        y = -2.0 * axis / (1.0 + cosines)
        return sum(column * y[..., [k]] for k, column in enumerate(self.axes.T))

    def noise_sigmas(self) -> tuple[float, float, float]:
        cross_axis = math.radians(self.noise_arcsec / _ARCSEC_PER_DEG)
        roll = math.radians(self.roll_noise_arcsec / _ARCSEC_PER_DEG)
        return (cross_axis, cross_axis, roll)

    def list_visibility_cones(self) -> tuple[Cone, ...]:
        exclusions = {
            "sun": self.sun_exclusion_deg,
            "earth": self.earth_exclusion_deg,
            "moon": self.moon_exclusion_deg,
        }
        return tuple(
            Cone(direction, unit_vector(self.boresight), math.radians(angle), keep_in=False)
            for direction, angle in exclusions.items()
            if angle is not None
        )

    def get_max_rate(self) -> float:
        return math.inf if self.max_rate_deg_s is None else math.radians(self.max_rate_deg_s)
