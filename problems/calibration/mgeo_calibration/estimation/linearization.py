"""Linearized process and measurement equations about a trajectory.

The smoother and the score tests solve these equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.sensors.readings import as_reported

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.innovation import STILL, Estimate, innovation, jacobian
from mgeo_calibration.estimation.kinematics import Steps, steps, turns
from mgeo_calibration.estimation.taylor import Constant, Linear, Taylor
from mgeo_calibration.estimation.trajectory import Partition, Trajectory, spans


@dataclass(frozen=True, eq=False)
class Sighting:
    """Linearized readings of one sensor: z - H e ~ N(0, diag(noise)²).

    Attributes
    ----------
    samples : array of int, shape (m,)
        Sample index of each reading.
    z : array, shape (m, k)
        Innovations of the k components, at most three.
    states : array of int, shape (p,)
        States of the columns of H.
    H : array, shape (m, k, p)
        Jacobian with respect to the errors of these states.
    noise : array, shape (k,)
        1-sigma of each component.
    """

    samples: Ints
    z: Floats
    states: Ints
    H: Floats
    noise: Floats


@dataclass(frozen=True, eq=False)
class Sightings:
    """Linearized readings of all s sensors.

    Readings with fewer than three components are padded with components that are always zero.

    Attributes
    ----------
    there : array of bool, shape (s, N)
        True where a sensor has a reading.
    z : array, shape (s, N, 3)
        Innovations.
    H : array, shape (s, N, 3, p)
        Jacobians with respect to the stochastic states, then to the constant states.
    noise : array, shape (s, 3)
        1-sigma of each component.
    numbers : array of int, shape (s,)
        Number of components of each sensor.
    counts : array of int, shape (s, 2)
        Number of columns of H for the stochastic states and for the constant states.
    columns : array of int, shape (s, p)
        Index of each column of H among the stochastic or the constant states.
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
        """z, H, noise, counts and columns, as the compiled loops expect them."""
        return self.z, self.H, self.noise, self.counts, self.columns

    @property
    def leading(self) -> int:
        """Number of leading stochastic states that the readings depend on, at least three."""
        each = zip(self.columns, self.counts, strict=True)
        return max(3, *(int(row[:n].max(initial=-1)) + 1 for row, (n, _) in each))


def sightings(batch: Batch, at: Trajectory, parts: Partition) -> Sightings:
    """Linearize the readings of all sensors."""
    each = [sighting(batch, index, at) for index in range(len(batch.suite.sensors))]
    s, N, p = len(each), len(batch.times), max(len(one.states) for one in each)
    result = Sightings(
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
        result.there[index, one.samples] = True
        result.z[index, one.samples, : len(one.noise)] = one.z
        result.H[index, one.samples, : len(one.noise), :n] = one.H[:, :, order]
        result.counts[index] = [len(some) for some in chosen]
        result.columns[index, :n] = np.concatenate(
            [
                np.searchsorted(of, one.states[some])
                for of, some in zip((parts.driven, parts.constant), chosen, strict=True)
            ]
        )
    return result


def sighting(batch: Batch, index: int, at: Trajectory) -> Sighting:
    """Linearize the readings of one sensor.

    The body rate for a measurement latency is the rate of the step that ends at the sample.

    If a satellite holds an attitude, the sensitivities to all states but rotations are taken at the
    held attitude, in the directions in which an attitude error moves the readings. The estimated
    attitude contains the pointing error that is in the readings, and a scale factor would grow to
    explain this error (instrumental variables; W. A. Fuller, Measurement Error Models, Wiley 1987).

    Parameters
    ----------
    index : int
        Index of the sensor in the suite.
    at : Trajectory
        Trajectory to linearize about.
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
    """Return z, states and H of the readings of one sensor at some samples; see `Sighting`."""
    r = _innovation(batch, index, at, samples, Linear)
    states, H = jacobian(r)
    H = np.moveaxis(np.broadcast_to(H, (*H.shape[:2], len(samples))), -1, 0)
    return r.value.T, states, H


def _innovation(
    batch: Batch, index: int, at: Trajectory, samples: Ints, kind: type[Taylor]
) -> Taylor:
    suite, sensor = batch.suite, batch.suite.sensors[index]
    rate = STILL  # Only a sensor with a measurement latency depends on the body rate.
    if "delay" in suite.places(sensor):
        rates, _ = turns(batch, at.states)
        rate = rates[np.maximum(samples - 1, 0)]
    attitude = np.moveaxis(at.attitude[samples], 0, -1)
    vectors = batch.vectors[samples]
    return innovation(
        suite,
        index,
        as_reported(batch.sensors[index][samples]),
        vectors[:, index],
        Estimate.of(suite, attitude, at.states[samples].T, np.zeros(0)),
        gradient=[vectors[:, k] for k in range(vectors.shape[1])[suite.gradient_rows(index)]],
        kind=kind,
        rate=rate,
        influences=batch.follows(sensor, samples),
    )


def misfit(batch: Batch, index: int, at: Trajectory) -> tuple[Ints, Floats]:
    """Return the samples with a reading of a sensor and their innovations; see `Sighting`."""
    samples = np.flatnonzero(np.isfinite(batch.sensors[index][:, 0, 0]))
    return samples, _innovation(batch, index, at, samples, Constant).value.T


def misfits(batch: Batch, index: int, at: Trajectory) -> Floats:
    """Return the innovations of a sensor at all samples, shape (N, k).

    Samples without a reading are NaN.
    """
    result = np.full((len(batch.times), len(batch.suite.sensors[index].noise())), np.nan)
    for low, high, first in spans(len(result)):
        samples, z = misfit(batch.part(low, high), index, at.part(low, high))
        new = samples >= first
        result[low + samples[new]] = z[new]
    return result


@dataclass(frozen=True, eq=False)
class Equations:
    """Linearized equations of the samples low to high - 1 of a batch.

    Attributes
    ----------
    low, high : int
        First sample, and one past the last sample.
    batch : Batch
        Part of the batch at these samples.
    trajectory : Trajectory
        Part of the trajectory at these samples.
    parts : Partition
    steps : Steps
        Process equations.
    sightings : Sightings
        Measurement equations.
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
    """Linearize the equations of the samples low to high - 1.

    Parameters
    ----------
    at : Trajectory
        Trajectory at all samples.
    growth : array, shape (N, c)
        Factors of the constant states at all samples; see `kinematics.growth`.
    """
    own, here = batch.part(low, high), at.part(low, high)
    move = steps(own, here, parts, growth[low:high])
    return Equations(low, high, own, here, parts, move, sightings(own, here, parts))
