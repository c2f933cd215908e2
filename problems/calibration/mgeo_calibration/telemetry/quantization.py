"""Quantization of telemetry channels: estimation of step sizes, and the error of integrated
rates.
"""

from __future__ import annotations

import math

import numpy as np
from mgeo_attitude._typing import Bools, Floats

_MIN_SAMPLES = 20  # smallest number of samples for an estimate
_ROUNDING_TOLERANCE = 1e-7  # relative difference below which two values are equal up to rounding
_MAGNITUDE_QUANTILE = 0.9  # quantile of the magnitudes to which the difference is relative
_MAX_DEVIATION = 0.05  # largest deviation of a difference from a multiple of the step, in steps
_MIN_REGULAR_FRACTION = 0.99  # smallest fraction of differences within this deviation
_MAX_STEPS = 2.0**53  # largest number of steps that a float resolves; excludes outliers like 1e150
_MAX_PARTS = 25  # largest number of steps in the smallest difference
_MAX_REST_VALUES = 5  # largest number of distinct values that do not determine a step
#: Smallest ratio of quantization variance to noise variance that matters.
MIN_VARIANCE_RATIO = 1e-2


def estimate_quantization_steps(values: Floats) -> Floats:
    """Estimate the quantization step of each channel from its samples. Channels without
    quantization have a step of zero.

    A channel with few distinct values does not determine its step and has the finest step of the
    other channels.

    Parameters
    ----------
    values : array, shape (n, k)
        Samples; rows of NaN are ignored.
    """
    rows = values[np.isfinite(values).all(axis=1)]
    if len(rows) < _MIN_SAMPLES:
        return np.zeros(values.shape[1])
    steps = np.array([_estimate_step(channel) for channel in rows.T])
    counted = steps > 0.0
    rests = [len(np.unique(channel)) <= _MAX_REST_VALUES for channel in rows.T]
    steps[rests] = steps.min(where=counted, initial=np.inf) if counted.any() else 0.0
    return np.where(np.isfinite(steps), steps, 0.0)


def _estimate_step(channel: Floats) -> float:
    """Estimate the quantization step of one channel. Return zero without quantization, and NaN if
    there are too few distinct values.
    """
    apart = np.diff(np.sort(channel))
    # The quantile ignores outliers.
    apart = apart[apart > _ROUNDING_TOLERANCE * np.quantile(np.abs(channel), _MAGNITUDE_QUANTILE)]
    apart = apart[apart < _MAX_STEPS * apart.min(initial=np.inf)]
    repeat = 2 * len(apart) <= len(channel)
    for parts in range(1, _MAX_PARTS if repeat else 2) if len(apart) else ():
        multiples = np.rint(apart / apart.min() * parts)
        step = float(apart @ multiples / (multiples @ multiples))
        if (np.abs(apart / step - multiples) < _MAX_DEVIATION).mean() > _MIN_REGULAR_FRACTION:
            return step
    return np.nan if repeat else 0.0


def is_quantization_relevant(step: Floats, sigma: Floats) -> Bools:
    """Return True for each axis on which quantization adds noticeably to the noise variance."""
    result: Bools = step**2 / 12.0 >= MIN_VARIANCE_RATIO * np.square(sigma)
    return result


def compute_angle_variance_rate(
    rates: Floats, duration: float, step: Floats, sigma: Floats
) -> Floats:
    """Return how fast quantization of the gyro rates increases the variance of the integrated
    angle, for each sample and axis.

    The error of a rounded value has the variance step² / 12. Noise over several steps makes the
    error white. With less noise, part of the error is constant while the rate stays within about
    one step and then integrates like a bias. For noise of s steps this part of the variance is Σ
    exp(-4 π² m² s²) / (2 π² m²), m = 1, 2, ... (B. Widrow, I. Kollár, Quantization Noise, 2008,
    chapter 4). The samples show how long the rate stays within a step.

    Parameters
    ----------
    rates : array, shape (m, 3)
        Reported rates [rad/s].
    duration : float
        Time between samples [s].
    step : array, shape (3,)
        Quantization step of each axis [rad/s].
    sigma : array, shape (3,)
        1-sigma of the noise of a sample before rounding [rad/s].

    Returns
    -------
    array, shape (m, 3)
        Variance per time [rad²/s].
    """
    result = np.zeros(rates.shape)
    for axis in np.flatnonzero(is_quantization_relevant(step, sigma)):
        q = step[axis]
        m = np.arange(1, 50)
        ratio = sigma[axis] / q
        stays = (np.exp(-((2.0 * np.pi * m * ratio) ** 2)) / (2.0 * (np.pi * m) ** 2)).sum()
        levels = math.ceil(1.0 + 4.0 * ratio)
        length = _measure_stretches(np.rint(rates[:, axis] / q), levels)
        result[:, axis] = duration * q**2 * (1.0 / 12.0 + stays * (length - 1.0))
    return result


def _measure_stretches(counts: Floats, levels: int) -> Floats:
    """Divide a series of rounded values into intervals whose values differ by at most `levels`
    quantization steps. Return, for each sample, the length of its interval.
    """
    ends, low, high = [], counts[0], counts[0]
    for k, count in enumerate(counts.tolist()):
        low, high = min(low, count), max(high, count)
        if high - low > levels:
            ends.append(k)
            low = high = count
    edges = np.diff([0, *ends, len(counts)])
    lengths: Floats = np.repeat(edges, edges).astype(float)
    return lengths
