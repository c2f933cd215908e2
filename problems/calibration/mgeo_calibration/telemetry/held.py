"""Satellites without a gyro that hold known axes: rates, and the error of the pointing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.gyro import Gyro

from mgeo_calibration.telemetry.mapping import GyroChannels

#: Rate offset of a satellite that holds axes, as a share of its pointing error over the
#: correlation time: it has none, but a bias with a prior of zero has no inverse.
_OFFSET = 1e-3
#: Factor of the random walk for caution: the return to the axes is not modeled. Of 24 simulated
#: flights with errors of 0.5 to 5 deg and times of 100 to 1,000 s 22 are consistent with it, 9
#: without; the biases differ by less than 0.2 sigma.
_CAUTION = 2.0


def held(axes: str, scenario: Scenario, times: Floats) -> Floats:
    """Return the rate of a satellite that holds LVLH or inertial axes, in those [deg/s], (n, 3).

    LVLH has x forward, y against the orbit's normal and z down. It rotates at |r × v| / r².
    """
    rates = np.zeros((len(times), 3))
    if axes == "lvlh":
        r, v = scenario.orbit.propagate(scenario.epoch, times)
        rates[:, 1] = -np.linalg.norm(np.cross(r, v), axis=1) / (r * r).sum(axis=1)
    return np.degrees(rates)


def with_pointing_error(scenario: Scenario, gyro: GyroChannels) -> Scenario:
    """Return the scenario with the declared pointing error in place of the gyro's errors.

    A pointing error of 1-sigma σ and correlation time T is a first-order Markov process. Over times
    much shorter than T it is a random walk of σ √(2 / T) in angle; over longer times the random
    walk is larger than the process, so that estimates are cautious. The random walk is taken to be
    `_CAUTION` times as large.
    """
    sigma, time = gyro.pointing_error_deg, gyro.pointing_correlation_time
    if sigma is None or time is None:
        return scenario
    deviation = Gyro(
        angle_random_walk_deg_per_sqrt_h=60.0 * _CAUTION * sigma * math.sqrt(2.0 / time),
        rate_random_walk=0.0,
        bias_decay=0.0,
        initial_bias_deg_s=_OFFSET * sigma / time,
    )
    return dataclasses.replace(scenario, gyro=deviation)
