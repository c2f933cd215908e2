"""What gyro, sensors and orbit may do that a scenario does not say, linear about a solution."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import lru_cache, partial

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import matrix, shear, skew

from mgeo_calibration.estimation.linearization import Equations, sighting
from mgeo_calibration.estimation.score import Combined, Departure
from mgeo_calibration.estimation.smoother import Solution

#: Parts of the time, in one of which an offset may rise: of these all that is slow is made.
PARTS = 8
#: Waves of a drift, each of half a period more than the one before.
WAVES = 3
#: Of an offset over the shares of the time, shapes (n,) to (n, k).
Profile = Callable[[Floats], Floats]
#: See `vector_rates`.
VectorRates = Callable[[Equations, int], Floats]
#: A delay that is large [s].
LATE = 10.0


def bias_decay(solution: Solution) -> Departure:
    """The bias's inverse correlation time is larger by one over the time of the telemetry."""
    times = solution.batch.times
    at, dt, bias = times - times[0], np.diff(times), solution.trajectory.states[:-1, 3:6]
    left = np.exp(-solution.batch.suite.gyro.bias_decay * at)[:, None]
    more = np.cumsum(dt[:, None] * bias / left[:-1], axis=0) / at[-1]
    off = -left * np.vstack([np.zeros(3), more])
    return _of_rates(lambda own: off[own.low : own.high - 1, :, None], 1, off[-1:].T)


def bias_drift(solution: Solution) -> Departure:
    """The bias rises by its initial 1-sigma about an axis, on top of its random walk."""
    share, size = _shares(solution), solution.batch.suite.gyro.states()["bias"]

    def moves(own: Equations) -> Floats:
        rises = size * risen(share[own.low : own.high - 1])
        found: Floats = rises[:, None, :, None] * _turned_by(own)[:, :, None]
        return found.reshape(len(rises), 3, -1)

    return Departure(width=3 * PARTS, moves=moves, bias=np.tile(size * np.eye(3), PARTS))


def gyro_error(rates: Floats, state: str) -> Departure:
    """Scale factors, a misalignment or non-orthogonality of one, of a gyro that has none.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        Of the body, see `independent_rates`.
    """
    return _of_rates(lambda own: _columns(state, rates[own.low : own.high - 1]), 3)


def gyro_early(rates: Floats, durations: Floats) -> Departure:
    """A gyro that reports the rates of `LATE` after.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        As of `gyro_error`.
    durations : array, shape (N - 1,)
        Of the steps [s].
    """

    def changes(own: Equations) -> Floats:
        steps = np.arange(own.low, own.high - 1)
        change = rates[steps] - rates[np.maximum(steps - 1, 0)]
        found: Floats = LATE * change / durations[steps, None]
        return found[:, :, None]

    return _of_rates(changes, 1)


def gyro_follows(solution: Solution, channel: Floats) -> Departure:
    """The gyro's bias is its initial 1-sigma times a channel, shape (N,), about each axis."""
    size = solution.batch.suite.gyro.states()["bias"]
    return _of_rates(
        lambda own: size * channel[own.low : own.high - 1, None, None] * np.eye(3),
        3,
        size * channel[-1] * np.eye(3),
    )


def vector_rates(solution: Solution) -> VectorRates:
    """By what readings change in a second as what they look at does; what is asked again is kept.

    Of a sensor, by its number, at the samples of equations, shape (n, 3).
    """
    sensors = len(solution.batch.suite.sensors)
    return lru_cache(maxsize=sensors)(partial(_vector_rate, solution))


def delay(index: int, rates: Floats, changes: VectorRates) -> Departure:
    """A sensor, by its number, is late by `LATE`: attitude and vector are of before.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        As of `gyro_error`.
    changes : function
        See `vector_rates`.
    """

    def reads(own: Equations) -> Floats:
        before = rates[np.maximum(np.arange(own.low, own.high) - 1, 0)]
        turned = np.einsum("nij,nj->ni", _by(own, index, 0), before)
        found: Floats = -LATE * (turned + changes(own, index))
        return found[:, :, None]

    return Departure(width=1, reads={index: reads})


def along_track(sensors: int, changes: VectorRates) -> Departure:
    """The satellite is where its orbit has it `LATE` before; of so many sensors."""

    def reads(index: int) -> Callable[[Equations], Floats]:
        return lambda own: -LATE * changes(own, index)[:, :, None]

    return Departure(width=1, reads={index: reads(index) for index in range(sensors)})


def vector_error(index: int, state: str) -> Departure:
    """Scale factors or non-orthogonality of one, of a sensor of vectors that has none."""

    def reads(own: Equations) -> Floats:
        batch, at = own.batch, own.trajectory
        first = batch.suite.places(batch.suite.sensors[index]).get("misalignment")
        body = np.einsum("nji,nj->ni", at.attitude, batch.vectors[:, index])
        mounted = np.eye(3) if first is None else matrix(at.states[0, first : first + 3])
        columns: Floats = mounted @ _columns(state, body)
        return columns

    return Departure(width=3, reads={index: reads})


