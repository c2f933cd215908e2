"""Equations of all samples at once, linear in the errors of a trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.geometry.rotation import cross, exponential, matrix, vector
from mgeo_attitude.sensors.influences import influenced
from mgeo_attitude.sensors.readings import as_reported
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import UNKNOWN
from mgeo_calibration.estimation.estimate import Estimate
from mgeo_calibration.estimation.innovation import innovation, jacobian
from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.taylor import Linear

#: Samples whose derivatives are formed at once: so many columns of all would need much memory.
_SPAN = 20000


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Estimates at N samples.

    Attributes
    ----------
    attitude : array, shape (N, 3, 3)
        Body to GCRS.
    states : array, shape (N, n_states)
        Of gyro and sensors, rotations as vectors; zero for the attitude. Those that nothing drives
        follow from those at the first sample.
    """

    attitude: Floats
    states: Floats


@dataclass(frozen=True, eq=False)
class Partition:
    """Which states are estimated at every sample, and which once.

    Attributes
    ----------
    driven : array of int, shape (d,)
        Those that noise drives: the attitude, mostly the gyro's bias, and processes of sensors.
    constant : array of int, shape (c,)
        All others; what is estimated is their value at the first sample.
    """

    driven: Ints
    constant: Ints

    @classmethod
    def of(cls, suite: Suite) -> Partition:
        """By the diffusion of the dynamic states; that of the attitude is not zero."""
        driven = np.flatnonzero(suite.diffusion() > 0.0)
        return cls(driven, np.setdiff1d(np.arange(suite.n_states), driven))


@dataclass(frozen=True, eq=False)
class Steps:
    """defect + F e_k + G e_c - e_{k+1} ~ N(0, Q) for driven errors e_k and constant errors e_c.

    Attributes
    ----------
    F, Q : arrays, shape (n, d, d)
    G : array, shape (n, d, c)
    defect : array, shape (n, d)
    growth : array, shape (n + 1, c)
        Of constants since the first sample: a bias that nothing drives decays.
    """

    F: Floats
    G: Floats
    Q: Floats
    defect: Floats
    growth: Floats

    @property
    def arrays(self) -> tuple[Floats, Floats, Floats, Floats]:
        """All but `growth`, in this order."""
        return self.F, self.G, self.Q, self.defect


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


def turns(batch: Batch, states: Floats) -> tuple[Floats, Floats]:
    """Corrected body rate, shape (n, 3), and what it turns GCRS-to-body matrices by in each step.

    A rate that is a line turns by a rotation vector that is its integral and a twelfth of the
    step's square times rate × change (J. E. Bortz, A New Mathematical Formulation for Strapdown
    Inertial Navigation, IEEE Transactions on Aerospace and Electronic Systems AES-7 (1971) 61-66).

    Parameters
    ----------
    states : array, shape (n + 1, n_states)
    """
    gyro, suite, dt = batch.suite.gyro, batch.suite, batch.durations[:, None]
    x = {name: states[:-1, i : i + 3] for name, i in suite.places(gyro).items()}
    half = 0.5 * gyro.bias_decay * dt
    # a decaying bias's mean over the step, (1 - exp(-2 h)) / (2 h)
    x["bias"] = x["bias"] * np.exp(-half) * _sinhc(half)
    influenced(gyro.influences, x, batch.follows(gyro, slice(1, None)))
    errors = SimpleNamespace(**x)
    rates = gyro.corrected(errors, batch.gyro)
    later = gyro.corrected(errors, batch.gyro + batch.change)
    turn = dt * rates + dt**2 / 12.0 * cross(rates, later)
    return rates, np.moveaxis(exponential(-turn.T), -1, 0)


def steps(batch: Batch, at: Trajectory, parts: Partition) -> Steps:
    """The kinematics of a trajectory."""
    suite, n = batch.suite, len(batch.gyro)
    rates, turn = turns(batch, at.states)
    follows = batch.follows(suite.gyro, slice(1, None))
    F, Q = discretized(suite, rates, batch.durations, follows)
    constant = parts.constant[parts.constant < suite.n_dynamic]
    growth = np.ones((n + 1, len(parts.constant)))
    growth[1:, : len(constant)] = np.cumprod(np.einsum("nii->ni", F)[:, constant], axis=0)
    G = np.zeros((n, len(parts.driven), len(parts.constant)))
    G[:, :, : len(constant)] = (
        F[:, parts.driven[:, None], constant] * growth[:-1, None, : len(constant)]
    )
    bias = parts.driven[3:]
    defect = np.zeros((n, len(parts.driven)))
    reached = at.attitude[1:].swapaxes(1, 2) @ at.attitude[:-1] @ turn.swapaxes(1, 2)
    defect[:, :3] = vector(np.moveaxis(reached, 0, -1)).T
    defect[:, 3:] = np.einsum("nii->ni", F)[:, bias] * at.states[:-1, bias] - at.states[1:, bias]
    if len(parts.driven) < suite.n_dynamic:
        # contiguous: numba would compile the smoother once more for another layout
        F, Q = (
            np.ascontiguousarray(each[:, parts.driven[:, None], parts.driven]) for each in (F, Q)
        )
    Q[:, range(3), range(3)] += batch.added
    if batch.breaks.any():
        F[batch.breaks, :3], G[batch.breaks, :3], defect[batch.breaks, :3] = 0.0, 0.0, 0.0
        Q[batch.breaks, :3], Q[batch.breaks, :, :3] = 0.0, 0.0
        Q[np.flatnonzero(batch.breaks)[:, None], range(3), range(3)] = UNKNOWN**2
    return Steps(F, G, Q, defect, growth)


