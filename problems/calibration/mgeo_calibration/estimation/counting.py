"""What a gyro that counts in steps adds to the angle that it is integrated to."""

from __future__ import annotations

import math

import numpy as np
from mgeo_attitude._typing import Bools, Floats

#: A step whose variance is a smaller share of the noise's is none.
LEAST = 1e-2


def matters(step: Floats, sigma: Floats) -> Bools:
    """Whether what steps add is a share of the noise that counts, per axis."""
    found: Bools = step**2 / 12.0 >= LEAST * np.square(sigma)
    return found


def angle_variance(rates: Floats, duration: float, step: Floats, sigma: Floats) -> Floats:
    """Variance that steps add to the angle in each second, about each axis, shape (m, 3) [rad²/s].

    A rounded number is off by step² / 12. If noise moves it over several steps that is white, and
    adds up as noise does. If not, part of it stays as long as the rate stays within a step or so:
    it grows like a bias, as the time squared, and is another one then. Of noise of so many steps s
    that part is Σ exp(-4 π² m² s²) / (2 π² m²), m = 1, 2, ... (B. Widrow, I. Kollár, Quantization
    Noise, 2008, chapter 4). How long a rate stays is seen in its samples.

    Parameters
    ----------
    rates : array, shape (m, 3)
        As they were reported [rad/s].
    duration : float
        Time between them [s].
    step : array, shape (3,)
        [rad/s]
    sigma : array, shape (3,)
        Noise of a sample before it is rounded, 1-sigma [rad/s].
    """
    found = np.zeros(rates.shape)
    for axis in np.flatnonzero(matters(step, sigma)):
        q = step[axis]
        m = np.arange(1, 50)
        ratio = sigma[axis] / q
        stays = (np.exp(-((2.0 * np.pi * m * ratio) ** 2)) / (2.0 * (np.pi * m) ** 2)).sum()
        levels = math.ceil(1.0 + 4.0 * ratio)
        length = _lengths(np.rint(rates[:, axis] / q), levels)
        found[:, axis] = duration * q**2 * (1.0 / 12.0 + stays * (length - 1.0))
    return found


def _lengths(counts: Floats, levels: int) -> Floats:
    """Of the stretches in which counts differ by so many at most, for each of the counts."""
    ends, low, high = [], counts[0], counts[0]
    for k, count in enumerate(counts.tolist()):
        low, high = min(low, count), max(high, count)
        if high - low > levels:
            ends.append(k)
            low = high = count
    edges = np.diff([0, *ends, len(counts)])
    lengths: Floats = np.repeat(edges, edges).astype(float)
    return lengths
