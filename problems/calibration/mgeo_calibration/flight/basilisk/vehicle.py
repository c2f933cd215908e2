"""A rigid body that reaction wheels or coils turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pydantic.dataclasses
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.maneuvers.drives import CoilDrive, SlewLimits
from mgeo_attitude.maneuvers.schedule import decode, maneuver_steps
from mgeo_attitude.scenario.actuators import Wheels, pseudo_inverse
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect, known_names
from mgeo_attitude.settings.types import Unit
from pydantic import Field

#: How Basilisk shares a torque among wheels.
SHARED_BY = "pseudo-inverse"


@dataclass(frozen=True)
class Coiled:
    """What coils of a satellite are asked for.

    Attributes
    ----------
    rates : array, shape (n, 3)
        Body rate that is asked for in each step [rad/s].
    begins : array of bool, shape (n,)
        Whether a maneuver begins with the step.
    """

    drive: CoilDrive
    rates: Floats
    begins: Bools

    @classmethod
    def of(cls, drive: CoilDrive, design: Floats, step: float, n_steps: int) -> Coiled:
        """Of a design, shape (4 m,), on n steps."""
        rates, durations = decode(design)
        starts, _ = maneuver_steps(durations, step)
        steps = np.arange(n_steps)
        which = np.searchsorted(starts[0], steps, side="right") - 1
        return cls(drive, rates[0, which], np.isin(steps, starts[0]))

    @property
    def inertia(self) -> Floats:
        """J, shape (3, 3) [kg m²]."""
        return self.drive.inertia


@pydantic.dataclasses.dataclass(frozen=True, kw_only=True)
class Vehicle(Settings):
    """A satellite as its wheels turn it.

    Raises
    ------
    InvalidValue
        For a value out of its range, or wheels that share a torque as Basilisk's do not.
    """

    wheels: Wheels
    """the satellite's inertia, wheels included, axes of the wheels, and torque and momentum of
    each"""
    bandwidth: Annotated[float, Unit("rad/s")] = Field(default=0.2, gt=0.0)
    """natural frequency of the controller"""

    def __post_init__(self) -> None:
        shared, by = self.wheels.allocation, f"{SHARED_BY!r}: Basilisk shares a torque so"
        expect(shared == SHARED_BY, "wheels.allocation", shared, by)

    @staticmethod
    def amazonia() -> Vehicle:
        """A remote-sensing satellite of 640 kg, of the class of Amazonia-1.

        Wheels along the body axes and a skew one, as INPE describes it; their size, 0.2 N m and
        12 N m s, and the inertia are ours, typical of the class.
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
        """A 6U cubesat with three small commercial wheels, 4 mN m and 15 mN m s.

        The inertia is that of 12 kg spread evenly over 10 x 22.63 x 36.6 cm.
        """
        wheels = Wheels(inertia=(0.185, 0.144, 0.061), max_torque=0.004, max_momentum=0.015)
        return Vehicle(wheels=wheels)

    @staticmethod
    def of(scenario: Scenario, name: str | None = None) -> Vehicle:
        """The vehicle of a name in `VEHICLES`, or else that of the scenario.

        The scenario's is made of its wheels, or else has the scenario's own name.

        Raises
        ------
        ValueError
            For an unknown name, or a scenario that does not say what it flies with.
        """
        if name is None and scenario.wheels is not None:
            return Vehicle(wheels=scenario.wheels)
        chosen = name or scenario.name
        if chosen in VEHICLES:
            return VEHICLES[chosen]()
        if name is not None:
            raise InvalidValue("vehicle", name, f"unknown vehicle{known_names(name, VEHICLES)}")
        known = ", ".join(VEHICLES)
        raise InvalidValue(
            "wheels", None, f"expected wheels in the scenario, or a vehicle: {known}"
        )

    @property
    def inertia(self) -> Floats:
        """J, shape (3, 3) [kg m²]."""
        return self.wheels.matrix()

    def momentum(self, rate: Floats) -> Floats:
        """Of each wheel at the start [N m s], shape (n,), when the body turns at `rate` [rad/s]."""
        wheels = self.wheels
        if wheels.initial_momentum:
            return np.array(wheels.initial_momentum)
        zero: Floats = -pseudo_inverse(wheels.spin_axes()) @ wheels.matrix() @ rate
        return zero

    def slew_limits(self, initial_rate: Floats) -> SlewLimits | None:
        """How fast rates can change about all axes at once; None where nothing limits it.

        Torque is shared among wheels by the pseudo-inverse, so that of n wheels along n axes each
        gives what is asked about its own.
        """
        torque = self.wheels.max_torque
        if torque is None:
            return None
        most = float(np.abs(pseudo_inverse(self.wheels.spin_axes())).sum(axis=1).max())
        least = self.wheels.ramp_share * torque / most
        return SlewLimits(np.inf, least, self.wheels.matrix(), initial_rate=initial_rate)


#: Vehicles by name: those of the presets of scenarios.
VEHICLES = {
    "paper": Vehicle.amazonia,
    "cubesat_6u": Vehicle.cubesat_6u,
    "cubesat_6u_full": Vehicle.cubesat_6u,
}
