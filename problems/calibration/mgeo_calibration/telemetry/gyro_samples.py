"""Samples of a gyro: rates between them, missing samples and spikes."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.suite import Suite
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter

from mgeo_calibration.telemetry.telemetry import Telemetry

#: A gyro's sample stands for the time since the one before, unless that is this many times the
#: usual time between two: then some are missing.
MISSING = 1.5
#: Without a sample for longer than this many times the usual time, nothing is known of the rate.
SILENT = 10.0
#: Times its scatter by which a sample that is no motion is off; samples that say how it scatters.
_FAR, _NEAR = 10.0, 11
_NORMAL = 1.4826  # 1-sigma of normal numbers over their median absolute deviation


def covered(at: Floats) -> Floats:
    """Return the time that each sample of a gyro represents [s], shape (m,).

    Parameters
    ----------
    at : array, shape (m,)
        Their times [s].
    """
    usual = float(np.median(np.diff(at)))
    since = np.diff(at, prepend=at[0] - usual)
    stands: Floats = np.where(since > MISSING * usual, usual, since)
    return stands


def turned(at: Floats, means: Floats) -> CubicSpline:
    """Return the integral of a smooth rate from its means over the times of samples.

    Where samples are missing the mean is taken half way between their neighbors. A spline's
    derivatives at its knots are of fourth order in the time between samples.

    Parameters
    ----------
    at : array, shape (m,)
        [s]
    means : array, shape (m, 3)
        [rad/s]
    """
    begin = at - covered(at)
    gap = np.flatnonzero(begin[1:] > at[:-1] + 1e-9 * np.diff(at)) + 1
    knots = np.sort(np.concatenate([begin[:1], at, begin[gap]]))
    j = np.searchsorted(at, knots[1:])
    middle = np.isin(knots[1:], begin[gap])[:, None]
    rates = np.where(middle, 0.5 * (means[j] + means[np.maximum(j - 1, 0)]), means[j])
    angle = np.cumsum(rates * np.diff(knots)[:, None], axis=0)
    return CubicSpline(knots, np.vstack([np.zeros(3), angle]))


def means(at: Floats, rates: Floats) -> Floats:
    """Return mean rates over the times of samples from rates at the samples, shape (m, 3).

    The means are those of a cubic spline through the samples, of fourth order in the time between
    them. The first mean is the sample itself.

    Parameters
    ----------
    at : array, shape (m,)
        [s]
    rates : array, shape (m, 3)
    """
    if len(at) < 2:
        return rates
    angle, stands = CubicSpline(at, rates).antiderivative(), covered(at)
    found: Floats = (angle(at) - angle(at - stands)) / stands[:, None]
    found[0] = rates[0]
    return found


def spikes(rates: Floats, least: Floats) -> Floats:
    """Return the distance of spikes from both neighbors, zero for other samples, shape (m, 3).

    A rate that jumps stays there; one that is back after a sample, or two, is a fault, or a turn
    within these that their neighbors do not show. What is wrong about one axis is doubtful about
    all.

    Parameters
    ----------
    rates : array, shape (m, 3)
    least : array, shape (3,)
        What samples scatter by at least, 1-sigma.
    """
    found = np.zeros(rates.shape)
    if len(rates) < _NEAR:
        return found
    for many in (1, 2):
        last, after = rates[: -many - 1], rates[many + 1 :]
        inner = [rates[1 + k : len(last) + 1 + k] for k in range(many)]
        off = np.stack(inner) - 0.5 * (last + after)
        size = np.abs(off).min(axis=0)
        apart = (size > _FAR * np.sqrt(1.5) * least) & (size > np.abs(after - last))
        if not apart.any():  # as mostly: what is usual is not asked for
            continue
        apart &= size > _FAR * _NORMAL * median_filter(size, (_NEAR, 1))
        (first,) = np.nonzero(apart.any(axis=1))
        for k in range(many):
            found[first + 1 + k] = off[k, first]
    return found


def reported(telemetry: Telemetry) -> tuple[Floats, Floats]:
    """Return times, shape (m,) [s], and rates, shape (m, 3) [rad/s], of the gyro's samples.

    Raises
    ------
    ValueError
        For fewer than two samples, between which nothing is known of the attitude.
    """
    there = np.isfinite(telemetry.gyro_deg_s[:, 0])
    if there.sum() < 2:
        raise ValueError(f"gyro: {there.sum()} samples: expected 2 or more")
    return telemetry.times[there], np.radians(telemetry.gyro_deg_s[there])


def usual_step(at: Floats) -> float:
    """Return the median time between samples of the gyro [s]."""
    return float(np.median(np.diff(at)))


def gyro_noise(suite: Suite, duration: float) -> Floats:
    """Return the 1-sigma of a mean rate over a duration [s], of each axis [rad/s]."""
    noise: Floats = np.sqrt(np.array(suite.gyro.diffusion()["theta"]) / duration)
    return noise


def gyro_spikes(suite: Suite, telemetry: Telemetry) -> Floats:
    """Return the `spikes` of the gyro's samples, shape (m, 3) [rad/s]."""
    at, rates = reported(telemetry)
    step = np.radians(telemetry.step_of("gyro"))
    return spikes(rates, np.maximum(gyro_noise(suite, usual_step(at)), step))


def rate_steps(
    times: Floats, at: Floats, rates: Floats, usual: float
) -> tuple[Floats, Floats, Floats, Bools]:
    """Return rate, change of rate, attitude variance, and missing rates of each step.

    Within the time that a sample stands for, the rate is that of `turned`; over all of
    it the mean is the sample. Elsewhere it does not change.

    Parameters
    ----------
    times : array, shape (n + 1,)
        Between which the steps are.
    at : array, shape (m,)
        Times of the gyro's samples.
    rates : array, shape (m, 3)
        Mean rates before them [rad/s].
    usual : float
        Time between them.
    """
    start, end = times[:-1], times[1:]
    j = np.minimum(np.searchsorted(at, end), len(at) - 1)
    before = np.maximum(j - 1, 0)
    since = np.where(j > before, at[j] - at[before], usual)
    since[end > at[-1]] = usual
    stands = covered(at)[j]
    known = np.clip(np.minimum(end, at[j]) - np.maximum(start, at[j] - stands), 0.0, None)
    missing = (end - start) - known
    missing[missing < 1e-9 * usual] = 0.0
    middle, half = 0.5 * (rates[j] + rates[before]), 0.5 * np.abs(rates[j] - rates[before])
    gyro = (known[:, None] * rates[j] + missing[:, None] * middle) / (end - start)[:, None]
    # one guess serves all steps of a gap: their errors add up, not their squares
    variance = missing * np.maximum(since - stands, missing) * (half**2).max(axis=1)
    angle, inside = turned(at, rates), missing == 0.0
    part = inside & (known < (1.0 - 1e-9) * stands)
    if part.any():
        gyro[part] = (angle(end[part]) - angle(start[part])) / (end - start)[part, None]
    change = np.where(inside[:, None], np.diff(angle(times, 1), axis=0), 0.0)
    return gyro, change, variance, (missing > 0.0) & ((since > SILENT * usual) | (j == 0))
