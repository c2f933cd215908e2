"""What gyro, sensors and orbit may do that a scenario does not say, linear about a solution."""

from __future__ import annotations

import dataclasses

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import matrix, shear, skew
from mgeo_attitude.sensors import Sensor

from mgeo_calibration.estimation.linearization import sighting, turns
from mgeo_calibration.estimation.score import Departure
from mgeo_calibration.estimation.smoother import Solution

#: Waves of a drift that is looked for, each of half a period more than the one before.
WAVES = 3
#: A delay that is large [s].
LATE = 10.0


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


def gyro_error(solution: Solution, state: str) -> Departure:
    """Scale factors, a misalignment or non-orthogonality of one, of a gyro that has none."""
    rates, _ = turns(solution.batch, solution.trajectory.states)
    off: Floats = _columns(state, rates)
    return _of_rates(solution, off)


def gyro_follows(solution: Solution, channel: Floats) -> Departure:
    """The gyro's bias is its initial 1-sigma times a channel, shape (N,), about each axis."""
    size = solution.batch.suite.gyro.states()["bias"]
    off = size * channel[:, None, None] * np.eye(3)
    return _of_rates(solution, off[:-1], off[-1])


def delay(solution: Solution, index: int) -> Departure:
    """A sensor, by its number, is late by `LATE`: attitude and vector are of before."""
    rates, _ = turns(solution.batch, solution.trajectory.states)
    before = np.vstack([rates[:1], rates])
    turned = np.einsum("nij,nj->ni", _by(solution, index, 0), before)
    reads = -LATE * (turned + _vector_rate(solution, index))
    return Departure(width=1, reads={index: reads[:, :, None]})


def along_track(solution: Solution) -> Departure:
    """The satellite is where its orbit has it `LATE` before."""
    sensors = range(len(solution.batch.suite.sensors))
    reads = {i: -LATE * _vector_rate(solution, i)[:, :, None] for i in sensors}
    return Departure(width=1, reads=reads)


def vector_error(solution: Solution, index: int, state: str) -> Departure:
    """Scale factors or non-orthogonality of one, of a sensor of vectors that has none."""
    batch, at = solution.batch, solution.trajectory
    first = batch.suite.places(batch.suite.sensors[index]).get("misalignment")
    body = np.einsum("nji,nj->ni", at.attitude, batch.vectors[:, index])
    mounted = np.eye(3) if first is None else matrix(at.states[0, first : first + 3])
    return Departure(width=3, reads={index: mounted @ _columns(state, body)})


def constant(sensor: Sensor) -> str:
    """Name of the state that a sensor's offset is."""
    names = sensor.states()
    return next((each for each in ("bias", "sensitivity") if each in names), "misalignment")


def wander(solution: Solution, index: int) -> Departure:
    """The offset of a sensor goes by ten times its noise along an axis in a wave."""
    times = solution.batch.times
    waves = drifts((times - times[0]) / (times[-1] - times[0]))
    reads = waves[:, None, :, None] * _offset(solution, index)[:, :, None]
    return Departure(width=3 * WAVES, reads={index: reads.reshape(len(times), 3, -1)})


def follows(solution: Solution, index: int, channel: Floats) -> Departure:
    """The offset of a sensor is ten times its noise times a channel, shape (N,), on each axis."""
    return Departure(width=3, reads={index: channel[:, None, None] * _offset(solution, index)})


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


def _columns(state: str, vectors: Floats) -> Floats:
    """What a vector is more by each of three errors of one, shape (n, 3, 3)."""
    if state == "misalignment":
        columns: Floats = -np.moveaxis(skew(vectors.T), -1, 0)
    elif state == "scale_factor":
        columns = vectors[:, :, None] * np.eye(3)
    else:
        columns = np.stack([shear(axis, vectors) for axis in np.eye(3)], axis=-1)
    return columns


def _vector_rate(solution: Solution, index: int) -> Floats:
    """By what readings of a sensor change in a second as what it looks at does, shape (N, 3)."""
    batch, vectors = solution.batch, solution.batch.vectors.copy()
    vectors[:, index] += np.gradient(vectors[:, index], batch.times, axis=0)
    later = sighting(dataclasses.replace(batch, vectors=vectors), index, solution.trajectory)
    rate = np.zeros((len(batch.times), 3))
    k = later.z.shape[1]
    rate[later.samples, :k] = solution.sightings.z[index, later.samples, :k] - later.z
    return rate


def _offset(solution: Solution, index: int) -> Floats:
    """By an offset of ten times the noise of a sensor along each axis, shape (N, 3, 3)."""
    suite = solution.batch.suite
    sensor = suite.sensors[index]
    places = suite.places(sensor)
    if (state := constant(sensor)) in places:
        columns = _by(solution, index, places[state])
    else:  # a misalignment that it has not would turn its readings as the attitude's error back
        columns = -_by(solution, index, 0)
    offset: Floats = 10.0 * float(np.max(sensor.noise())) * columns
    return offset


def _by(solution: Solution, index: int, first: int) -> Floats:
    """What a sensor's readings are by three states from a first one on, shape (N, 3, 3)."""
    seen, parts = solution.sightings, solution.parts
    driven, constants = seen.counts[index]
    places = seen.columns[index]
    states = np.concatenate([parts.driven[places[:driven]], parts.constant[places[driven:]]])
    k = int(np.flatnonzero(states[: driven + constants] == first)[0])
    columns: Floats = seen.H[index, :, :, k : k + 3]
    return columns
