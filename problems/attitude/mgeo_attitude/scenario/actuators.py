"""What turns a satellite: reaction wheels, which limit torque and momentum, or coils alone.

With the spin axes of n wheels as columns of A their torques u, or momenta, make A u in body axes.
With more than three wheels many u do. What the most loaded wheel takes is, for both rules of
allocation here, the greatest |W m| of a matrix W, shape (k, 3), for a demand m.

`criteria.constraints` measures what wheels take; `maneuvers.drives` moves what has coils.
"""

from __future__ import annotations

from itertools import combinations
from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.vector import unit
from mgeo_attitude.maneuvers.drives import CoilDrive, SlewLimits
from mgeo_attitude.scenario.limits import ManeuverLimits
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.types import (
    DegreesPerSecond,
    Direction,
    Positive,
    Seconds,
    Triple,
    Unit,
    Usual,
    Vector,
    one_of,
)

#: Sine of the angle between two axes that span no plane.
_PARALLEL = 1e-9


def pseudo_inverse(axes: Floats) -> Floats:
    """W of the u of least sum of squares, A⁺ = Aᵀ (A Aᵀ)⁻¹: one row a wheel, shape (n, 3).

    Parameters
    ----------
    axes : array, shape (n, 3)
        Spin axes, unit vectors, in body axes, that span all directions.
    """
    return np.asarray(np.linalg.solve(axes.T @ axes, axes.T).T)


def minimax(axes: Floats) -> Floats:
    """W of the u whose greatest component is least: one row a pair of wheels, shape (k, 3).

    What n wheels of one size reach together, {A u: |u| <= 1}, is a zonotope. Its facets are spanned
    by pairs of axes, and a demand m exceeds the one with the normal n by |n · m| / Σ |n · a|. The
    greatest of these is the least size that reaches m (Markley, Reynolds, Liu, Lebsock, Maximum
    Torque and Momentum Envelopes for Reaction-Wheel Arrays, Journal of Guidance, Control, and
    Dynamics 33 (2010) 1606-1614).

    Parameters
    ----------
    axes
        As of `pseudo_inverse`.
    """
    normals = np.array([np.cross(a, b) for a, b in combinations(axes, 2)])
    normals = normals[np.linalg.norm(normals, axis=1) > _PARALLEL]
    return np.asarray(normals / np.abs(normals @ axes.T).sum(axis=1, keepdims=True))


#: Rules by the ``allocation`` that names them in a scenario file.
ALLOCATIONS = {"pseudo-inverse": pseudo_inverse, "minimax": minimax}


#: Singular value of the spin axes below which they span no more than a plane.
_FLAT = 1e-6


def inertia_matrix(
    moments: tuple[float, float, float], products: tuple[float, float, float]
) -> Floats:
    """J, shape (3, 3), of moments about x, y and z and the entries xy, xz and yz.

    Raises
    ------
    InvalidValue
        Naming ``products_of_inertia``, if it is not positive definite, or ``inertia``, if no body
        has such principal moments: none is more than the sum of the other two.
    """
    (xx, yy, zz), (xy, xz, yz) = moments, products
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    definite = f"a positive definite inertia matrix with {moments} on the diagonal"
    least, middle, most = np.linalg.eigvalsh(J)
    expect(least > 0.0, "products_of_inertia", products, definite)
    possible = (
        f"moments of which no body has more than the sum of the other two; the principal ones are "
        f"{least:.4g}, {middle:.4g} and {most:.4g}"
    )
    expect(most <= (least + middle) * (1.0 + 1e-9), "inertia", moments, possible)
    return J


