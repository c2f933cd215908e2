"""Attitude, rates and pointing error of a satellite without a gyro that keeps its body aligned with
reference axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.frames import lvlh_to_gcrs, rotation_to_gcrs
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.error_models import GaussMarkov
from scipy.interpolate import CubicSpline

from mgeo_calibration.telemetry.mapping import GyroChannels


class AssumedAttitude(NamedTuple):
    """Assumed attitude of a satellite without a gyro at n samples, and its random pointing error.

    The true attitude is ``attitude @ rotation_matrix(e)`` for a pointing error e.

    Attributes
    ----------
    attitude : array, shape (n, 3, 3)
        Rotation matrices from the body frame to GCRS.
    pointing_error : GaussMarkov
        Process of the error about each body axis [rad].
    """

    attitude: Floats
    pointing_error: GaussMarkov


@dataclass(frozen=True, eq=False, kw_only=True)
class AttitudeHold:
    """Attitude law of a satellite without a gyro. The body follows reference axes with a random
    pointing error.

    Attributes
    ----------
    axes : str
        Frame of the reference axes, ``LVLH`` or ``GCRF``.
    to_body : array, shape (3, 3)
        Rotation matrix from the reference axes to the body frame without pointing error.
    pointing_error : GaussMarkov
        Process of the error about each body axis [rad].
    """

    axes: str
    to_body: Floats
    pointing_error: GaussMarkov

    @staticmethod
    def from_channels(gyro: GyroChannels) -> AttitudeHold | None:
        """Build an attitude hold from the gyro section of a mapping. Return None if the mapping
        declares no pointing error.
        """
        sigma, time = gyro.pointing_error_deg, gyro.pointing_correlation_time
        if sigma is None or time is None:
            return None
        return AttitudeHold(
            axes="LVLH" if gyro.reference_axes == "lvlh" else "GCRF",
            to_body=gyro.build_body_rotation().as_matrix(),
            pointing_error=GaussMarkov(math.radians(sigma), time),
        )

    def compute_attitude(
        self, scenario: Scenario, times: Floats, position: Floats | None
    ) -> AssumedAttitude:
        """Compute the assumed attitude at the given times from the reference axes and the declared
        rotation to the body.

        Parameters
        ----------
        scenario, times, position
            As in `compute_frame_rotations`.
        """
        axes = compute_frame_rotations(self.axes, scenario, times, position)
        return AssumedAttitude(axes @ self.to_body.T, self.pointing_error)


def compute_assumed_rates(axes: str, scenario: Scenario, times: Floats) -> Floats:
    """Return the assumed body rate of a satellite without a gyro, which is the rate of its
    reference axes.

    LVLH has x forward, y against the orbit normal and z down. It rotates at the rate ``|r × v| /
    r²`` about -y.

    Parameters
    ----------
    axes : str
        ``lvlh`` or ``inertial``.
    scenario : Scenario
        Scenario with the orbit.
    times : array, shape (n,)
        Seconds since the epoch of the scenario.

    Returns
    -------
    array, shape (n, 3)
        Rate about the reference axes [deg/s].
    """
    rates = np.zeros((len(times), 3))
    if axes == "lvlh":
        r, v = scenario.orbit.propagate(scenario.epoch, times)
        rates[:, 1] = -np.linalg.norm(np.cross(r, v), axis=1) / (r * r).sum(axis=1)
    return np.degrees(rates)


def compute_frame_rotations(
    frame: str, scenario: Scenario, times: Floats, position: Floats | None
) -> Floats:
    """Return the rotation matrices from a reference frame to GCRS, one per time.

    Parameters
    ----------
    frame : str
        One of `mapping.AttitudeFrame`.
    scenario : Scenario
        Scenario with epoch and orbit.
    times : array, shape (n,)
        Seconds since the epoch.
    position : array, shape (n, 3), optional
        Satellite position in GCRS [m], with NaN for missing samples, for the frame LVLH. Default:
        the orbit of the scenario.

    Returns
    -------
    array, shape (n, 3, 3)
    """
    if frame != "LVLH":
        return rotation_to_gcrs(frame, compute_julian_dates(scenario.epoch, times))
    if position is None:
        return lvlh_to_gcrs(*scenario.orbit.propagate(scenario.epoch, times))
    is_known = np.isfinite(position[:, 0])
    orbit = CubicSpline(times[is_known], position[is_known])
    return lvlh_to_gcrs(orbit(times), orbit(times, 1))
