"""Ramps: how a body rate changes from that of one maneuver to that of the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..scenario import Scenario

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SlewLimits:
    """How fast body rates can change.

    Attributes
    ----------
    max_acceleration : float
        Greatest angular acceleration about each body axis [rad/s²]; may be infinite.
    max_torque : float
        Greatest torque about each body axis [N m]; may be infinite.
    inertia : array, shape (3, 3)
        [kg m²]
    """

    max_acceleration: float
    max_torque: float
    inertia: Floats

    def ramp_time(self, change: Floats) -> Floats:
        """Least time [s] for changes of the rate, shape (..., 3) [rad/s], equation (12).

        The rate changes along a straight line. The satellite's total angular momentum is zero, so
        that no torque is needed but J dω/dt.
        """
        acceleration = np.abs(change).max(axis=-1) / self.max_acceleration
        torque = np.abs(change @ self.inertia).max(axis=-1) / self.max_torque
        longest: Floats = np.maximum(acceleration, torque)
        return longest


def ramp_shares(begin: Floats, step: float, time: Floats) -> tuple[Floats, Floats]:
    """Share of a change that is made in steps of a ramp: their mean, and at their ends.

    The share is proportional to time until the ramp ends, which may be within a step.

    Parameters
    ----------
    begin : array
        Starts of steps, from the ramp's start [s].
    step : float
        Their length [s].
    time : array
        How long the ramp takes [s], see `SlewLimits.ramp_time`.
    """
    part = np.clip((time - begin) / step, 0.0, 1.0)  # of the step that belongs to the ramp
    mean = part * share_made(begin + 0.5 * part * step, time) + (1.0 - part)
    return mean, share_made(begin + step, time)


def share_made(after: Floats, time: Floats) -> Floats:
    """Share of a change that is made `after` seconds of a ramp that takes `time`."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(time > 0.0, np.clip(after / time, 0.0, 1.0), 1.0)


def slew_limits(scenario: Scenario) -> SlewLimits | None:
    """How fast the scenario's satellite changes its rate; None where it does at once."""
    acceleration, wheels = scenario.maneuvers.max_acceleration_deg_s2, scenario.wheels
    torque = None if wheels is None else wheels.max_torque
    if acceleration is None and torque is None:
        return None
    return SlewLimits(
        max_acceleration=np.inf if acceleration is None else float(np.radians(acceleration)),
        max_torque=np.inf if torque is None else torque,
        inertia=np.eye(3) if wheels is None else wheels.matrix(),
    )
