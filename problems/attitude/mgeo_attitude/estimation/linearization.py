"""Equations of all samples at once, linear in the errors of a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.estimation.batch import Batch
from mgeo_attitude.estimation.belief import UNKNOWN
from mgeo_attitude.estimation.estimate import Estimate
from mgeo_attitude.estimation.innovation import innovation, jacobian
from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.rotation import exponential, matrix, vector
from mgeo_attitude.sensors.readings import as_reported

_SERIES = 0.5  # |ω| dt up to which the series below converges fast
_TERMS = 30


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


@dataclass(frozen=True, eq=False)
class Sightings:
    """z - H e ~ N(0, diag(noise)²) for m readings of a sensor.

    Attributes
    ----------
    samples : array of int, shape (m,)
    z : array, shape (m, 3)
    states : array of int, shape (p,)
        Those that H, shape (m, 3, p), is of.
    noise : array, shape (3,)
    """

    samples: Ints
    z: Floats
    states: Ints
    H: Floats
    noise: Floats


def turns(batch: Batch, states: Floats) -> tuple[Floats, Floats]:
    """Corrected body rate, shape (n, 3), and what it turns GCRS-to-body matrices by in each step.

    Parameters
    ----------
    states : array, shape (n + 1, n_states)
    """
    gyro, suite, dt = batch.suite.gyro, batch.suite, batch.durations
    x = {name: states[:-1, i : i + 3] for name, i in suite.places(gyro).items()}
    half = 0.5 * gyro.bias_decay * dt[:, None]
    # a decaying bias's mean over the step, (1 - exp(-2 h)) / (2 h)
    x["bias"] = x["bias"] * np.exp(-half) * _sinhc(half)
    rates = gyro.corrected(SimpleNamespace(**x), batch.gyro)
    return rates, np.moveaxis(exponential(-(dt[:, None] * rates).T), -1, 0)


def steps(batch: Batch, at: Trajectory, parts: Partition) -> Steps:
    """The kinematics of a trajectory."""
    suite, n = batch.suite, len(batch.gyro)
    rates, turn = turns(batch, at.states)
    F, Q = discretized(suite, rates, batch.durations)
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
    F, Q = F[:, parts.driven[:, None], parts.driven], Q[:, parts.driven[:, None], parts.driven]
    Q[:, range(3), range(3)] += batch.interpolated[:, None]
    if batch.breaks.any():
        F[batch.breaks, :3], G[batch.breaks, :3], defect[batch.breaks, :3] = 0.0, 0.0, 0.0
        Q[batch.breaks, :3], Q[batch.breaks, :, :3] = 0.0, 0.0
        Q[np.flatnonzero(batch.breaks)[:, None], range(3), range(3)] = UNKNOWN**2
    return Steps(F, G, Q, defect, growth)


def sightings(batch: Batch, index: int, at: Trajectory) -> Sightings:
    """The readings of a sensor of the suite, by its number."""
    suite, sensor = batch.suite, batch.suite.sensors[index]
    samples = np.flatnonzero(np.isfinite(batch.sensors[index][:, 0, 0]))
    noise = np.array(sensor.noise())
    if not len(samples):
        return Sightings(samples, np.zeros((0, 3)), samples, np.zeros((0, 3, 0)), noise)
    places = np.arange(3)[:, None] + np.array(suite.rotations)
    states = at.states[samples].T
    rotations = matrix(states[places])
    rotations[:, :, 0] = np.moveaxis(at.attitude[samples], 0, -1)
    estimate = Estimate(places, rotations, states, np.zeros(0))
    y = as_reported(batch.sensors[index][samples])
    vectors = batch.vectors[samples]
    gradient = [vectors[:, k] for k in range(vectors.shape[1])[suite.gradient_rows(index)]]
    r = innovation(suite, index, y, vectors[:, index], estimate, gradient=gradient)
    found, H = jacobian(r)
    H = np.moveaxis(np.broadcast_to(H, (*H.shape[:2], len(samples))), -1, 0)
    return Sightings(samples, r.value.T, found, H, noise)


def moved(at: Trajectory, parts: Partition, growth: Floats, e: Floats, e_c: Floats,
          suite: Suite) -> Trajectory:  # fmt: skip
    """A trajectory with errors taken out: driven ones e, shape (N, d), and constant ones e_c."""
    attitude = at.attitude @ np.moveaxis(matrix(e[:, :3].T), -1, 0)
    states = at.states.copy()
    full = np.zeros_like(states)
    full[:, parts.driven], full[:, parts.constant] = e, growth * e_c
    full[:, :3] = 0.0
    states += full
    for first in suite.rotations[1:]:
        block = slice(first, first + 3)
        both = np.einsum("ijn,jkn->ikn", matrix(at.states[:, block].T), matrix(full[:, block].T))
        states[:, block] = vector(both).T
    return Trajectory(attitude, states)


def discretized(suite: Suite, rates: Floats, durations: Floats) -> tuple[Floats, Floats]:
    """F and Q, equation (7), of n steps at once, shape (n, n_dynamic, n_dynamic).

    Of attitude and gyro by the series of `filter.discretization.discretize`, on steps halved as
    often as the worst needs; of the sensors' processes, which depend on nothing else, exactly.
    """
    n, m, k = len(rates), suite.n_dynamic, suite.n_kinematic
    F, Q = np.zeros((2, n, m, m))
    F[:, :k, :k], Q[:, :k, :k] = _kinematic(suite, rates, durations)
    for process, first in zip(suite.processes.values(), range(k, m, 3), strict=True):
        for i in range(first, first + 3):
            F[:, i, i], Q[:, i, i] = process.over(durations)
    return F, Q


def _kinematic(suite: Suite, rates: Floats, durations: Floats) -> tuple[Floats, Floats]:
    k = suite.n_kinematic
    matrices = map(suite.dynamics_matrix, np.vstack([np.zeros(3), np.eye(3)]))
    rest, *unit = (matrix[:k, :k] for matrix in matrices)
    A = rest + np.einsum("na,aij->nij", rates, np.array([one - rest for one in unit]))
    angle = float((np.linalg.norm(rates, axis=1) * durations).max(initial=0.0))
    halvings = max(0, int(np.ceil(np.log2(angle / _SERIES)))) if angle > 0.0 else 0
    A *= durations[:, None, None] / 2.0**halvings
    F_term = np.broadcast_to(np.eye(len(rest)), A.shape)
    Q_term = np.diag(suite.diffusion()[:k]) * durations[:, None, None] / 2.0**halvings
    F, Q = F_term.copy(), Q_term.copy()
    for m in range(1, _TERMS):
        F_term = A @ F_term / m
        Q_term = A @ Q_term / (m + 1)
        Q_term = Q_term + Q_term.swapaxes(1, 2)
        F += F_term
        Q += Q_term
        if np.abs(F_term).max() < 1e-17 and (np.abs(Q_term) <= 1e-17 * np.abs(Q).max()).all():
            break
    for _ in range(halvings):
        Q = Q + F @ Q @ F.swapaxes(1, 2)
        F = F @ F
    return F, Q


def _sinhc(x: Floats) -> Floats:
    """sinh(x) / x."""
    ratio: Floats = np.divide(np.sinh(x), x, out=np.ones_like(x), where=x != 0.0)
    return ratio
