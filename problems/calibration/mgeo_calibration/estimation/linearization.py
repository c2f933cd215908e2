"""Equations of some samples at once, and readings, linear in the errors of a trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.sensors.readings import as_reported

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.innovation import STILL, Estimate, innovation, jacobian
from mgeo_calibration.estimation.kinematics import Steps, steps, turns
from mgeo_calibration.estimation.taylor import Linear
from mgeo_calibration.estimation.trajectory import Partition, Trajectory, spans


@dataclass(frozen=True, eq=False)
class Sighting:
    """z - H e ~ N(0, diag(noise)²) for m readings of a sensor.

    Attributes
    ----------
    samples : array of int, shape (m,)
    z : array, shape (m, k)
        k numbers of each, up to three.
    states : array of int, shape (p,)
        Those that H, shape (m, k, p), is of.
    noise : array, shape (k,)
    """

    samples: Ints
    z: Floats
    states: Ints
    H: Floats
    noise: Floats


@dataclass(frozen=True, eq=False)
class Sightings:
    """The readings of all s sensors.

    One of fewer numbers than three has others that are zero, whatever the errors.

    Attributes
    ----------
    there : array of bool, shape (s, N)
    z : array, shape (s, N, 3)
    H : array, shape (s, N, 3, p)
        By driven errors first, then by those of constants.
    noise : array, shape (s, 3)
    numbers : array of int, shape (s,)
        How many numbers each has.
    counts : array of int, shape (s, 2)
        How many columns of H are of driven errors, and of constants.
    columns : array of int, shape (s, p)
        Their places among the driven and the constant ones.
    """

    there: Bools
    z: Floats
    H: Floats
    noise: Floats
    numbers: Ints
    counts: Ints
    columns: Ints

    @property
    def arrays(self) -> tuple[Floats, Floats, Floats, Ints, Ints]:
        """All but `there` and `numbers`, in this order."""
        return self.z, self.H, self.noise, self.counts, self.columns

    @property
    def leading(self) -> int:
        """How many leading driven states the readings depend on; the attitude's at least."""
        each = zip(self.columns, self.counts, strict=True)
        return max(3, *(int(row[:n].max(initial=-1)) + 1 for row, (n, _) in each))


def sightings(batch: Batch, at: Trajectory, parts: Partition) -> Sightings:
    """The readings of all sensors."""
    each = [sighting(batch, index, at) for index in range(len(batch.suite.sensors))]
    s, N, p = len(each), len(batch.times), max(len(one.states) for one in each)
    found = Sightings(
        there=np.zeros((s, N), dtype=bool),
        z=np.zeros((s, N, 3)),
        H=np.zeros((s, N, 3, p)),
        noise=batch.noise,
        numbers=np.array([len(one.noise) for one in each]),
        counts=np.zeros((s, 2), dtype=np.int64),
        columns=np.zeros((s, p), dtype=np.int64),
    )
    for index, one in enumerate(each):
        chosen = [np.flatnonzero(np.isin(one.states, of)) for of in (parts.driven, parts.constant)]
        order, n = np.concatenate(chosen), len(one.states)
        found.there[index, one.samples] = True
        found.z[index, one.samples, : len(one.noise)] = one.z
        found.H[index, one.samples, : len(one.noise), :n] = one.H[:, :, order]
        found.counts[index] = [len(some) for some in chosen]
        found.columns[index, :n] = np.concatenate(
            [
                np.searchsorted(of, one.states[some])
                for of, some in zip((parts.driven, parts.constant), chosen, strict=True)
            ]
        )
    return found


def sighting(batch: Batch, index: int, at: Trajectory) -> Sighting:
    """The readings of a sensor of the suite, by its number.

    A sensor that is late has seen the body turn at the rate of the step to the sample.

    If a satellite holds an attitude, sensitivities to all but rotations are those at that attitude,
    in the directions that an attitude error moves the readings. The estimated attitude contains the
    pointing error that is in the readings, too: a scale factor would grow to explain that error
    (instrumental variables; W. A. Fuller, Measurement Error Models, Wiley 1987).
    """
    suite, sensor = batch.suite, batch.suite.sensors[index]
    samples = np.flatnonzero(np.isfinite(batch.sensors[index][:, 0, 0]))
    m = len(sensor.noise())
    noise = batch.noise[index, :m]
    if not len(samples):
        return Sighting(samples, np.zeros((0, m)), samples, np.zeros((0, m, 0)), noise)
    z, states, H = _linear(batch, index, at, samples)
    if batch.held is not None:
        held = _linear(batch, index, Trajectory(batch.held.attitude, at.states), samples)
        turning = H[:, :, states < 3]
        change = turning @ np.linalg.pinv(turning, rcond=1e-6) @ (held[2] - H)
        rotations = np.add.outer(suite.rotations, range(3))
        H = np.where(np.isin(states, rotations), H, H + change)
    return Sighting(samples, z, states, H, noise)


def _linear(batch: Batch, index: int, at: Trajectory, samples: Ints) -> tuple[Floats, Ints, Floats]:
    """Return z, states and H of a sensor's readings at samples; see `Sighting`."""
    suite, sensor = batch.suite, batch.suite.sensors[index]
    rate = STILL  # which only a sensor that is late asks for
    if "delay" in suite.places(sensor):
        rates, _ = turns(batch, at.states)
        rate = rates[np.maximum(samples - 1, 0)]
    attitude = np.moveaxis(at.attitude[samples], 0, -1)
    vectors = batch.vectors[samples]
    r = innovation(
        suite,
        index,
        as_reported(batch.sensors[index][samples]),
        vectors[:, index],
        Estimate.of(suite, attitude, at.states[samples].T, np.zeros(0)),
        gradient=[vectors[:, k] for k in range(vectors.shape[1])[suite.gradient_rows(index)]],
        kind=Linear,
        rate=rate,
        influences=batch.follows(sensor, samples),
    )
    states, H = jacobian(r)
    H = np.moveaxis(np.broadcast_to(H, (*H.shape[:2], len(samples))), -1, 0)
    return r.value.T, states, H


def misfits(batch: Batch, index: int, at: Trajectory) -> Floats:
    """z of a sensor at all samples, shape (N, k), NaN where it has not reported; see `Sighting`."""
    found = np.full((len(batch.times), len(batch.suite.sensors[index].noise())), np.nan)
    for low, high, first in spans(len(found)):
        seen = sighting(batch.part(low, high), index, at.part(low, high))
        new = seen.samples >= first
        found[low + seen.samples[new]] = seen.z[new]
    return found


@dataclass(frozen=True, eq=False)
class Equations:
    """Those of samples low to high - 1 of a batch.

    Attributes
    ----------
    batch : Batch
        Of these samples.
    trajectory : Trajectory
        At these samples.
    """

    low: int
    high: int
    batch: Batch
    trajectory: Trajectory
    parts: Partition
    steps: Steps
    sightings: Sightings


def equations(
    batch: Batch, at: Trajectory, parts: Partition, growth: Floats, low: int, high: int
) -> Equations:
    """Of samples low to high - 1, with the growth of constants at all samples, shape (N, c)."""
    own, here = batch.part(low, high), at.part(low, high)
    move = steps(own, here, parts, growth[low:high])
    return Equations(low, high, own, here, parts, move, sightings(own, here, parts))
