"""Limits of a real satellite that a plan has to keep; `mgeo_attitude.constraints` measures them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.fields import Validated, expect, positive, quantity
from mgeo_attitude.scenario.settings import check_name
from mgeo_attitude.vector import unit


@dataclass(frozen=True, kw_only=True)
class Wheels(Validated):
    """Reaction wheels along the body axes that turn the satellite, starting from rest.

    The satellite's whole angular momentum is taken as zero, so that the wheels hold minus that of
    the body, J ω, and their torque is J dω/dt: without external torques there is no other term.
    """

    inertia: tuple[float, float, float] = positive(
        unit="kg m²", doc="moments of inertia about body x, y and z"
    )
    products_of_inertia: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0), unit="kg m²", doc="entries xy, xz and yz of the inertia matrix"
    )
    max_torque: float | None = positive(None, unit="N m", doc="greatest torque about each axis")
    max_momentum: float | None = positive(
        None, unit="N m s", doc="greatest momentum stored about each axis"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        definite = f"a positive definite inertia matrix with {self.inertia} on the diagonal"
        least = np.linalg.eigvalsh(self.matrix())[0]
        expect(least > 0.0, "products_of_inertia", self.products_of_inertia, definite)

    def matrix(self) -> Floats:
        """J, shape (3, 3) [kg m²]."""
        (xx, yy, zz), (xy, xz, yz) = self.inertia, self.products_of_inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@dataclass(frozen=True, kw_only=True)
class KeepOut(Validated):
    """A cone around a body axis, a camera's say, in which the Sun must not be while it shines.

    The axis is where the filter believes it: the cone is kept with a margin of `attitude_sigmas`
    times the 1-sigma of the angle to the Sun; equation (14) of docs/theory.md.
    """

    name: str = quantity("payload", doc="name of the cone, for people")
    boresight: tuple[float, float, float] = quantity(doc="axis of the cone, body axes (any length)")
    half_angle_deg: float = quantity(
        unit="deg", low=0.0, high=90.0, open_low=True, open_high=True, doc="half-angle of the cone"
    )
    attitude_sigmas: float = quantity(
        3.0, low=0.0, doc="margin for the unknown attitude, in 1-sigmas of the angle; 0 is none"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name(self.name)
        expect(any(self.boresight), "boresight", self.boresight, "a direction, not zero")

    def axis(self) -> tuple[float, float, float]:
        """Unit vector of the boresight."""
        return unit(self.boresight)
