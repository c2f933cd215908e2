"""Limits of a real satellite that a plan has to keep; `mgeo_attitude.constraints` measures them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ..fields import InvalidValue, Validated, positive, quantity
from ..units import Unit
from ..vector import unit
from .settings import RequiredSigma, check_blocks


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
        if np.linalg.eigvalsh(self.matrix())[0] <= 0.0:
            raise InvalidValue(
                "products_of_inertia",
                self.products_of_inertia,
                f"expected a positive definite inertia matrix with {self.inertia} on the diagonal",
            )

    def matrix(self) -> NDArray[np.float64]:
        """J, shape (3, 3) [kg m²]."""
        xy, xz, yz = self.products_of_inertia
        off = np.array([[0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0]])
        matrix: NDArray[np.float64] = np.diag(self.inertia) + off
        return matrix


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
        if not self.name.isprintable() or not self.name.strip():
            raise InvalidValue("name", self.name, "expected printable characters on one line")
        if not any(self.boresight):
            raise InvalidValue("boresight", self.boresight, "expected a direction, not zero")

    def axis(self) -> tuple[float, float, float]:
        """Unit vector of the boresight."""
        return unit(self.boresight)


@dataclass(frozen=True, kw_only=True)
class Limits(Validated):
    """The part of a `Scenario` that plans have to keep."""

    required_sigma: Annotated[Mapping[str, float], RequiredSigma] = positive(
        factory=RequiredSigma,
        doc="1-sigma that each axis of a state block must reach, by key with unit",
    )
    wheels: Wheels | None = quantity(None, doc="reaction wheels that turn the satellite")
    keep_outs: tuple[KeepOut, ...] = quantity((), doc="cones that the Sun must stay out of")

    def check_limits(self, units: Mapping[str, Unit], attitude_deg: float) -> None:
        """Refuse, with an InvalidValue, what does not go with the state and its initial 1-sigma."""
        keys = [unit.key(block) for block, unit in units.items()]
        check_blocks("required_sigma", self.required_sigma, keys)
        for i, cone in enumerate(self.keep_outs):
            most = (180.0 - cone.half_angle_deg) / attitude_deg
            if cone.attitude_sigmas >= most:
                raise InvalidValue(
                    f"keep_outs[{i}].attitude_sigmas",
                    cone.attitude_sigmas,
                    f"expected less than {most:.4g}: with initial.attitude_deg = {attitude_deg!r} "
                    f"no attitude is that far from half_angle_deg = {cone.half_angle_deg!r}",
                )
