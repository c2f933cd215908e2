"""Equations of some samples at once, linear in the errors of a trajectory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
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

#: Samples whose equations are formed at once: those of all would need much memory.
SPAN = 2000


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

    def part(self, low: int, high: int) -> Trajectory:
        """Samples low to high - 1."""
        return Trajectory(self.attitude[low:high], self.states[low:high])


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


@dataclass(frozen=True, eq=False)
class Equations:
    """Those of samples low to high - 1 of a batch.

    Attributes
    ----------
    low, high : int
    batch : Batch
        Of these samples.
    trajectory : Trajectory
        At these samples.
    parts : Partition
    steps : Steps
    sightings : Sightings
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
    turned = turns(own, here.states)
    move = steps(own, here, parts, growth[low:high], turned)
    return Equations(low, high, own, here, parts, move, sightings(own, here, parts, turned[0]))


def spans(n: int) -> Iterator[tuple[int, int, int]]:
    """Parts of n samples, low to high - 1, and which of them is the first that is new.

    Each begins with the last of the one before: so it has all steps to the samples that are new.
    """
    for low in range(0, max(n - 1, 1), SPAN):
        yield low, min(n, low + SPAN + 1), int(low > 0)


def growth(batch: Batch, parts: Partition) -> Floats:
    """Of constants since the first sample, shape (N, c); see `Steps`."""
    suite, N = batch.suite, len(batch.times)
    decay = np.zeros(suite.n_states)
    decay[: suite.n_dynamic] = -np.diag(suite.dynamics_matrix(np.zeros(3)))
    if not decay[parts.constant].any():
        return np.broadcast_to(1.0, (N, len(parts.constant)))
    found: Floats = np.exp(-decay[parts.constant] * (batch.times - batch.times[0])[:, None])
    return found


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
    # all but the bias are the same at all samples
    x = {name: states[:1, i : i + 3] for name, i in suite.places(gyro).items()}
    half = 0.5 * gyro.bias_decay * dt
    # a decaying bias's mean over the step, (1 - exp(-2 h)) / (2 h)
    x["bias"] = states[:-1, 3:6] * np.exp(-half) * _sinhc(half)
    influenced(gyro.influences, x, batch.follows(gyro, slice(1, None)))
    errors = SimpleNamespace(**x)
    rates = gyro.corrected(errors, batch.gyro)
    later = gyro.corrected(errors, batch.gyro + batch.change)
    turn = dt * rates + dt**2 / 12.0 * cross(rates, later)
    return rates, np.moveaxis(exponential(-turn.T), -1, 0)


def steps(
    batch: Batch,
    at: Trajectory,
    parts: Partition,
    grown: Floats | None = None,
    turned: tuple[Floats, Floats] | None = None,
) -> Steps:
    """The kinematics of a trajectory.

    Parameters
    ----------
    grown : array, shape (n + 1, c), optional
        Its `growth`, if the first sample of all is another one.
    turned : tuple of arrays, optional
        Its `turns`, if they are known.
    """
    suite, n = batch.suite, len(batch.gyro)
    rates, turn = turns(batch, at.states) if turned is None else turned
    follows = batch.follows(suite.gyro, slice(1, None))
    F, Q = discretized(suite, rates, batch.durations, follows)
    constant = parts.constant[parts.constant < suite.n_dynamic]
    grown = np.ascontiguousarray(growth(batch, parts) if grown is None else grown)
    G = np.zeros((n, len(parts.driven), len(parts.constant)))
    # rows of F from the fourth on are of a diagonal
    G[:, :3, : len(constant)] = F[:, :3, constant] * grown[:-1, None, : len(constant)]
    bias = parts.driven[3:]
    defect = np.zeros((n, len(parts.driven)))
    reached = at.attitude[1:].swapaxes(1, 2) @ at.attitude[:-1] @ turn.swapaxes(1, 2)
    defect[:, :3] = vector(np.moveaxis(reached, 0, -1)).T
    defect[:, 3:] = np.einsum("nii->ni", F)[:, bias] * at.states[:-1, bias] - at.states[1:, bias]
    if len(parts.driven) < suite.n_dynamic:
        F, Q = _of_states(F, parts.driven), _of_states(Q, parts.driven)
    Q[:, range(3), range(3)] += batch.added
    if batch.breaks.any():
        F[batch.breaks, :3], G[batch.breaks, :3], defect[batch.breaks, :3] = 0.0, 0.0, 0.0
        Q[batch.breaks, :3], Q[batch.breaks, :, :3] = 0.0, 0.0
        Q[np.flatnonzero(batch.breaks)[:, None], range(3), range(3)] = UNKNOWN**2
    return Steps(F, G, Q, defect, grown)


def sightings(
    batch: Batch, at: Trajectory, parts: Partition, rates: Floats | None = None
) -> Sightings:
    """The readings of all sensors; `rates` saves finding those of `turns`."""
    rates = turns(batch, at.states)[0] if rates is None else rates
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
    return Sighting(samples, r.value.T, found, H, noise)


def misfits(batch: Batch, index: int, at: Trajectory) -> Floats:
    """z of a sensor at all samples, shape (N, k), NaN where it has not reported; see `Sighting`."""
    found = np.full((len(batch.times), len(batch.suite.sensors[index].noise())), np.nan)
    for low, high, first in spans(len(found)):
        seen = sighting(batch.part(low, high), index, at.part(low, high))
        new = seen.samples >= first
        found[low + seen.samples[new]] = seen.z[new]
    return found


def moved(at: Trajectory, parts: Partition, growth: Floats, e: Floats, e_c: Floats,
          suite: Suite, share: float = 1.0) -> Trajectory:  # fmt: skip
    """A trajectory with a share of errors taken out: driven ones e, shape (N, d), constant e_c."""
    attitude, states = np.empty_like(at.attitude), at.states.copy()
    error = np.zeros(suite.n_states)
    error[parts.constant] = e_c = share * e_c
    for low, high, _ in spans(len(e)):
        own, off = slice(low + (low > 0), high), share * e[low + (low > 0) : high]
        attitude[own] = at.attitude[own] @ np.moveaxis(matrix(off[:, :3].T), -1, 0)
        states[own, parts.driven[3:]] += off[:, 3:]
        states[own, parts.constant] += growth[own] * e_c
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
    density, turning, unit = suite.diffusion(), np.ascontiguousarray(rates), _by_rate(suite)
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


@lru_cache(maxsize=16)
def _by_rate(suite: Suite) -> Floats:
    """By what the gyro's constants change the attitude's rate, of each component of the rate."""
    k, rest = suite.n_kinematic, suite.dynamics_matrix(np.zeros(3))
    return np.array([(suite.dynamics_matrix(axis) - rest)[:3, 6:k] for axis in np.eye(3)])


def _of_states(A: Floats, states: Ints) -> Floats:
    """Rows and columns of n matrices; by slices, of which there are few."""
    found = np.empty((len(A), len(states), len(states)))
    ends = [0, *(np.flatnonzero(np.diff(states) > 1) + 1), len(states)]
    runs = [(slice(i, j), slice(states[i], states[j - 1] + 1)) for i, j in pairwise(ends)]
    for own, rows in runs:
        for others, columns in runs:
            found[:, own, others] = A[:, rows, columns]
    return found


def _sinhc(x: Floats) -> Floats:
    """sinh(x) / x."""
    ratio: Floats = np.divide(np.sinh(x), x, out=np.ones_like(x), where=x != 0.0)
    return ratio