def sightings(batch: Batch, at: Trajectory, parts: Partition) -> Sightings:
    """The readings of all sensors."""
    rates = turns(batch, at.states)[0]
    each = [sighting(batch, index, at, rates) for index in range(len(batch.suite.sensors))]
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


def sighting(batch: Batch, index: int, at: Trajectory, rates: Floats | None = None) -> Sighting:
    """The readings of a sensor of the suite, by its number; `rates` saves finding those of `turns`.

    A sensor that is late has seen the body turn at the rate of the step to the sample.
    """
    suite = batch.suite
    samples = np.flatnonzero(np.isfinite(batch.sensors[index][:, 0, 0]))
    m = len(suite.sensors[index].noise())
    noise = batch.noise[index, :m]
    if not len(samples):
        return Sighting(samples, np.zeros((0, m)), samples, np.zeros((0, m, 0)), noise)
    rate = (turns(batch, at.states)[0] if rates is None else rates)[np.maximum(samples - 1, 0)]
    cuts = range(0, len(samples), _SPAN)
    each = (
        _differences(batch, index, at, samples[k : k + _SPAN], rate[k : k + _SPAN]) for k in cuts
    )
    z, H, states = zip(*each, strict=True)
    return Sighting(samples, np.concatenate(z), states[0], np.concatenate(H), noise)


def _differences(
    batch: Batch, index: int, at: Trajectory, samples: Ints, rate: Floats
) -> tuple[Floats, Floats, Ints]:
    """z and H of some readings, and the states that H is of."""
    suite = batch.suite
    places = np.arange(3)[:, None] + np.array(suite.rotations)
    states = at.states[samples].T
    rotations = np.empty((3, 3, len(suite.rotations), len(samples)))
    rotations[:, :, 1:] = matrix(states[places[:, 1:], :1])  # which are the same in all samples
    rotations[:, :, 0] = np.moveaxis(at.attitude[samples], 0, -1)
    estimate = Estimate(places, rotations, states, np.zeros(0))
    y = as_reported(batch.sensors[index][samples])
    vectors = batch.vectors[samples]
    gradient = [vectors[:, k] for k in range(vectors.shape[1])[suite.gradient_rows(index)]]
    r = innovation(
        suite,
        index,
        y,
        vectors[:, index],
        estimate,
        gradient=gradient,
        kind=Linear,
        rate=rate,
        influences=batch.follows(suite.sensors[index], samples),
    )
    found, H = jacobian(r)
    H = np.moveaxis(np.broadcast_to(H, (*H.shape[:2], len(samples))), -1, 0)
    return r.value.T, H, found


def moved(at: Trajectory, parts: Partition, growth: Floats, e: Floats, e_c: Floats,
          suite: Suite) -> Trajectory:  # fmt: skip
    """A trajectory with errors taken out: driven ones e, shape (N, d), and constant ones e_c."""
    attitude = at.attitude @ np.moveaxis(matrix(e[:, :3].T), -1, 0)
    states = at.states.copy()
    states[:, parts.driven[3:]] += e[:, 3:]
    states[:, parts.constant] += growth * e_c
    error = np.zeros(suite.n_states)
    error[parts.constant] = e_c
    for first in suite.rotations[1:]:  # of which none is driven, or decays
        block = slice(first, first + 3)
        states[:, block] = vector(matrix(at.states[0, block]) @ matrix(error[block]))
    return Trajectory(attitude, states)


def discretized(
    suite: Suite, rates: Floats, durations: Floats, follows: Sequence[Floats] = ()
) -> tuple[Floats, Floats]:
    """F and Q, equation (7), of n steps at once, shape (n, n_dynamic, n_dynamic).

    Of attitude and gyro by a series; of the sensors' processes, which depend on nothing else,
    exactly. Coefficients of the gyro's influences turn the attitude as a constant bias does.

    Parameters
    ----------
    follows : sequence of arrays, shape (n, 1)
        Of each of the gyro's influences; see `Suite.influence_values`.
    """
    n, m, k = len(rates), suite.n_dynamic, suite.n_kinematic
    F, Q = np.zeros((2, n, m, m))
    rest = suite.dynamics_matrix(np.zeros(3))
    unit = np.array([(suite.dynamics_matrix(axis) - rest)[:3, 6:k] for axis in np.eye(3)])
    density, turning = suite.diffusion(), np.ascontiguousarray(rates)
    densities, kernel = (density[0], density[3]), load("kinematics")
    kernel.discretized(suite.gyro.bias_decay, densities, unit, turning, durations, F, Q)
    if suite.following:
        constant = np.zeros((2, n, 6, 6))
        kernel.discretized(0.0, densities, unit[:, :, :0], turning, durations, *constant)
        for columns, value in zip(suite.following, follows, strict=True):
            F[:, :3, columns] = value[:, :, None] * constant[0][:, :3, 3:6]
    for process, first in zip(suite.processes.values(), range(k, m, 3), strict=True):
        decay, variance = process.over(durations[:, None])
        own = range(first, first + 3)
        F[:, own, own], Q[:, own, own] = decay, variance
    return F, Q


def _sinhc(x: Floats) -> Floats:
    """sinh(x) / x."""
    ratio: Floats = np.divide(np.sinh(x), x, out=np.ones_like(x), where=x != 0.0)
    return ratio
