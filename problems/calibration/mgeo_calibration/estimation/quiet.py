"""Body rates as something to explain readings by: without the noise of the step that they are of.

What a delay or a gyro's scale factor adds is a multiple of the rate, which the gyro alone tells,
with the noise that also is in the attitude. Beside a star tracker that is better than a step of the
gyro, readings are explained by that noise: a perfect satellite is told to be late by half a step
(W. A. Fuller, Measurement Error Models, Wiley 1987). So the rate of a step is then that of others
about it, of which the attitude knows nothing any more.
"""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Floats

from mgeo_calibration.estimation.kinematics import turns
from mgeo_calibration.estimation.smoother import Solution
from mgeo_calibration.estimation.trajectory import SPAN

#: Steps next to one, on either side, that are left out, and those after them that count.
_LEFT_OUT, _COUNTED = 8, 16
#: Chi-square that the gyro's noise may explain by chance.
_BY_CHANCE = 1.0


def quiet_rates(solution: Solution) -> Floats:
    """Body rate in each step, shape (N - 1, 3) [rad/s], for what is linear in it.

    Where readings are too rough to see the gyro's noise, or there are few, that is what the gyro
    says. Else it is a parabola through the rates about the step: one that changes within some
    twenty steps is blurred.
    """
    batch = solution.batch
    rates, _ = turns(batch, solution.trajectory.states)
    n, reach = len(rates), _LEFT_OUT + _COUNTED
    if n <= 2 * reach or n * _seen(solution) < _BY_CHANCE:
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


def _seen(solution: Solution) -> float:
    """Share of the gyro's noise of a step in what the best sensor says of the attitude after it."""
    batch = solution.batch
    part = solution.equations(0, min(len(batch.times), SPAN))
    density = batch.suite.gyro.diffusion()["theta"] * float(np.median(batch.durations))
    found = 0.0
    for index, H in enumerate(part.sightings.H[..., :3]):
        k = int(part.sightings.numbers[index])
        by = np.linalg.norm(H[:, :k], axis=2) / batch.noise[index, :k]
        best = float(by.max(initial=0.0))
        found = max(found, density * best**2)
    return found / (1.0 + found)
