"""Actuators of the satellite: reaction wheels with torque and momentum limits, and magnetorquers.

With the spin axes of n wheels as columns of A, wheel torques or momenta u give A u in body axes.
With more than three wheels, u is not unique. For both allocation rules, the load of the most loaded
wheel for a demand m is the largest |W m| with a matrix W, shape (k, 3).

`criteria.constraints` evaluates the loads of wheels; `maneuvers.rigid_body` simulates
magnetorquers.
"""

from __future__ import annotations

from itertools import combinations
from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.vector import unit_vector
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive, SlewLimits
from mgeo_attitude.scenario.constraints import ManeuverBounds
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.types import (
    DegreesPerSecond,
    Direction,
    Positive,
    Seconds,
    Triple,
    Unit,
    UsualRange,
    Vector,
    restrict_to,
)

#: Sine of the angle below which two axes count as parallel.
_MIN_SINE = 1e-9


def pseudo_inverse_allocation(axes: Floats) -> Floats:
    """Return the matrix that allocates a torque or momentum in body axes to reaction wheels.

    The allocation minimizes the sum of the squared wheel loads.

    Parameters
    ----------
    axes : array, shape (n, 3)
        Spin axes, unit vectors in body axes that span all directions.

    Returns
    -------
    array, shape (n, 3)
        W = A⁺ = Aᵀ (A Aᵀ)⁻¹, one row per wheel.
    """
    return np.asarray(np.linalg.solve(axes.T @ axes, axes.T).T)


def minimax_allocation(axes: Floats) -> Floats:
    """Return the load matrix W of the allocation that minimizes the largest wheel load.

    For a torque or momentum m in body axes, the largest wheel load is the largest component of
    ``abs(W @ m)``.

    The set {A u: |u| <= 1} that wheels of equal size reach is a zonotope, whose facets are spanned
    by pairs of axes. A demand m exceeds the facet of normal n by the factor |n · m| / Σ |n · a|;
    the largest factor is the smallest wheel size that reaches m (Markley, Reynolds, Liu, Lebsock,
    Maximum Torque and Momentum Envelopes for Reaction-Wheel Arrays, Journal of Guidance, Control,
    and Dynamics 33 (2010) 1606-1614).

    Parameters
    ----------
    axes : array, shape (n, 3)
        Spin axes, as in `pseudo_inverse_allocation`.

    Returns
    -------
    array, shape (k, 3)
        W with one row per pair of wheels; the largest |W m| is the load of the most loaded wheel
        for a demand m.
    """
    normals = np.array([np.cross(a, b) for a, b in combinations(axes, 2)])
    normals = normals[np.linalg.norm(normals, axis=1) > _MIN_SINE]
    return np.asarray(normals / np.abs(normals @ axes.T).sum(axis=1, keepdims=True))


#: Allocation rules by the value of ``allocation`` in a scenario file.
ALLOCATIONS = {"pseudo-inverse": pseudo_inverse_allocation, "minimax": minimax_allocation}


#: Singular value of the spin axes below which they count as lying in a plane.
_MIN_SINGULAR_VALUE = 1e-6


def inertia_matrix(
    moments: tuple[float, float, float], products: tuple[float, float, float]
) -> Floats:
    """Return the 3 x 3 inertia matrix for given moments and products of inertia.

    Parameters
    ----------
    moments : tuple of three float
        Moments of inertia about x, y and z.
    products : tuple of three float
        Entries xy, xz and yz of the matrix.

    Returns
    -------
    array, shape (3, 3)

    Raises
    ------
    InvalidValue
        For ``products_of_inertia`` if the matrix is not positive definite; for ``inertia`` if a
        principal moment exceeds the sum of the other two.
    """
    (xx, yy, zz), (xy, xz, yz) = moments, products
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    expected = f"a positive definite inertia matrix with {moments} on the diagonal"
    smallest, middle, largest = np.linalg.eigvalsh(J)
    expect(smallest > 0.0, "products_of_inertia", products, expected)
    expected = (
        f"principal moments of which none exceeds the sum of the other two, not {smallest:.4g}, "
        f"{middle:.4g} and {largest:.4g}"
    )
    expect(largest <= (smallest + middle) * (1.0 + 1e-9), "inertia", moments, expected)
    return J


