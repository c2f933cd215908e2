"""Axes that a satellite without a gyro holds: attitude, rates and pointing error."""

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
    """Held attitude at n samples, and the pointing error about it.

    The true attitude is the held one times `rotation.matrix` of an error, body to GCRS.

    Attributes
    ----------
    attitude : array, shape (n, 3, 3)
        Body to GCRS.
    pointing_error : GaussMarkov
        Error about each body axis [rad].
    """

    attitude: Floats
    pointing_error: GaussMarkov


@dataclass(frozen=True, eq=False, kw_only=True)
class AttitudeHold:
    """Axes that a satellite holds with a pointing error.

    Attributes
    ----------
    axes : str
        Frame of the axes, ``LVLH`` or ``GCRF``.
    to_body : array, shape (3, 3)
        Rotation of coordinates from the axes to the body without pointing error.
    pointing_error : GaussMarkov
        Error about each body axis [rad].
    """

    axes: str
    to_body: Floats
    pointing_error: GaussMarkov

    @staticmethod
    def from_channels(gyro: GyroChannels) -> AttitudeHold | None:
        """Return the hold of a mapping that declares a pointing error."""
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
        """Return the held attitude at times [s]; parameters as in `compute_frame_rotations`."""
        axes = compute_frame_rotations(self.axes, scenario, times, position)
        return AssumedAttitude(axes @ self.to_body.T, self.pointing_error)


def compute_assumed_rates(axes: str, scenario: Scenario, times: Floats) -> Floats:
    """Return the rate of a satellite that holds LVLH or inertial axes, in those [deg/s], (n, 3).

    LVLH has x forward, y against the orbit's normal and z down. It rotates at |r × v| / r².
    """
    rates = np.zeros((len(times), 3))
    if axes == "lvlh":
        r, v = scenario.orbit.propagate(scenario.epoch, times)
        rates[:, 1] = -np.linalg.norm(np.cross(r, v), axis=1) / (r * r).sum(axis=1)
    return np.degrees(rates)


def compute_frame_rotations(
    frame: str, scenario: Scenario, times: Floats, position: Floats | None
) -> Floats:
    """Return the matrices that take vectors of a frame to GCRS, shape (n, 3, 3).

    Parameters
    ----------
    frame : str
        One of `mapping.AttitudeFrame`.
    times : array, shape (n,)
        [s]
    position : array, shape (n, 3), optional
        Satellite [m], GCRS, NaN without a sample. Default: the scenario's orbit.
    """
    if frame != "LVLH":
        return rotation_to_gcrs(frame, compute_julian_dates(scenario.epoch, times))
    if position is None:
        return lvlh_to_gcrs(*scenario.orbit.propagate(scenario.epoch, times))
    known = np.isfinite(position[:, 0])
    course = CubicSpline(times[known], position[known])
    return lvlh_to_gcrs(course(times), course(times, 1))
