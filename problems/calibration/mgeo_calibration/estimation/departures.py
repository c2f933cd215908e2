"""Regressors of score tests for errors that the scenario does not model.

All regressors are linear about a smoother solution and follow from the smoothed trajectory, whose
errors are independent of the residuals. The measured gyro rates are not independent: their noise is
part of the residuals, and a healthy gyro at rest would appear to have a scale factor error of 100 %
(W. A. Fuller, Measurement Error Models, Wiley 1987).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import matrix, shear, skew
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

from mgeo_calibration.estimation.kinematics import turns
from mgeo_calibration.estimation.linearization import Equations, misfit
from mgeo_calibration.estimation.score import Combined, Departure
from mgeo_calibration.estimation.smoother import Solution

#: Number of equal parts of the data. A slowly varying offset is piecewise linear over the parts.
PARTS = 8
#: Number of half waves in the model of a slow drift.
WAVES = 3
#: Cycles over the data of the sinusoids that represent gyro noise; all are faster than a drift.
CYCLES = (3.0, 6.0, 12.0, 24.0)
#: Savitzky-Golay filter of the rates: window lengths in steps, polynomial order, variance gain of
#: differences of the next order for white noise, and largest change of the rates by the filter in
#: units of their noise.
_WIDTHS, _ORDER, _GAIN, _BLUR = (33, 17, 9, 5), 2, 20.0, 1.5
#: Error sizes for a coefficient of one. A combination of coefficients with a larger 1-sigma is not
#: tested.
LARGE_DELAY_S = 10.0
LARGE_AXES_ERROR = 0.1
LARGE_OFFSET = 10.0  # in units of the 1-sigma of a sensor's noise
#: Function from the fraction of elapsed time, shape (n,), to k offset profiles, shape (n, k).
Course = Callable[[Floats], Floats]
#: Function that returns the rate of a sensor's readings due to the inertial motion of the observed
#: vector, shape (n, 3) [1/s].
VectorRates = Callable[[Equations, int], Floats]


def smoothed_rates(solution: Solution) -> Floats:
    """Return the mean body rate of the smoothed attitude in each step, shape (N - 1, 3) [rad/s].

    If the declared gyro noise is too large, the smoothed attitude follows the noise of single
    readings. The rates are therefore filtered over as many steps as the motion allows (A. Savitzky,
    M. J. E. Golay, Analytical Chemistry 36 (1964) 1627-1639).
    """
    rates = _compute_attitude_rates(solution)
    noise = np.median(np.abs(np.diff(rates, _ORDER + 1, axis=0)), axis=0) / math.sqrt(_GAIN)
    for width in _WIDTHS:
        if width < len(rates):
            result = savgol_filter(rates, width, _ORDER, axis=0)
            if (np.median(np.abs(rates - result), axis=0) <= _BLUR * noise).all():
                return np.asarray(result, dtype=np.float64)
    return rates


def gyro_walk(solution: Solution) -> float:
    """Return the angle random walk of the gyro relative to the smoothed attitude [rad/sqrt(s)]."""
    batch = solution.batch
    rates, _ = turns(batch, solution.estimate.states)
    off = (rates - _compute_attitude_rates(solution))[~batch.breaks]
    return float(np.sqrt(np.mean(off**2 * batch.durations[~batch.breaks, None])))


def _compute_attitude_rates(solution: Solution) -> Floats:
    attitude, batch = solution.estimate.attitude, solution.batch
    turn = attitude[:-1].swapaxes(1, 2) @ attitude[1:]
    rates: Floats = Rotation.from_matrix(turn).as_rotvec() / batch.durations[:, None]
    rates[batch.breaks] = 0.0
    return rates


def bias_decay(solution: Solution) -> Departure:
    """Return the regressors of a gyro bias with a different correlation time.

    A coefficient of one increases the inverse correlation time by one over the duration of the
    data.
    """
    times = solution.batch.times
    at, dt, bias = times - times[0], np.diff(times), solution.estimate.states[:-1, 3:6]
    left = np.exp(-solution.batch.suite.gyro.bias_decay * at)[:, None]
    more = np.cumsum(dt[:, None] * bias / left[:-1], axis=0) / at[-1]
    off = -left * np.vstack([np.zeros(3), more])
    return _build_gyro_departure(lambda own: off[own.low : own.high - 1, :, None], 1, off[-1:].T)


def bias_drift(solution: Solution) -> Departure:
    """Return the regressors of a gyro bias that drifts.

    A coefficient of one changes the bias by its initial 1-sigma within one of the `PARTS` of the
    data.
    """
    share, size = _compute_elapsed_fractions(solution), solution.batch.suite.gyro.states()["bias"]

    def moves(own: Equations) -> Floats:
        rises = size * risen(share[own.low : own.high - 1])
        result: Floats = rises[:, None, :, None] * _compute_rate_sensitivity(own)[:, :, None]
        return result.reshape(len(rises), 3, -1)

    return Departure(width=3 * PARTS, moves=moves, bias=np.tile(size * np.eye(3), PARTS))


def gyro_noise(solution: Solution) -> Departure:
    """Return the regressors of sinusoidal gyro errors with `CYCLES` cycles about each axis.

    The amplitude equals the 1-sigma of the gyro noise in one step. The departure represents gyro
    noise that exceeds the declared noise.
    """
    batch = solution.batch
    density = np.sqrt(np.array(batch.suite.gyro.diffusion()["theta"]))
    size, share = (
        density / np.sqrt(np.median(batch.durations)),
        _compute_elapsed_fractions(solution),
    )

    def off(own: Equations) -> Floats:
        phase = 2.0 * np.pi * share[own.low : own.high - 1, None] * np.array(CYCLES)
        waves = np.concatenate([np.sin(phase), np.cos(phase)], axis=1)
        result: Floats = waves[:, None, :, None] * np.diag(size)[:, None]
        return result.reshape(len(waves), 3, -1)

    return _build_gyro_departure(off, 6 * len(CYCLES))


def gyro_error(rates: Floats, state: str) -> Departure:
    """Return the regressors of one calibration parameter of the gyro.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        Body rates from `smoothed_rates` [rad/s].
    state : str
        "scale_factor", "misalignment", "nonorthogonality" or "scale_asymmetry".
    """
    return _build_gyro_departure(
        lambda own: _compute_vector_changes(state, rates[own.low : own.high - 1]), 3
    )


def gyro_early(rates: Floats, durations: Floats) -> Departure:
    """Return the regressors of a gyro that reports rates `LARGE_DELAY_S` ahead of its time stamps.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        Body rates from `smoothed_rates` [rad/s].
    durations : array, shape (N - 1,)
        Durations of the steps [s].
    """

    def changes(own: Equations) -> Floats:
        steps = np.arange(own.low, own.high - 1)
        change = rates[steps] - rates[np.maximum(steps - 1, 0)]
        result: Floats = LARGE_DELAY_S * change / durations[steps, None]
        return result[:, :, None]

    return _build_gyro_departure(changes, 1)


def gyro_follows(solution: Solution, channel: Floats) -> Departure:
    """Return the regressors of a gyro bias that is proportional to a channel, shape (N,)."""
    size = solution.batch.suite.gyro.states()["bias"]
    return _build_gyro_departure(
        lambda own: size * channel[own.low : own.high - 1, None, None] * np.eye(3),
        3,
        size * channel[-1] * np.eye(3),
    )


def vector_rates(solution: Solution) -> VectorRates:
    """Return a cached `VectorRates` function of the solution."""
    sensors = len(solution.batch.suite.sensors)
    return lru_cache(maxsize=sensors)(partial(_compute_vector_rate, solution))


def delay(index: int, rates: Floats, changes: VectorRates) -> Departure:
    """Return the regressors of a sensor with readings that are `LARGE_DELAY_S` old.

    Parameters
    ----------
    index : int
        Index of the sensor in the suite.
    rates : array, shape (N - 1, 3)
        Body rates from `smoothed_rates` [rad/s].
    changes : VectorRates
        Function from `vector_rates`.
    """

    def reads(own: Equations) -> Floats:
        before = rates[np.maximum(np.arange(own.low, own.high) - 1, 0)]
        turned = np.einsum("nij,nj->ni", _select_jacobian(own, index, 0), before)
        result: Floats = -LARGE_DELAY_S * (turned + changes(own, index))
        return result[:, :, None]

    return Departure(width=1, reads={index: reads})


def along_track(sensors: int, changes: VectorRates) -> Departure:
    """Return the regressors of an orbit that lags by `LARGE_DELAY_S` along the track.

    Parameters
    ----------
    sensors : int
        Number of sensors in the suite.
    changes : VectorRates
        Function from `vector_rates`.
    """

    def reads(index: int) -> Callable[[Equations], Floats]:
        return lambda own: -LARGE_DELAY_S * changes(own, index)[:, :, None]

    return Departure(width=1, reads={index: reads(index) for index in range(sensors)})


def vector_error(index: int, state: str) -> Departure:
    """Return the regressors of scale factors or non-orthogonality of a vector sensor.

    For a satellite that holds an attitude, the vectors are those at the held attitude, because the
    smoothed attitude contains the pointing error that is part of the innovations.
    """

    def reads(own: Equations) -> Floats:
        batch, at = own.batch, own.trajectory
        first = batch.suite.places(batch.suite.sensors[index]).get("misalignment")
        attitude = at.attitude if batch.held is None else batch.held.attitude
        body = np.einsum("nji,nj->ni", attitude, batch.vectors[:, index])
        mounted = np.eye(3) if first is None else matrix(at.states[0, first : first + 3])
        columns: Floats = mounted @ _compute_vector_changes(state, body)
        return columns

    return Departure(width=3, reads={index: reads})


def wander(solution: Solution, index: int) -> Departure:
    """Return the regressors of a sensor offset that drifts.

    A coefficient of one changes the offset by `LARGE_OFFSET` within one of the `PARTS` of the data.
    """
    share = _compute_elapsed_fractions(solution)

    def reads(own: Equations) -> Floats:
        rises = risen(share[own.low : own.high])
        result = rises[:, None, :, None] * _compute_offset_columns(own, index)[:, :, None]
        return result.reshape(len(rises), 3, -1)

    return Departure(width=3 * PARTS, reads={index: reads})


def follows(index: int, channel: Floats) -> Departure:
    """Return the regressors of a sensor offset that is proportional to a channel, shape (N,)."""

    def reads(own: Equations) -> Floats:
        return channel[own.low : own.high, None, None] * _compute_offset_columns(own, index)

    return Departure(width=3, reads={index: reads})


def turns_with(index: int, channel: Floats) -> Departure:
    """Return the regressors of a sensor misalignment proportional to a channel, shape (N,)."""

    def reads(own: Equations) -> Floats:
        by_attitude = -_select_jacobian(own, index, 0)
        return LARGE_AXES_ERROR * channel[own.low : own.high, None, None] * by_attitude

    return Departure(width=3, reads={index: reads})


def risen(share: Floats) -> Floats:
    """Return ramps from zero to one, one within each part of the data, shape (n, PARTS).

    Parameters
    ----------
    share : array, shape (n,)
        Fraction of elapsed time.
    """
    rises: Floats = np.clip(PARTS * share[:, None] - np.arange(PARTS), 0.0, 1.0)
    return rises


def step(number: int) -> Course:
    """Return the offset profile that rises from zero to one within one part of the data."""
    return lambda share: risen(share)[:, [number]]


def ramp(share: Floats) -> Floats:
    """Return the offset profile that is proportional to time, shape (n, 1)."""
    return share[:, None]


def waves(share: Floats) -> Floats:
    """Return cosine profiles of one to `WAVES` half waves that start at zero, shape (n, WAVES)."""
    half_periods = np.arange(1, WAVES + 1)
    result: Floats = 0.5 - 0.5 * np.cos(np.pi * share[:, None] * half_periods)
    return result


def along(rises: Departure, courses: Sequence[Course]) -> tuple[Combined, ...]:
    """Return the regressors of each profile, piecewise linear over the parts of the data.

    Parameters
    ----------
    rises : Departure
        Departure with a coefficient for each part and axis, from `bias_drift` or `wander`.
    courses : sequence of Course
        Offset profiles.
    """
    ends = np.linspace(0.0, 1.0, PARTS + 1)
    return tuple(
        Combined(rises, np.asarray(np.kron(np.diff(of(ends), axis=0), np.eye(3)), dtype=np.float64))
        for of in courses
    )


def _compute_elapsed_fractions(solution: Solution) -> Floats:
    times = solution.batch.times
    fractions: Floats = (times - times[0]) / (times[-1] - times[0])
    return fractions


def _build_gyro_departure(
    off: Callable[[Equations], Floats], width: int, last: Floats | None = None
) -> Departure:
    """Return the regressors of a gyro with an additive rate error.

    Parameters
    ----------
    off : function of Equations
        Rate error in each step for each of the coefficients, shape (n - 1, 3, k) [rad/s].
    width : int
        Number k of coefficients.
    last : array, shape (3, k), optional
        Change of the gyro bias at the last sample, if the rate error is a bias error.
    """

    def moves(own: Equations) -> Floats:
        moved: Floats = _compute_rate_sensitivity(own) @ off(own)
        return moved

    return Departure(width=width, moves=moves, bias=last)


def _compute_rate_sensitivity(own: Equations) -> Floats:
    """Return the attitude error per gyro rate error in each step, shape (n - 1, 3, 3) [s]."""
    parts, move = own.parts, own.steps
    if (parts.driven == 3).any():
        first = int(np.flatnonzero(parts.driven == 3)[0])
        return move.F[:, :3, first : first + 3]
    first = int(np.flatnonzero(parts.constant == 3)[0])
    turned: Floats = move.G[:, :, first : first + 3] / move.growth[:-1, None, first : first + 3]
    return turned


def _compute_vector_changes(state: str, vectors: Floats) -> Floats:
    """Return the change of vectors for each axis of a calibration parameter, shape (n, 3, 3).

    The parameter has the size `LARGE_AXES_ERROR`.
    """
    if state == "misalignment":
        columns: Floats = -np.moveaxis(skew(vectors.T), -1, 0)
    elif state == "nonorthogonality":
        columns = np.stack([shear(axis, vectors) for axis in np.eye(3)], axis=-1)
    else:
        by_axis = np.abs(vectors) if state == "scale_asymmetry" else vectors
        columns = by_axis[:, :, None] * np.eye(3)
    return LARGE_AXES_ERROR * columns


def _compute_vector_rate(solution: Solution, own: Equations, index: int) -> Floats:
    whole, vectors = solution.batch, own.batch.vectors.copy()
    low, high = max(0, own.low - 1), min(len(whole.times), own.high + 1)
    rate = np.gradient(whole.vectors[low:high, index], whole.times[low:high], axis=0)
    vectors[:, index] += rate[own.low - low : own.high - low]
    later = dataclasses.replace(own.batch, vectors=vectors)
    samples, z = misfit(later, index, own.trajectory)
    change = np.zeros((len(vectors), 3))
    k = z.shape[1]
    change[samples, :k] = own.sightings.z[index, samples, :k] - z
    return change


def _compute_offset_columns(own: Equations, index: int) -> Floats:
    """Return the change of the readings by an offset on each axis, shape (n, 3, 3)."""
    suite = own.batch.suite
    sensor = suite.sensors[index]
    places = suite.places(sensor)
    if (state := sensor.offset) in places:
        columns = _select_jacobian(own, index, places[state])
    else:  # A misalignment rotates the readings opposite to an attitude error.
        columns = -_select_jacobian(own, index, 0)
    offset: Floats = LARGE_OFFSET * float(np.max(sensor.noise())) * columns
    return offset


def _select_jacobian(own: Equations, index: int, first: int) -> Floats:
    seen, parts = own.sightings, own.parts
    driven, constants = seen.counts[index]
    places = seen.columns[index]
    states = np.concatenate([parts.driven[places[:driven]], parts.constant[places[driven:]]])
    k = int(np.flatnonzero(states[: driven + constants] == first)[0])
    columns: Floats = seen.H[index, :, :, k : k + 3]
    return columns