@dataclass(frozen=True, kw_only=True)
class Wheels(Settings):
    """Reaction wheels of one size that turn the satellite.

    Their momentum and torque follow from the plan: together they hold what is the satellite's
    angular momentum but not the body's J ω. It is constant, in inertial axes, but for what gravity
    gradient and a residual dipole add (`filter.wheel_load`).

    Examples
    --------
    >>> from mgeo_attitude.scenario import Wheels
    >>> Wheels(inertia=(0.185, 0.144, 0.061), max_torque=1e-3, max_momentum=3e-3).allocation
    'pseudo-inverse'
    """

    inertia: Annotated[Triple[Positive], Unit("kg m²"), Usual(1e-5, 1e4)]
    """moments of inertia about body x, y and z"""
    products_of_inertia: Annotated[Vector, Unit("kg m²")] = (0.0, 0.0, 0.0)
    """entries xy, xz and yz of the inertia matrix"""
    axes: tuple[Direction, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    """spin axes of three or more wheels, body axes (any length)"""
    allocation: Annotated[str, one_of(ALLOCATIONS)] = "pseudo-inverse"
    """how more than three share a torque: least squares, or least load of the most loaded"""
    max_torque: Annotated[float | None, Unit("N m")] = Field(default=None, gt=0.0)
    """greatest torque of each wheel"""
    max_momentum: Annotated[float | None, Unit("N m s")] = Field(default=None, gt=0.0)
    """greatest momentum stored in each wheel"""
    initial_momentum: Annotated[tuple[float, ...], Unit("N m s")] = ()
    """of each wheel at the start; none makes the satellite's zero"""
    residual_dipole: Annotated[Vector, Unit("A m²")] = (0.0, 0.0, 0.0)
    """magnetic dipole of the satellite, body axes"""
    gravity_gradient: bool = False
    """whether the gravity gradient's torque counts in the momentum budget"""
    disturbance_margin: float = Field(default=2.0, ge=1.0)
    """factor on what dipole and gravity gradient do, whatever its sign"""
    ramp_share: float = Field(default=1.0, gt=0.0, le=1.0)
    """part of max_torque that ramps use; gyroscopic torque and disturbances take the rest"""

    def __post_init__(self) -> None:
        self.matrix()  # refuses what is none
        spans = len(self.axes) >= 3 and np.linalg.svd(self.spin_axes())[1][2] > _FLAT
        expect(spans, "axes", self.axes, "three or more that do not lie in a plane")

        momentum, key = self.initial_momentum, "initial_momentum"
        count = f"{len(self.axes)} numbers, one for each of axes, or none"
        expect(len(momentum) in (0, len(self.axes)), key, momentum, count)
        most = self.max_momentum
        within = most is None or all(abs(h) <= most for h in momentum)
        expect(within, key, momentum, f"at most max_momentum = {most!r} N m s in each wheel")
        if self.budgeted and self.max_torque is not None:
            rest = (
                "less than 1: with initial_momentum, residual_dipole or gravity_gradient wheels of "
                f"max_torque = {self.max_torque!r} N m need some of it besides that of ramps"
            )
            expect(self.ramp_share < 1.0, "ramp_share", self.ramp_share, rest)
        limited = self.max_torque is not None or self.max_momentum is not None
        disturbed = {
            "residual_dipole": any(self.residual_dipole) and self.residual_dipole,
            "gravity_gradient": self.gravity_gradient,
        }
        for key, value in disturbed.items():
            expect(
                limited or not value, key, value, "max_momentum or max_torque to hold it against"
            )

    @property
    def budgeted(self) -> bool:
        """Whether the total angular momentum is not zero all the time."""
        disturbed = self.gravity_gradient or any(self.residual_dipole)
        return disturbed or bool(self.initial_momentum)

    def matrix(self) -> Floats:
        """J, shape (3, 3) [kg m²]."""
        return inertia_matrix(self.inertia, self.products_of_inertia)

    def spin_axes(self) -> Floats:
        """Unit vectors, shape (n, 3)."""
        return np.array([unit(axis) for axis in self.axes])

    def shares(self) -> Floats:
        """W of the wheels' `allocation`, (k, 3): the most loaded takes the greatest `|W m|`."""
        return ALLOCATIONS[self.allocation](self.spin_axes())

    def greatest_share(self, demand: Floats) -> float:
        """What the most loaded wheel takes of a torque or momentum about the body axes."""
        return float(np.abs(self.shares() @ demand).max())


@dataclass(frozen=True, kw_only=True)
class Coils(Settings):
    """Coils or torque rods along the body axes: their torque is across the field, m × B.

    Beside wheels they turn nothing, but may take out momentum (`filter.wheel_load`).

    Without wheels the rates of a plan are what is asked for, not what is flown: coils drive the
    body to each of them, then are off, and it moves freely until the next maneuver.

    Examples
    --------
    >>> from mgeo_attitude.scenario import Coils
    >>> Coils(max_dipole=(0.2, 0.2, 0.2), inertia=(0.002, 0.002, 0.002)).duty
    0.8
    """

    max_dipole: Annotated[Triple[Positive], Unit("A m²")]
    """greatest dipole along body x, y and z"""
    inertia: Annotated[Triple[Positive] | None, Unit("kg m²"), Usual(1e-5, 1e4)] = None
    """moments of inertia about body x, y and z; with wheels, theirs"""
    products_of_inertia: Annotated[Vector, Unit("kg m²")] = (0.0, 0.0, 0.0)
    """entries xy, xz and yz of the inertia matrix"""
    detumble_rate_deg_s: DegreesPerSecond = Field(default=0.05, gt=0.0)
    """how near to the rate that is asked for the coils bring the body before they are off"""
    duty: float = Field(default=0.8, gt=0.0, le=1.0)
    """share of the time that coils are on; in the rest the magnetometer measures"""
    response: Seconds = Field(default=10.0, gt=0.0)
    """time in which an error of the rate, or what wheels hold, falls by e where no coil is at its
    most"""
    residual_dipole: Annotated[Vector, Unit("A m²")] = (0.0, 0.0, 0.0)
    """magnetic dipole of the satellite, always on, body axes"""
    unloads: bool = False
    """whether during a plan coils take out of wheels what momentum they hold"""

    def __post_init__(self) -> None:
        if self.inertia is not None:
            self.matrix()  # refuses what is none
        else:
            alone = "nothing without inertia"
            products = self.products_of_inertia
            expect(not any(products), "products_of_inertia", products, alone)

    def matrix(self) -> Floats:
        """J, shape (3, 3) [kg m²], of a satellite without wheels."""
        assert self.inertia is not None  # as `check_coils` says
        return inertia_matrix(self.inertia, self.products_of_inertia)

    def drive(self, field: Floats, attitude: Floats, rate: Floats) -> CoilDrive:
        """What the motion follows from along a field [T], GCRS, if nothing else turns it."""
        return CoilDrive(
            inertia=self.matrix(),
            max_dipole=self.duty * np.array(self.max_dipole),
            residual_dipole=np.array(self.residual_dipole),
            near=float(np.radians(self.detumble_rate_deg_s)),
            response=self.response,
            field=field,
            initial_attitude=np.ascontiguousarray(attitude),
            initial_rate=rate,
        )


def check_coils(
    coils: Coils | None, wheels: Wheels | None, maneuvers: ManeuverLimits, step: float
) -> None:
    """Refuse, with an InvalidValue, what coils of a scenario do not go with."""
    if coils is None:
        return
    slow = f"{2.0 * step:g} or more, two steps of {step:g} s, for which a dipole is held"
    if wheels is not None:
        own = "nothing beside wheels.inertia, which is the satellite's"
        expect(coils.inertia is None, "coils.inertia", coils.inertia, own)
        if coils.unloads:
            held = (
                "false, or wheels.initial_momentum, residual_dipole or gravity_gradient: without "
                "them the satellite's momentum is zero"
            )
            expect(wheels.budgeted, "coils.unloads", coils.unloads, held)
            expect(coils.response >= 2.0 * step, "coils.response", coils.response, slow)
        return
    expect(not coils.unloads, "coils.unloads", coils.unloads, "false without [wheels]")
    if coils.inertia is None:
        expected = "expected moments of inertia [kg m²] of what coils turn, or a [wheels] table"
        raise InvalidValue("coils.inertia", None, expected)
    expect(coils.response >= 2.0 * step, "coils.response", coils.response, slow)
    key, acceleration = "maneuvers.max_acceleration_deg_s2", maneuvers.max_acceleration_deg_s2
    way_out = "nothing with coils and no wheels: torque follows from coils.max_dipole and the field"
    expect(acceleration is None, key, acceleration, way_out)
    back = "false with coils and no wheels: they cannot bring it to an attitude at a given time"
    expect(not maneuvers.slew_back, "maneuvers.slew_back", maneuvers.slew_back, back)


def assumed(wheels: Wheels | None, coils: Coils | None) -> tuple[str, ...]:
    """What a scenario with these takes for granted of how the satellite turns, each in a line."""
    if wheels is None and coils is None:
        return (
            "body rates are assumed to be free: the scenario has neither [wheels] nor [coils] that "
            "would limit them",
        )
    if wheels is not None and coils is not None and wheels.budgeted and not coils.unloads:
        return (
            "the wheels' budget holds all momentum: none is dumped by the coils during a plan, as "
            "coils.unloads = true would",
        )
    return ()


def slew_limits(
    limits: ManeuverLimits, wheels: Wheels | None, initial_rate: Floats
) -> SlewLimits | None:
    """What a satellite's rates change by, from that at the start; None where they do at once."""
    acceleration = limits.max_acceleration_deg_s2
    torque = None if wheels is None else wheels.max_torque
    if acceleration is None and torque is None:
        return None
    greatest = np.inf if acceleration is None else float(np.radians(acceleration))
    if wheels is None:
        return SlewLimits(greatest, np.inf, np.eye(3), initial_rate=initial_rate)
    return SlewLimits(
        max_acceleration=greatest,
        max_torque=np.inf if torque is None else wheels.ramp_share * torque,
        inertia=wheels.matrix(),
        allocation=wheels.shares(),
        initial_rate=initial_rate,
    )
