"""Magnetic coils, the only torque of a satellite without wheels; `maneuvers.coils` moves it."""

from __future__ import annotations

from dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.fields import InvalidValue, Validated, expect, positive, quantity
from mgeo_attitude.scenario.settings import ManeuverLimits
from mgeo_attitude.scenario.wheels import Wheels, inertia_matrix


@dataclass(frozen=True, kw_only=True)
class Coils(Validated):
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

    max_dipole: tuple[float, float, float] = positive(
        unit="A m²", doc="greatest dipole along body x, y and z"
    )
    inertia: tuple[float, float, float] | None = positive(
        None,
        unit="kg m²",
        doc="moments of inertia about body x, y and z; with wheels, theirs",
        usual=(1e-5, 1e4),
    )
    products_of_inertia: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0), unit="kg m²", doc="entries xy, xz and yz of the inertia matrix"
    )
    detumble_rate_deg_s: float = positive(
        0.05,
        unit="deg/s",
        doc="how near to the rate that is asked for the coils bring the body before they are off",
    )
    duty: float = quantity(
        0.8,
        low=0.0,
        high=1.0,
        open_low=True,
        doc="share of the time that coils are on; in the rest the magnetometer measures",
    )
    response: float = positive(
        10.0,
        unit="s",
        doc="time in which an error of the rate, or what wheels hold, falls by e where no coil is "
        "at its most",
    )
    residual_dipole: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0), unit="A m²", doc="magnetic dipole of the satellite, always on, body axes"
    )
    unloads: bool = quantity(
        False, doc="whether during a plan coils take out of wheels what momentum they hold"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
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
