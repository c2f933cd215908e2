"""Regressors of score tests: errors that a scenario does not model, linear about a solution.

All regressors follow from the smoothed trajectory, whose errors are independent of the residuals.
The gyro's rates are not: their noise is in the residuals, too, and gives a healthy gyro at rest a
scale factor of 100 % (W. A. Fuller, Measurement Error Models, Wiley 1987).
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
from mgeo_calibration.estimation.linearization import Equations, sighting
from mgeo_calibration.estimation.score import Combined, Departure
from mgeo_calibration.estimation.smoother import Solution

#: Parts of the flight, in each of which an offset may change: slow courses are sums of these.
PARTS = 8
#: Number of half waves in a slow drift.
WAVES = 3
#: Cycles per flight of gyro errors that stand for its noise: more than a drift has.
CYCLES = (3.0, 6.0, 12.0, 24.0)
#: Widths of the filter of the rates, in steps, its order, and the variance of differences of the
#: next order of white noise. A filter is too wide if it changes rates by more than this many times
#: their noise.
_WIDTHS, _ORDER, _GAIN, _BLUR = (33, 17, 9, 5), 2, 20.0, 1.5
#: Large sizes: a combination of coefficients that is less certain is not tested.
LARGE_DELAY_S = 10.0
LARGE_AXES_ERROR = 0.1
LARGE_OFFSET = 10.0  # in 1-sigmas of a sensor's noise
#: Course of an offset over the fraction of the flight, shapes (n,) to (n, k).
Course = Callable[[Floats], Floats]
#: Change of a sensor's readings per second as the observed vector changes, shape (n, 3).
VectorRates = Callable[[Equations, int], Floats]


def smoothed_rates(solution: Solution) -> Floats:
    """Return the mean body rate in each step by the smoothed attitude, shape (N - 1, 3) [rad/s].

    If noise is declared too large, the smoothed attitude follows the noise of single readings. The
    rates are filtered over as many steps as the motion allows (A. Savitzky, M. J. E. Golay,
    Analytical Chemistry 36 (1964) 1627-1639).
    """
    rates = _attitude_rates(solution)
    noise = np.median(np.abs(np.diff(rates, _ORDER + 1, axis=0)), axis=0) / math.sqrt(_GAIN)
    for width in _WIDTHS:
        if width < len(rates):
            found = savgol_filter(rates, width, _ORDER, axis=0)
            if (np.median(np.abs(rates - found), axis=0) <= _BLUR * noise).all():
                return np.asarray(found, dtype=np.float64)
    return rates


def gyro_walk(solution: Solution) -> float:
    """Return the angle random walk of the gyro about the smoothed attitude [rad/sqrt(s)]."""
    batch = solution.batch
    rates, _ = turns(batch, solution.estimate.states)
    off = (rates - _attitude_rates(solution))[~batch.breaks]
    return float(np.sqrt(np.mean(off**2 * batch.durations[~batch.breaks, None])))


def _attitude_rates(solution: Solution) -> Floats:
    attitude, batch = solution.estimate.attitude, solution.batch
    turn = attitude[:-1].swapaxes(1, 2) @ attitude[1:]
    rates: Floats = Rotation.from_matrix(turn).as_rotvec() / batch.durations[:, None]
    rates[batch.breaks] = 0.0
    return rates


def bias_decay(solution: Solution) -> Departure:
    """Bias whose inverse correlation time is larger by one over the duration of the flight."""
    times = solution.batch.times
    at, dt, bias = times - times[0], np.diff(times), solution.estimate.states[:-1, 3:6]
    left = np.exp(-solution.batch.suite.gyro.bias_decay * at)[:, None]
    more = np.cumsum(dt[:, None] * bias / left[:-1], axis=0) / at[-1]
    off = -left * np.vstack([np.zeros(3), more])
    return _gyro_offset(lambda own: off[own.low : own.high - 1, :, None], 1, off[-1:].T)


def bias_drift(solution: Solution) -> Departure:
    """Bias that changes by its initial 1-sigma in each part of the flight, about each axis."""
    share, size = _fractions(solution), solution.batch.suite.gyro.states()["bias"]

    def moves(own: Equations) -> Floats:
        rises = size * risen(share[own.low : own.high - 1])
        found: Floats = rises[:, None, :, None] * _turned_by(own)[:, :, None]
        return found.reshape(len(rises), 3, -1)

    return Departure(width=3 * PARTS, moves=moves, bias=np.tile(size * np.eye(3), PARTS))


def gyro_noise(solution: Solution) -> Departure:
    """Sines and cosines of `CYCLES` about each axis, as large as the gyro's noise of a step."""
    batch = solution.batch
    density = np.sqrt(np.array(batch.suite.gyro.diffusion()["theta"]))
    size, share = density / np.sqrt(np.median(batch.durations)), _fractions(solution)

    def off(own: Equations) -> Floats:
        phase = 2.0 * np.pi * share[own.low : own.high - 1, None] * np.array(CYCLES)
        waves = np.concatenate([np.sin(phase), np.cos(phase)], axis=1)
        found: Floats = waves[:, None, :, None] * np.diag(size)[:, None]
        return found.reshape(len(waves), 3, -1)

    return _gyro_offset(off, 6 * len(CYCLES))