def wander(solution: Solution, index: int) -> Departure:
    """The offset of a sensor rises by ten times its noise along an axis."""
    share = _shares(solution)

    def reads(own: Equations) -> Floats:
        rises = risen(share[own.low : own.high])
        found = rises[:, None, :, None] * _offset(own, index)[:, :, None]
        return found.reshape(len(rises), 3, -1)

    return Departure(width=3 * PARTS, reads={index: reads})


def follows(index: int, channel: Floats) -> Departure:
    """The offset of a sensor is ten times its noise times a channel, shape (N,), on each axis."""

    def reads(own: Equations) -> Floats:
        return channel[own.low : own.high, None, None] * _offset(own, index)

    return Departure(width=3, reads={index: reads})


def risen(share: Floats) -> Floats:
    """From zero to one in each of the parts, at these shares of the time, shape (n, PARTS)."""
    rises: Floats = np.clip(PARTS * share[:, None] - np.arange(PARTS), 0.0, 1.0)
    return rises


def step(number: int) -> Profile:
    """In one of the parts, whenever."""
    return lambda share: risen(share)[:, [number]]


def ramp(share: Floats) -> Floats:
    """As the time, shape (n, 1)."""
    return share[:, None]


def waves(share: Floats) -> Floats:
    """From zero, and there and back, shape (n, WAVES)."""
    half_periods = np.arange(1, WAVES + 1)
    found: Floats = 0.5 - 0.5 * np.cos(np.pi * share[:, None] * half_periods)
    return found


def along(rises: Departure, profiles: Sequence[Profile]) -> tuple[Combined, ...]:
    """An offset that follows each profile, by lines over the parts, about each axis."""
    ends = np.linspace(0.0, 1.0, PARTS + 1)
    return tuple(
        Combined(rises, np.asarray(np.kron(np.diff(of(ends), axis=0), np.eye(3)), dtype=np.float64))
        for of in profiles
    )


def _shares(solution: Solution) -> Floats:
    """Of the time that the telemetry takes, at its samples."""
    times = solution.batch.times
    shares: Floats = (times - times[0]) / (times[-1] - times[0])
    return shares


def _of_rates(
    off: Callable[[Equations], Floats], width: int, last: Floats | None = None
) -> Departure:
    """Of a gyro that reports so much more in each step, shape (n - 1, 3, k) [rad/s].

    Parameters
    ----------
    last : array, shape (3, k), optional
        That at the last sample, if it is of the bias.
    """

    def moves(own: Equations) -> Floats:
        turned, found = _turned_by(own), off(own)
        total: Floats = turned[:, :, [0]] * found[:, [0]]
        for j in (1, 2):
            total += turned[:, :, [j]] * found[:, [j]]
        return total

    return Departure(width=width, moves=moves, bias=last)


def _turned_by(own: Equations) -> Floats:
    """What the attitude's error is more in each step by a rate of the gyro, shape (n - 1, 3, 3)."""
    parts, move = own.parts, own.steps
    if (parts.driven == 3).any():
        first = int(np.flatnonzero(parts.driven == 3)[0])
        return move.F[:, :3, first : first + 3]
    first = int(np.flatnonzero(parts.constant == 3)[0])
    turned: Floats = move.G[:, :, first : first + 3] / move.growth[:-1, None, first : first + 3]
    return turned


def _columns(state: str, vectors: Floats) -> Floats:
    """What a vector is more by each of three errors of one, shape (n, 3, 3)."""
    if state == "misalignment":
        columns: Floats = -np.moveaxis(skew(vectors.T), -1, 0)
    elif state == "scale_factor":
        columns = vectors[:, :, None] * np.eye(3)
    else:
        columns = np.stack([shear(axis, vectors) for axis in np.eye(3)], axis=-1)
    return columns


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
    """By an offset of ten times the noise of a sensor along each axis, shape (n, 3, 3)."""
    suite = own.batch.suite
    sensor = suite.sensors[index]
    places = suite.places(sensor)
    if (state := sensor.offset) in places:
        columns = _by(own, index, places[state])
    else:  # a misalignment that it has not would turn its readings as the attitude's error back
        columns = -_by(own, index, 0)
    offset: Floats = 10.0 * float(np.max(sensor.noise())) * columns
    return offset


def _by(own: Equations, index: int, first: int) -> Floats:
    """What a sensor's readings are by three states from a first one on, shape (n, 3, 3)."""
    seen, parts = own.sightings, own.parts
    driven, constants = seen.counts[index]
    places = seen.columns[index]
    states = np.concatenate([parts.driven[places[:driven]], parts.constant[places[driven:]]])
    k = int(np.flatnonzero(states[: driven + constants] == first)[0])
    columns: Floats = seen.H[index, :, :, k : k + 3]
    return columns
