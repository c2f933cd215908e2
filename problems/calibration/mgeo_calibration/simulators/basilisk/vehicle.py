"""Satellites with reaction wheels or magnetorquers for the Basilisk simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pydantic.dataclasses
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive, SlewLimits
from mgeo_attitude.maneuvers.schedule import compute_maneuver_steps, decode_designs
from mgeo_attitude.scenario.actuators import Wheels, pseudo_inverse_allocation
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect, format_known_names
from mgeo_attitude.settings.types import Unit
from pydantic import Field

#: Torque allocation among the wheels in Basilisk.
ALLOCATION = "pseudo-inverse"


@dataclass(frozen=True)
class MagnetorquerVehicle:
    """Satellite with magnetorquers and the body rate that it is commanded to follow in each step.

    Attributes
    ----------
    drive : MagnetorquerDrive
    rates : array, shape (n, 3)
        Commanded body rate in each step [rad/s].
    maneuver_starts : array of bool, shape (n,)
        True if a maneuver starts with the step.
    """

    drive: MagnetorquerDrive
    rates: Floats
    maneuver_starts: Bools

    @classmethod
    def from_design(
        cls, drive: MagnetorquerDrive, design: Floats, step: float, n_steps: int
    ) -> MagnetorquerVehicle:
        """Return the vehicle that is commanded to follow a design, with the body rate of the
        current maneuver in each step.
        """
        rates, durations = decode_designs(design)
        starts, _ = compute_maneuver_steps(durations, step)
        steps = np.arange(n_steps)
        which = np.searchsorted(starts[0], steps, side="right") - 1
        return cls(drive, rates[0, which], np.isin(steps, starts[0]))

    @property
    def inertia(self) -> Floats:
        """Inertia matrix of the satellite about its body axes [kg m²]."""
        return self.drive.inertia


@pydantic.dataclasses.dataclass(frozen=True, kw_only=True)
class Vehicle(Settings):
    """Satellite with reaction wheels: inertia, wheels and controller bandwidth.

    Raises
    ------
    InvalidValue
        If a value is out of range, or the torque allocation differs from Basilisk's.
    """

    wheels: Wheels
    """inertia of the satellite including the wheels, wheel axes, and limits of torque and
    momentum"""
    bandwidth: Annotated[float, Unit("rad/s")] = Field(default=0.2, gt=0.0)
    """natural frequency of the attitude controller"""

    def __post_init__(self) -> None:
        allocation = self.wheels.allocation
        expected = f"{ALLOCATION!r}, the torque allocation of Basilisk"
        expect(allocation == ALLOCATION, "wheels.allocation", allocation, expected)

    @staticmethod
    def amazonia() -> Vehicle:
        """Return a remote-sensing satellite of 640 kg with four reaction wheels, similar to
        Amazonia-1.

        Three wheels along the body axes and a skewed wheel follow INPE's description. Wheel size,
        0.2 N m and 12 N m s, and inertia are typical of the class.
        """
        wheels = Wheels(
            inertia=(310.0, 310.0, 170.0),
            axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 1.0)),
            max_torque=0.2,
            max_momentum=12.0,
        )
        return Vehicle(wheels=wheels)

    @staticmethod
    def cubesat_6u() -> Vehicle:
        """Return a 6U CubeSat with three small commercial reaction wheels along the body axes.

        Each wheel has 4 mN m and 15 mN m s. The inertia corresponds to 12 kg distributed evenly
        over 10 x 22.63 x 36.6 cm.
        """
        wheels = Wheels(inertia=(0.185, 0.144, 0.061), max_torque=0.004, max_momentum=0.015)
        return Vehicle(wheels=wheels)

    @staticmethod
    def from_scenario(scenario: Scenario, name: str | None = None) -> Vehicle:
        """Return the vehicle with a given name or, without a name, the vehicle that the scenario
        defines.

        Without a name, the vehicle has the wheels of the scenario. Without wheels, the name of the
        scenario selects the vehicle from `VEHICLES`.

        Raises
        ------
        ValueError
            If the name is unknown, or the scenario defines no vehicle.
        """
        if name is None and scenario.wheels is not None:
            return Vehicle(wheels=scenario.wheels)
        chosen = name or scenario.name
        if chosen in VEHICLES:
            return VEHICLES[chosen]()
        if name is not None:
            raise InvalidValue(
                "vehicle", name, f"unknown vehicle{format_known_names(name, VEHICLES)}"
            )
        known = ", ".join(VEHICLES)
        raise InvalidValue(
            "wheels", None, f"expected wheels in the scenario, or a vehicle: {known}"
        )

    @property
    def inertia(self) -> Floats:
        """Inertia matrix of the satellite about its body axes [kg m²]."""
        return self.wheels.inertia_matrix()

    def compute_initial_momentum(self, rate: Floats) -> Floats:
        """Return the initial momentum of each wheel: the declared momentum, or the momentum with
        which the total momentum of satellite and wheels is zero.

        Parameters
        ----------
        rate : array, shape (3,)
            Initial body rate [rad/s].
        """
        wheels = self.wheels
        if wheels.initial_momentum:
            return np.array(wheels.initial_momentum)
        zero: Floats = (
            -pseudo_inverse_allocation(wheels.normalized_axes()) @ wheels.inertia_matrix() @ rate
        )
        return zero

    def compute_slew_limits(self, initial_rate: Floats) -> SlewLimits | None:
        """Return slew limits with the largest angular acceleration that the wheel torques allow
        about every axis, or None without a torque limit.

        Torque is allocated by the pseudo-inverse of the wheel axes.
        """
        torque = self.wheels.max_torque
        if torque is None:
            return None
        most = float(
            np.abs(pseudo_inverse_allocation(self.wheels.normalized_axes())).sum(axis=1).max()
        )
        least = self.wheels.ramp_share * torque / most
        return SlewLimits(np.inf, least, self.wheels.inertia_matrix(), initial_rate=initial_rate)


#: Vehicles of the scenario presets, by preset name.
VEHICLES = {
    "paper": Vehicle.amazonia,
    "cubesat_6u": Vehicle.cubesat_6u,
    "cubesat_6u_full": Vehicle.cubesat_6u,
}