def gyro_error(rates: Floats, state: str) -> Departure:
    """Scale factors, misalignment, non-orthogonality or scale asymmetry of a gyro.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        See `smoothed_rates`.
    """
    return _gyro_offset(lambda own: _axes_error(state, rates[own.low : own.high - 1]), 3)


def gyro_early(rates: Floats, durations: Floats) -> Departure:
    """Gyro that reports the rates of `LARGE_DELAY_S` later.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        See `smoothed_rates`.
    durations : array, shape (N - 1,)
        Durations of the steps [s].
    """

    def changes(own: Equations) -> Floats:
        steps = np.arange(own.low, own.high - 1)
        change = rates[steps] - rates[np.maximum(steps - 1, 0)]
        found: Floats = LARGE_DELAY_S * change / durations[steps, None]
        return found[:, :, None]

    return _gyro_offset(changes, 1)


def gyro_follows(solution: Solution, channel: Floats) -> Departure:
    """Bias of its initial 1-sigma times a channel, shape (N,), about each axis."""
    size = solution.batch.suite.gyro.states()["bias"]
    return _gyro_offset(
        lambda own: size * channel[own.low : own.high - 1, None, None] * np.eye(3),
        3,
        size * channel[-1] * np.eye(3),
    )


def vector_rates(solution: Solution) -> VectorRates:
    """Return a function that caches the `VectorRates` of each sensor, by its index."""
    sensors = len(solution.batch.suite.sensors)
    return lru_cache(maxsize=sensors)(partial(_vector_rate, solution))


def delay(index: int, rates: Floats, changes: VectorRates) -> Departure:
    """Sensor whose readings are `LARGE_DELAY_S` old: attitude and vector are earlier ones.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        See `smoothed_rates`.
    changes : function
        See `vector_rates`.
    """

    def reads(own: Equations) -> Floats:
        before = rates[np.maximum(np.arange(own.low, own.high) - 1, 0)]
        turned = np.einsum("nij,nj->ni", _sensitivity(own, index, 0), before)
        found: Floats = -LARGE_DELAY_S * (turned + changes(own, index))
        return found[:, :, None]

    return Departure(width=1, reads={index: reads})


def along_track(sensors: int, changes: VectorRates) -> Departure:
    """Satellite that is where its orbit has it `LARGE_DELAY_S` earlier."""

    def reads(index: int) -> Callable[[Equations], Floats]:
        return lambda own: -LARGE_DELAY_S * changes(own, index)[:, :, None]

    return Departure(width=1, reads={index: reads(index) for index in range(sensors)})


def vector_error(index: int, state: str) -> Departure:
    """Scale factors or non-orthogonality of a vector sensor.

    Of a satellite that holds an attitude, vectors are those of the held attitude: the pointing
    error is part of the innovations, and the smoothed attitude contains the error.
    """

    def reads(own: Equations) -> Floats:
        batch, at = own.batch, own.trajectory
        first = batch.suite.places(batch.suite.sensors[index]).get("misalignment")
        attitude = at.attitude if batch.held is None else batch.held.attitude
        body = np.einsum("nji,nj->ni", attitude, batch.vectors[:, index])
        mounted = np.eye(3) if first is None else matrix(at.states[0, first : first + 3])
        columns: Floats = mounted @ _axes_error(state, body)
        return columns

    return Departure(width=3, reads={index: reads})


def wander(solution: Solution, index: int) -> Departure:
    """Offset of a sensor that changes by `LARGE_OFFSET` in each part of the flight."""
    share = _fractions(solution)

    def reads(own: Equations) -> Floats:
        rises = risen(share[own.low : own.high])
        found = rises[:, None, :, None] * _offset(own, index)[:, :, None]
        return found.reshape(len(rises), 3, -1)

    return Departure(width=3 * PARTS, reads={index: reads})


def follows(index: int, channel: Floats) -> Departure:
    """Offset of a sensor of `LARGE_OFFSET` times a channel, shape (N,), on each axis."""

    def reads(own: Equations) -> Floats:
        return channel[own.low : own.high, None, None] * _offset(own, index)

    return Departure(width=3, reads={index: reads})


def turns_with(index: int, channel: Floats) -> Departure:
    """Misalignment of a sensor of `LARGE_AXES_ERROR` [rad] times a channel, shape (N,)."""

    def reads(own: Equations) -> Floats:
        by_attitude = -_sensitivity(own, index, 0)
        return LARGE_AXES_ERROR * channel[own.low : own.high, None, None] * by_attitude

    return Departure(width=3, reads={index: reads})


