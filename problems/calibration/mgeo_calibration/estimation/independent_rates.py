"""Body rates as regressors of score tests, independent of the gyro noise in the attitude.

What a delay or a gyro's scale factor adds is a multiple of the rate, which the gyro alone tells,
with the noise that also is in the attitude. Beside a star tracker that is better than a step of the
gyro, readings are explained by that noise: a perfect satellite is told to be late by half a step
(W. A. Fuller, Measurement Error Models, Wiley 1987). So the rate of a step is then that of others
about it, of which the attitude knows nothing any more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from mgeo_attitude._typing import Floats

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.kinematics import turns

if TYPE_CHECKING:
    from mgeo_calibration.estimation.smoother import Solution

#: Steps next to one, on either side, that are left out, and those after them that count.
_LEFT_OUT, _COUNTED = 8, 16
#: Chi-square that the gyro's noise may explain by chance.
_BY_CHANCE = 1.0


def independent_rates(solution: Solution) -> Floats:
    """Body rate in each step, shape (N - 1, 3) [rad/s], for what is linear in it.

    Where readings are too rough to see the gyro's noise, or there are few, that is what the gyro
    says. Else `without_noise`.
    """
    rates, _ = turns(solution.batch, solution.trajectory.states)
    return without_noise(rates) if any(see_noise(solution)) else rates


def see_noise(solution: Solution) -> list[bool]:
    """Of each sensor whether its readings show the gyro's noise of single steps."""
    batch = solution.batch
    n, found = len(batch.times), next(solution.spans()).sightings
    return [
        (n - 1) * _share(batch, H[:, :k], batch.noise[index]) > _BY_CHANCE
        for index, (H, k) in enumerate(zip(found.H[..., :3], found.numbers, strict=True))
    ]


def without_noise(rates: Floats) -> Floats:
    """A parabola through the rates about each step but those next to it, shape (n, 3).

    A rate that changes within some twenty steps is blurred. Of few steps they are what they are.
    """
    reach = _LEFT_OUT + _COUNTED
    if len(rates) <= 2 * reach:
        return rates
    padded = np.concatenate([rates[reach:0:-1], rates, rates[-2 : -2 - reach : -1]])
    weights = _weights()
    return np.stack([np.convolve(column, weights, "valid") for column in padded.T], axis=1)


def _weights() -> Floats:
    """Of the steps about one: those of the least squares of a parabola at its middle."""
    away = np.arange(-_LEFT_OUT - _COUNTED, _LEFT_OUT + _COUNTED + 1.0)
    counted = np.abs(away) > _LEFT_OUT
    basis = np.stack([np.ones(counted.sum()), away[counted] ** 2], axis=1)
    weights = np.zeros(len(away))
    weights[counted] = np.linalg.pinv(basis)[0]
    return weights


def _share(batch: Batch, H: Floats, noise: Floats) -> float:
    """Of the gyro's noise of a step in what a sensor says of the attitude after it."""
    variance = np.array(batch.suite.gyro.diffusion()["theta"]) * np.median(batch.durations)
    shown = np.linalg.norm(H * np.sqrt(variance), axis=2) / noise[: H.shape[1]]
    found = float(shown.max(initial=0.0)) ** 2
    return found / (1.0 + found)
