"""How fast a satellite can change its body rate, and so how long a ramp between two rates takes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mgeo_attitude._typing import Floats

if TYPE_CHECKING:
    from mgeo_attitude.scenario import Scenario


@dataclass(frozen=True)
class SlewLimits:
    """How fast body rates can change.

    Attributes
    ----------
    max_acceleration : float
        Greatest angular acceleration about each body axis [rad/s²]; may be infinite.
    max_torque : float
        Greatest torque of a wheel, of what ramps use [N m]; may be infinite.
    inertia : array, shape (3, 3)
        [kg m²]
    allocation : array, shape (k, 3)
        How wheels share a torque; see `Wheels.shares`.
    initial_rate : array, shape (3,)
        Body rate that the first ramp leaves [rad/s].
    """

    max_acceleration: float
    max_torque: float
    inertia: Floats
    allocation: Floats = field(default_factory=lambda: np.eye(3))
    initial_rate: Floats = field(default_factory=lambda: np.zeros(3))

    @classmethod
    def of(cls, scenario: Scenario, initial_rate: Floats) -> SlewLimits | None:
        """Those of the scenario's satellite; None where rates change at once."""
        acceleration, wheels = scenario.maneuvers.max_acceleration_deg_s2, scenario.wheels
        torque = None if wheels is None else wheels.max_torque
        if acceleration is None and torque is None:
            return None
        greatest = np.inf if acceleration is None else float(np.radians(acceleration))
        if wheels is None:
            return cls(greatest, np.inf, np.eye(3), initial_rate=initial_rate)
        return cls(
            max_acceleration=greatest,
            max_torque=np.inf if torque is None else wheels.ramp_share * torque,
            inertia=wheels.matrix(),
            allocation=wheels.shares(),
            initial_rate=initial_rate,
        )

    def ramp_time(self, change: Floats) -> Floats:
        """Least time [s] for changes of the rate, shape (..., 3) [rad/s], equation (12).

        The rate changes along a straight line, by the torque J dω/dt.
        """
        acceleration = np.abs(change).max(axis=-1) / self.max_acceleration
        torque = np.abs(change @ self.inertia @ self.allocation.T).max(axis=-1) / self.max_torque
        longest: Floats = np.maximum(acceleration, torque)
        return longest
