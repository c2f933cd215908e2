"""What gyro, sensors and orbit may do that a scenario does not say, linear about a solution."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Floats

from mgeo_calibration.estimation.score import Departure
from mgeo_calibration.estimation.smoother import Solution

#: Waves of a drift that is looked for, each of half a period more than the one before.
WAVES = 3


def bias_decay(solution: Solution) -> Departure:
    """The bias's inverse correlation time is larger by one over the time of the telemetry."""
    at, dt, bias = _biases(solution)
    decay, end = solution.batch.suite.gyro.bias_decay, dt.sum()
    left = np.exp(-decay * at)[:, None]
    more = np.cumsum(dt[:, None] * bias / left, axis=0) / end
    off = -left * np.vstack([np.zeros(3), more[:-1]])
    return _of_rates(solution, off[:, :, None], -np.exp(-decay * end) * more[-1:].T)


def bias_drift(solution: Solution) -> Departure:
    """The bias drifts by its initial 1-sigma about an axis in a wave, on top of its random walk."""
    at, dt, _ = _biases(solution)
    size = solution.batch.suite.gyro.states()["bias"]
    share = np.append(at, dt.sum()) / dt.sum()
    off = np.einsum("nw,ij->niwj", size * drifts(share), np.eye(3)).reshape(len(share), 3, -1)
    return _of_rates(solution, off[:-1], off[-1])


def drifts(share: Floats) -> Floats:
    """Waves at these shares of the time, shape (n, WAVES): from zero, and there and back."""
    half_periods = np.arange(1, WAVES + 1)
    waves: Floats = 0.5 - 0.5 * np.cos(np.pi * share[:, None] * half_periods)
    return waves


def _biases(solution: Solution) -> tuple[Floats, Floats, Floats]:
    """Time from the first sample and duration of each step [s], and the gyro's bias [rad/s]."""
    times = solution.batch.times
    return times[:-1] - times[0], np.diff(times), solution.trajectory.states[:-1, 3:6]


def _of_rates(solution: Solution, off: Floats, last: Floats | None = None) -> Departure:
    """Of a gyro that reports so much more in each step, shape (n, 3, k) [rad/s].

    Parameters
    ----------
    last : array, shape (3, k), optional
        That at the last sample, if it is of the bias.
    """
    parts, move = solution.parts, solution.steps
    if (parts.driven == 3).any():
        first = int(np.flatnonzero(parts.driven == 3)[0])
        turned = move.F[:, :3, first : first + 3]
    else:
        first = int(np.flatnonzero(parts.constant == 3)[0])
        turned = move.G[:, :3, first : first + 3] / move.growth[:-1, None, first : first + 3]
    moves = np.einsum("nij,njk->nik", turned, off)
    return Departure(width=off.shape[2], moves=moves, bias=last)