@dataclass(frozen=True, kw_only=True)
class Wheels(Settings):
    """Identical reaction wheels that rotate the satellite.

    Momentum and torque follow from the plan: the wheels store the difference between the
    satellite's angular momentum and J ω of the body. The total is constant in inertial axes, except
    for disturbance torques by gravity gradient and residual dipole (`filter.wheel_load`).

    Examples
    --------
    >>> from mgeo_attitude.scenario import Wheels
    >>> Wheels(inertia=(0.185, 0.144, 0.061), max_torque=1e-3, max_momentum=3e-3).allocation
    'pseudo-inverse'
    """

    inertia: Annotated[Triple[Positive], Unit("kg m²"), UsualRange(1e-5, 1e4)]
    """moments of inertia of the satellite about body x, y and z, wheels included"""
    products_of_inertia: Annotated[Vector, Unit("kg m²")] = (0.0, 0.0, 0.0)
    """entries xy, xz and yz of the satellite's inertia matrix"""
    axes: tuple[Direction, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    """spin axes of three or more wheels, body axes (any length)"""
    allocation: Annotated[str, restrict_to(ALLOCATIONS)] = "pseudo-inverse"
    """rule that allocates a torque to more than three wheels: 'pseudo-inverse' for least squares,
    'minimax' for the smallest load of the most loaded wheel"""
    max_torque: Annotated[float | None, Unit("N m")] = Field(default=None, gt=0.0)
    """largest torque of each wheel; default: no limit"""
    max_momentum: Annotated[float | None, Unit("N m s")] = Field(default=None, gt=0.0)
    """largest angular momentum that each wheel can store; default: no limit"""
    initial_momentum: Annotated[tuple[float, ...], Unit("N m s")] = ()
    """angular momentum of each wheel at the start; default: values for which the total angular
    momentum of the satellite is zero"""
    residual_dipole: Annotated[Vector, Unit("A m²")] = (0.0, 0.0, 0.0)
    """residual magnetic dipole of the satellite, body axes"""
    gravity_gradient: bool = False
    """true if the wheels also have to store the momentum of the gravity gradient torque"""
    disturbance_margin: float = Field(default=2.0, ge=1.0)
    """safety factor on the momentum and torque due to residual dipole and gravity gradient, applied
    with either sign"""
    ramp_share: float = Field(default=1.0, gt=0.0, le=1.0)
    """share of max_torque that ramps between rates may use; the rest is for gyroscopic torque and
    disturbances"""

    def __post_init__(self) -> None:
        self.inertia_matrix()  # This raises an error for an invalid inertia.
        spans_space = (
            len(self.axes) >= 3
            and np.linalg.svd(self.normalized_axes())[1][2] > _MIN_SINGULAR_VALUE
        )
        expect(spans_space, "axes", self.axes, "three or more that do not lie in a plane")

        momentum, key = self.initial_momentum, "initial_momentum"
        expected = f"{len(self.axes)} numbers, one for each wheel of axes, or none"
        expect(len(momentum) in (0, len(self.axes)), key, momentum, expected)
        largest = self.max_momentum
        is_valid = largest is None or all(abs(h) <= largest for h in momentum)
        expect(is_valid, key, momentum, f"at most max_momentum = {largest!r} N m s in each wheel")
        if self.has_momentum_budget and self.max_torque is not None:
            expected = (
                "less than 1: with initial_momentum, residual_dipole or gravity_gradient, a part "
                f"of max_torque = {self.max_torque!r} N m is needed for disturbances"
            )
            expect(self.ramp_share < 1.0, "ramp_share", self.ramp_share, expected)
        if self.max_torque is None and self.max_momentum is None:
            dipole = self.residual_dipole
            expected = "zero, or a value of max_momentum or max_torque"
            expect(not any(dipole), "residual_dipole", dipole, expected)
            expected = "false, or a value of max_momentum or max_torque"
            expect(not self.gravity_gradient, "gravity_gradient", self.gravity_gradient, expected)

    @property
    def has_momentum_budget(self) -> bool:
        """True if satellite and wheels may have a nonzero total angular momentum.

        The wheels then also store this momentum, which the filter computes along the plan.
        """
        is_disturbed = self.gravity_gradient or any(self.residual_dipole)
        return is_disturbed or bool(self.initial_momentum)

    def inertia_matrix(self) -> Floats:
        """Return the inertia matrix J of the satellite [kg m²], shape (3, 3)."""
        return inertia_matrix(self.inertia, self.products_of_inertia)

    def normalized_axes(self) -> Floats:
        """Return the spin axes as unit vectors in body axes, one per row, shape (n, 3)."""
        return np.array([unit_vector(axis) for axis in self.axes])

    def compute_load_matrix(self) -> Floats:
        """Return the load matrix W for the allocation rule of the wheels.

        For a torque or momentum m in body axes, the load of the most loaded wheel is the largest
        component of ``abs(W @ m)``.

        Returns
        -------
        array, shape (k, 3)
        """
        return ALLOCATIONS[self.allocation](self.normalized_axes())

    def compute_largest_load(self, demand: Floats) -> float:
        """Return the load of the most loaded wheel for a total torque or momentum in body axes."""
        return float(np.abs(self.compute_load_matrix() @ demand).max())


@dataclass(frozen=True, kw_only=True)
class Magnetorquers(Settings):
    """Magnetorquers along the three body axes.

    A dipole m produces the torque m × B in the field B. With wheels, magnetorquers do not rotate
    the satellite but may unload momentum (`filter.wheel_load`). Without wheels, the rates of a plan
    are targets: in each maneuver, the magnetorquers drive the body to the rate and are then
    switched off, and the body moves freely until the next maneuver.

    Examples
    --------
    >>> from mgeo_attitude.scenario import Magnetorquers
    >>> Magnetorquers(max_dipole=(0.2, 0.2, 0.2), inertia=(0.002, 0.002, 0.002)).duty_cycle
    0.8
    """

    max_dipole: Annotated[Triple[Positive], Unit("A m²")]
    """largest magnetic dipole along body x, y and z"""
    inertia: Annotated[Triple[Positive] | None, Unit("kg m²"), UsualRange(1e-5, 1e4)] = None
    """moments of inertia of the satellite about body x, y and z; required without [wheels], not
    allowed with [wheels]"""
    products_of_inertia: Annotated[Vector, Unit("kg m²")] = (0.0, 0.0, 0.0)
    """entries xy, xz and yz of the satellite's inertia matrix"""
    rate_tolerance_deg_s: DegreesPerSecond = Field(default=0.05, gt=0.0)
    """rate error below which the magnetorquers are switched off until the next maneuver"""
    duty_cycle: float = Field(default=0.8, gt=0.0, le=1.0)
    """share of the time in which the magnetorquers are on; the magnetometer measures during the
    rest"""
    time_constant: Seconds = Field(default=10.0, gt=0.0)
    """time constant of the decay of a rate error, or of wheel momentum, while no dipole is at its
    maximum"""
    residual_dipole: Annotated[Vector, Unit("A m²")] = (0.0, 0.0, 0.0)
    """constant residual magnetic dipole of the satellite, body axes"""
    unloads_wheels: bool = False
    """true if the magnetorquers unload the wheels during a plan"""

    def __post_init__(self) -> None:
        if self.inertia is not None:
            self.inertia_matrix()  # This raises an error for an invalid inertia.
        else:
            products = self.products_of_inertia
            expect(not any(products), "products_of_inertia", products, "zeros without inertia")

    def inertia_matrix(self) -> Floats:
        """Return the inertia matrix J of the satellite [kg m²], shape (3, 3).

        The matrix is defined only without wheels.
        """
        assert self.inertia is not None  # `check_magnetorquers` ensures this.
        return inertia_matrix(self.inertia, self.products_of_inertia)

    def build_drive(self, field: Floats, attitude: Floats, rate: Floats) -> MagnetorquerDrive:
        """Return a simulator of the satellite's rotation under magnetorquer control.

        Parameters
        ----------
        field : array, shape (n, 3)
            Geomagnetic field [T], GCRS.
        attitude : array, shape (3, 3)
            Initial attitude, GCRS to body.
        rate : array, shape (3,)
            Initial body rate [rad/s].

        Returns
        -------
        MagnetorquerDrive
        """
        return MagnetorquerDrive(
            inertia=self.inertia_matrix(),
            max_dipole=self.duty_cycle * np.array(self.max_dipole),
            residual_dipole=np.array(self.residual_dipole),
            rate_tolerance=float(np.radians(self.rate_tolerance_deg_s)),
            time_constant=self.time_constant,
            field=field,
            initial_attitude=np.ascontiguousarray(attitude),
            initial_rate=rate,
        )


def check_magnetorquers(
    magnetorquers: Magnetorquers | None,
    wheels: Wheels | None,
    maneuvers: ManeuverBounds,
    step: float,
) -> None:
    """Raise InvalidValue if the magnetorquers do not fit the wheels, maneuvers or filter step.

    Parameters
    ----------
    magnetorquers : Magnetorquers or None
    wheels : Wheels or None
    maneuvers : ManeuverBounds
    step : float
        Filter step [s].
    """
    if magnetorquers is None:
        return
    at_least = (
        f"{2.0 * step:g} or more, two steps of {step:g} s, since the dipole is constant in a step"
    )
    if wheels is not None:
        expected = "no value with [wheels]: wheels.inertia is the inertia of the satellite"
        inertia = magnetorquers.inertia
        expect(inertia is None, "magnetorquers.inertia", inertia, expected)
        if magnetorquers.unloads_wheels:
            expected = (
                "false, or wheels.initial_momentum, residual_dipole or gravity_gradient: without "
                "them the wheels store no total momentum to unload"
            )
            expect(
                wheels.has_momentum_budget,
                "magnetorquers.unloads_wheels",
                magnetorquers.unloads_wheels,
                expected,
            )
            expect(
                magnetorquers.time_constant >= 2.0 * step,
                "magnetorquers.time_constant",
                magnetorquers.time_constant,
                at_least,
            )
        return
    expect(
        not magnetorquers.unloads_wheels,
        "magnetorquers.unloads_wheels",
        magnetorquers.unloads_wheels,
        "false without [wheels]",
    )
    if magnetorquers.inertia is None:
        expected = "expected the satellite's moments of inertia [kg m²], or a [wheels] table"
        raise InvalidValue("magnetorquers.inertia", None, expected)
    expect(
        magnetorquers.time_constant >= 2.0 * step,
        "magnetorquers.time_constant",
        magnetorquers.time_constant,
        at_least,
    )
    key, acceleration = "maneuvers.max_acceleration_deg_s2", maneuvers.max_acceleration_deg_s2
    expected = (
        "no value with [magnetorquers] and without [wheels]: the torque follows from "
        "magnetorquers.max_dipole and the field"
    )
    expect(acceleration is None, key, acceleration, expected)
    expected = (
        "false with [magnetorquers] and without [wheels]: magnetorquers cannot reach an attitude "
        "at a given time"
    )
    expect(not maneuvers.slew_back, "maneuvers.slew_back", maneuvers.slew_back, expected)


def list_assumptions(wheels: Wheels | None, magnetorquers: Magnetorquers | None) -> tuple[str, ...]:
    """Return the assumptions about actuators that affect the results, one sentence each.

    The tuple is empty if the scenario models wheels or magnetorquers completely.
    """
    if wheels is None and magnetorquers is None:
        return ("No actuator limits the body rates. Add [wheels] or [magnetorquers].",)
    if (
        wheels is not None
        and magnetorquers is not None
        and wheels.has_momentum_budget
        and not magnetorquers.unloads_wheels
    ):
        return (
            "The wheels store all momentum. Set magnetorquers.unloads_wheels = true if the "
            "magnetorquers unload them during a plan.",
        )
    return ()


def build_slew_limits(
    maneuvers: ManeuverBounds, wheels: Wheels | None, initial_rate: Floats
) -> SlewLimits | None:
    """Return the limits on changes of the body rate, or None if rates change instantaneously.

    Parameters
    ----------
    maneuvers : ManeuverBounds
        Bounds with an optional maximum angular acceleration.
    wheels : Wheels or None
        Wheels with an optional maximum torque.
    initial_rate : array, shape (3,)
        Body rate at the start [rad/s].

    Returns
    -------
    SlewLimits or None
    """
    acceleration = maneuvers.max_acceleration_deg_s2
    torque = None if wheels is None else wheels.max_torque
    if acceleration is None and torque is None:
        return None
    largest = np.inf if acceleration is None else float(np.radians(acceleration))
    if wheels is None:
        return SlewLimits(largest, np.inf, np.eye(3), initial_rate=initial_rate)
    return SlewLimits(
        max_acceleration=largest,
        max_torque=np.inf if torque is None else wheels.ramp_share * torque,
        inertia=wheels.inertia_matrix(),
        load_matrix=wheels.compute_load_matrix(),
        initial_rate=initial_rate,
    )