def risen(share: Floats) -> Floats:
    """Return the rise from zero to one in each part, at fractions of the flight, (n, PARTS)."""
    rises: Floats = np.clip(PARTS * share[:, None] - np.arange(PARTS), 0.0, 1.0)
    return rises


def step(number: int) -> Course:
    """Return the course that rises within one of the parts."""
    return lambda share: risen(share)[:, [number]]


def ramp(share: Floats) -> Floats:
    """Return the course that is proportional to time, shape (n, 1)."""
    return share[:, None]


def waves(share: Floats) -> Floats:
    """Return the courses of one to `WAVES` half waves from zero, shape (n, WAVES)."""
    half_periods = np.arange(1, WAVES + 1)
    found: Floats = 0.5 - 0.5 * np.cos(np.pi * share[:, None] * half_periods)
    return found


def along(rises: Departure, courses: Sequence[Course]) -> tuple[Combined, ...]:
    """Return an offset that follows each course, piecewise linear over the parts."""
    ends = np.linspace(0.0, 1.0, PARTS + 1)
    return tuple(
        Combined(rises, np.asarray(np.kron(np.diff(of(ends), axis=0), np.eye(3)), dtype=np.float64))
        for of in courses
    )


def _fractions(solution: Solution) -> Floats:
    times = solution.batch.times
    fractions: Floats = (times - times[0]) / (times[-1] - times[0])
    return fractions


def _gyro_offset(
    off: Callable[[Equations], Floats], width: int, last: Floats | None = None
) -> Departure:
    """Return the departure of a gyro that reports more in each step, (n - 1, 3, k) [rad/s].

    Parameters
    ----------
    last : array, shape (3, k), optional
        Excess at the last sample, if it is of the bias.
    """

    def moves(own: Equations) -> Floats:
        moved: Floats = np.einsum("nij,njk->nik", _turned_by(own), off(own))
        return moved

    return Departure(width=width, moves=moves, bias=last)


def _turned_by(own: Equations) -> Floats:
    """Return the attitude error per rate of the gyro in each step, shape (n - 1, 3, 3)."""
    parts, move = own.parts, own.steps
    if (parts.driven == 3).any():
        first = int(np.flatnonzero(parts.driven == 3)[0])
        return move.F[:, :3, first : first + 3]
    first = int(np.flatnonzero(parts.constant == 3)[0])
    turned: Floats = move.G[:, :, first : first + 3] / move.growth[:-1, None, first : first + 3]
    return turned


def _axes_error(state: str, vectors: Floats) -> Floats:
    """Return the change of vectors by three errors of `LARGE_AXES_ERROR`, shape (n, 3, 3)."""
    if state == "misalignment":
        columns: Floats = -np.moveaxis(skew(vectors.T), -1, 0)
    elif state == "nonorthogonality":
        columns = np.stack([shear(axis, vectors) for axis in np.eye(3)], axis=-1)
    else:
        by_axis = np.abs(vectors) if state == "scale_asymmetry" else vectors
        columns = by_axis[:, :, None] * np.eye(3)
    return LARGE_AXES_ERROR * columns


def _vector_rate(solution: Solution, own: Equations, index: int) -> Floats:
    whole, vectors = solution.batch, own.batch.vectors.copy()
    low, high = max(0, own.low - 1), min(len(whole.times), own.high + 1)
    rate = np.gradient(whole.vectors[low:high, index], whole.times[low:high], axis=0)
    vectors[:, index] += rate[own.low - low : own.high - low]
    later = sighting(dataclasses.replace(own.batch, vectors=vectors), index, own.trajectory)
    change = np.zeros((len(vectors), 3))
    k = later.z.shape[1]
    change[later.samples, :k] = own.sightings.z[index, later.samples, :k] - later.z
    return change


def _offset(own: Equations, index: int) -> Floats:
    """Return the change of readings by `LARGE_OFFSET` along each axis, shape (n, 3, 3)."""
    suite = own.batch.suite
    sensor = suite.sensors[index]
    places = suite.places(sensor)
    if (state := sensor.offset) in places:
        columns = _sensitivity(own, index, places[state])
    else:  # a misalignment, which turns readings as an attitude error turns them back
        columns = -_sensitivity(own, index, 0)
    offset: Floats = LARGE_OFFSET * float(np.max(sensor.noise())) * columns
    return offset


def _sensitivity(own: Equations, index: int, first: int) -> Floats:
    """Return the change of a sensor's readings by three states from the first, (n, 3, 3)."""
    seen, parts = own.sightings, own.parts
    driven, constants = seen.counts[index]
    places = seen.columns[index]
    states = np.concatenate([parts.driven[places[:driven]], parts.constant[places[driven:]]])
    k = int(np.flatnonzero(states[: driven + constants] == first)[0])
    columns: Floats = seen.H[index, :, :, k : k + 3]
    return columns
