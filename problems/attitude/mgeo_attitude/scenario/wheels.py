"""Reaction wheels, which limit torque and momentum; `mgeo_attitude.constraints` measures them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.fields import Validated, expect, positive, quantity


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
