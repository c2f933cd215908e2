"""Gyro samples: mean rates in given time steps, missing samples, spikes and noise."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.suite import Suite
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter

from mgeo_calibration.telemetry.telemetry import Telemetry

#: Ratio of the time between two samples to the usual time above which samples are missing. A sample
#: is otherwise the mean over the time since the previous sample.
MISSING_SAMPLE_RATIO = 1.5
#: Ratio of the time between two samples to the usual time above which the rate is unknown.
UNKNOWN_RATE_RATIO = 10.0
#: Smallest size of a spike relative to the scatter, and number of samples for the scatter.
_MIN_SPIKE_RATIO, _N_NEIGHBORS = 10.0, 11
# ratio of 1-sigma to the median absolute deviation of a normal distribution
_SIGMA_PER_MAD = 1.4826


def compute_averaging_durations(sample_times: Floats) -> Floats:
    """Return the duration over which each gyro sample averages the rate. It is the time since the
    previous sample, or the median step after a gap.

    Parameters
    ----------
    sample_times : array, shape (m,)
        Times of the samples [s].

    Returns
    -------
    array, shape (m,)
        [s]
    """
    usual = float(np.median(np.diff(sample_times)))
    since = np.diff(sample_times, prepend=sample_times[0] - usual)
    durations: Floats = np.where(since > MISSING_SAMPLE_RATIO * usual, usual, since)
    return durations


def integrate_rates(sample_times: Floats, mean_rates: Floats) -> CubicSpline:
    """Integrate mean gyro rates into a cubic spline of the rotation angle about each axis.

    Knots at missing samples have the mean of their neighbors. Derivatives of the spline at its
    knots have fourth-order accuracy in the time between samples.

    Parameters
    ----------
    sample_times : array, shape (m,)
        Times of the samples [s].
    mean_rates : array, shape (m, 3)
        Mean rate of each sample [rad/s].

    Returns
    -------
    CubicSpline
        Rotation angle about each axis [rad].
    """
    begin = sample_times - compute_averaging_durations(sample_times)
    gap = np.flatnonzero(begin[1:] > sample_times[:-1] + 1e-9 * np.diff(sample_times)) + 1
    knots = np.sort(np.concatenate([begin[:1], sample_times, begin[gap]]))
    j = np.searchsorted(sample_times, knots[1:])
    middle = np.isin(knots[1:], begin[gap])[:, None]
    rates = np.where(
        middle, 0.5 * (mean_rates[j] + mean_rates[np.maximum(j - 1, 0)]), mean_rates[j]
    )
    angle = np.cumsum(rates * np.diff(knots)[:, None], axis=0)
    return CubicSpline(knots, np.vstack([np.zeros(3), angle]))


def compute_mean_rates(sample_times: Floats, rates: Floats) -> Floats:
    """Convert instantaneous gyro rates to mean rates since the previous sample.

    The means follow from a cubic spline through the samples, with fourth-order accuracy in the time
    between samples. The first mean is the sample itself.

    Parameters
    ----------
    sample_times : array, shape (m,)
        Times of the samples [s].
    rates : array, shape (m, 3)
        Rates at the samples.

    Returns
    -------
    array, shape (m, 3)
        In the unit of `rates`.
    """
    if len(sample_times) < 2:
        return rates
    angle, durations = (
        CubicSpline(sample_times, rates).antiderivative(),
        compute_averaging_durations(sample_times),
    )
    result: Floats = (angle(sample_times) - angle(sample_times - durations)) / durations[:, None]
    result[0] = rates[0]
    return result


def find_spikes(rates: Floats, min_scatter: Floats) -> Floats:
    """Return the size of isolated spikes in gyro rates, relative to the mean of their neighbors.
    Rows without a spike are zero.

    A spike returns after one or two samples, unlike a step of the rate. A spike on one axis is
    reported on all axes.

    Parameters
    ----------
    rates : array, shape (m, 3)
    min_scatter : array, shape (3,)
        Smallest scatter of the samples, 1-sigma.

    Returns
    -------
    array, shape (m, 3)
        In the unit of `rates`.
    """
    result = np.zeros(rates.shape)
    if len(rates) < _N_NEIGHBORS:
        return result
    for many in (1, 2):
        last, after = rates[: -many - 1], rates[many + 1 :]
        inner = [rates[1 + k : len(last) + 1 + k] for k in range(many)]
        off = np.stack(inner) - 0.5 * (last + after)
        size = np.abs(off).min(axis=0)
        apart = (size > _MIN_SPIKE_RATIO * np.sqrt(1.5) * min_scatter) & (
            size > np.abs(after - last)
        )
        if not apart.any():  # Skip the expensive median filter for data without spikes.
            continue
        apart &= size > _MIN_SPIKE_RATIO * _SIGMA_PER_MAD * median_filter(size, (_N_NEIGHBORS, 1))
        (first,) = np.nonzero(apart.any(axis=1))
        for k in range(many):
            result[first + 1 + k] = off[k, first]
    return result


def select_gyro_samples(telemetry: Telemetry) -> tuple[Floats, Floats]:
    """Return the times and the rates of all samples with a gyro reading.

    Returns
    -------
    times : array, shape (m,)
        [s]
    rates : array, shape (m, 3)
        [rad/s]

    Raises
    ------
    ValueError
        If there are fewer than two samples.
    """
    reported = np.isfinite(telemetry.gyro_deg_s[:, 0])
    if reported.sum() < 2:
        raise ValueError(f"gyro: {reported.sum()} samples: expected 2 or more")
    return telemetry.times[reported], np.radians(telemetry.gyro_deg_s[reported])


def compute_median_step(sample_times: Floats) -> float:
    """Return the median time between gyro samples [s]."""
    return float(np.median(np.diff(sample_times)))


def compute_rate_sigma(suite: Suite, duration: float) -> Floats:
    """Return the 1-sigma noise about each axis of a gyro rate that is averaged over a given
    duration.

    Returns
    -------
    array, shape (3,)
        [rad/s]
    """
    noise: Floats = np.sqrt(np.array(suite.gyro.compute_noise_density()["theta"]) / duration)
    return noise


def find_gyro_spikes(suite: Suite, telemetry: Telemetry) -> Floats:
    """Return the size of isolated spikes in the gyro telemetry, relative to the mean of their
    neighbors. Rows without a spike are zero.

    Returns
    -------
    array, shape (m, 3)
        [rad/s]
    """
    at, rates = select_gyro_samples(telemetry)
    step = np.radians(telemetry.find_quantization_steps("gyro"))
    return find_spikes(rates, np.maximum(compute_rate_sigma(suite, compute_median_step(at)), step))


def compute_step_rates(
    times: Floats, sample_times: Floats, rates: Floats, median_step: float
) -> tuple[Floats, Floats, Floats, Bools]:
    """Interpolate gyro samples to the mean rate and the change of rate in each time step, with the
    uncertainty due to missing samples.

    Within the duration that a sample covers, the rate is the derivative of `integrate_rates`, with
    the sample as its mean. In gaps, the rate is the constant mean of both neighbors.

    Parameters
    ----------
    times : array, shape (n + 1,)
        Boundaries of the steps [s].
    sample_times : array, shape (m,)
        Times of the gyro samples [s].
    rates : array, shape (m, 3)
        Mean rate of each sample [rad/s].
    median_step : float
        Usual time between gyro samples [s].

    Returns
    -------
    gyro : array, shape (n, 3)
        Mean rate of each step [rad/s].
    change : array, shape (n, 3)
        Change of the rate in each step [rad/s].
    variance : array, shape (n,)
        Variance of the angle due to missing samples [rad²].
    missing : array of bool, shape (n,)
        True if the rate is unknown.
    """
    start, end = times[:-1], times[1:]
    j = np.minimum(np.searchsorted(sample_times, end), len(sample_times) - 1)
    before = np.maximum(j - 1, 0)
    since = np.where(j > before, sample_times[j] - sample_times[before], median_step)
    since[end > sample_times[-1]] = median_step
    durations = compute_averaging_durations(sample_times)[j]
    known = np.clip(
        np.minimum(end, sample_times[j]) - np.maximum(start, sample_times[j] - durations), 0.0, None
    )
    missing = (end - start) - known
    missing[missing < 1e-9 * median_step] = 0.0
    middle, half = 0.5 * (rates[j] + rates[before]), 0.5 * np.abs(rates[j] - rates[before])
    gyro = (known[:, None] * rates[j] + missing[:, None] * middle) / (end - start)[:, None]
    # All steps of a gap share one rate: their errors are fully correlated.
    variance = missing * np.maximum(since - durations, missing) * (half**2).max(axis=1)
    angle, inside = integrate_rates(sample_times, rates), missing == 0.0
    part = inside & (known < (1.0 - 1e-9) * durations)
    if part.any():
        gyro[part] = (angle(end[part]) - angle(start[part])) / (end - start)[part, None]
    change = np.where(inside[:, None], np.diff(angle(times, 1), axis=0), 0.0)
    return (
        gyro,
        change,
        variance,
        (missing > 0.0) & ((since > UNKNOWN_RATE_RATIO * median_step) | (j == 0)),
    )
