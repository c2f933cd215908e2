"""Quantized channels: the size of their steps, and the error of an angle."""

from __future__ import annotations

import math

import numpy as np
from mgeo_attitude._typing import Bools, Floats

_FEWEST = 20  # samples that can tell
_SAME = 1e-7  # numbers that differ by this share of a large one are one that was rounded
_MOST = 0.9  # share of numbers that are not larger than that
_OFF = 0.05  # how far a difference may be from a multiple of the step, in steps
_REGULAR = 0.99  # share of differences that are not farther
_COUNTED = 2.0**53  # steps that a number can tell; what is farther is no count, such as 1e150
_PARTS = 25  # steps in the smallest difference, at most
_RESTS = 5  # numbers that do not say much of a step
#: A step whose variance is a smaller share of the noise's is none.
LEAST = 1e-2


def resolution(values: Floats) -> Floats:
    """Return the step of each channel, zero if its numbers are no multiples of a step.

    A channel that rests at a few numbers, of which its step hardly follows, counts as the finest.

    Parameters
    ----------
    values : array, shape (n, k)
        Rows of NaN are no samples.
    """
    rows = values[np.isfinite(values).all(axis=1)]
    if len(rows) < _FEWEST:
        return np.zeros(values.shape[1])
    steps = np.array([_step(channel) for channel in rows.T])
    counted = steps > 0.0
    rests = [len(np.unique(channel)) <= _RESTS for channel in rows.T]
    steps[rests] = steps.min(where=counted, initial=np.inf) if counted.any() else 0.0
    return np.where(np.isfinite(steps), steps, 0.0)


def _step(channel: Floats) -> float:
    """Return zero if numbers hardly repeat without a step; NaN if they repeat without one."""
    apart = np.diff(np.sort(channel))
    apart = apart[apart > _SAME * np.quantile(np.abs(channel), _MOST)]  # few may be absurd
    apart = apart[apart < _COUNTED * apart.min(initial=np.inf)]
    repeat = 2 * len(apart) <= len(channel)
    for parts in range(1, _PARTS if repeat else 2) if len(apart) else ():
        multiples = np.rint(apart / apart.min() * parts)
        step = float(apart @ multiples / (multiples @ multiples))
        if (np.abs(apart / step - multiples) < _OFF).mean() > _REGULAR:
            return step
    return np.nan if repeat else 0.0


def matters(step: Floats, sigma: Floats) -> Bools:
    """Return whether the variance of steps is a relevant share of that of the noise, per axis."""
    found: Bools = step**2 / 12.0 >= LEAST * np.square(sigma)
    return found


def angle_variance(rates: Floats, duration: float, step: Floats, sigma: Floats) -> Floats:
    """Return the variance of the angle by steps, in each second, about each axis, (m, 3) [rad²/s].

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
