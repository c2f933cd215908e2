"""From one sample to the next: how errors of a trajectory go on, by what the gyro has measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import (
    cross,
    exponential,
    rotation_jacobian,
    rotation_vector,
)
from mgeo_attitude.sensors.errors import influenced
from mgeo_attitude.sensors.gyro import is_uneven
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import UNKNOWN
from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.step_noise import correlate
from mgeo_calibration.estimation.trajectory import Partition, Trajectory
from mgeo_calibration.telemetry.held import Held


@dataclass(frozen=True, eq=False)
class Steps:
    """defect + F e_k + G e_c - e_{k+1} ~ N(0, Q) for driven errors e_k and constant errors e_c.

    Constants change the attitude alone: only these three rows of G are there.

    Attributes
    ----------
    F, Q : arrays, shape (n, d, d)
    G : array, shape (n, 3, c)
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
) -> Steps:
    """The kinematics of a trajectory.

    Parameters
    ----------
    grown : array, shape (n + 1, c), optional
        Its `growth`, if the first sample of all is another one.
    """
    suite, n = batch.suite, len(batch.gyro)
    rates, turn = turns(batch, at.states)
    follows = batch.follows(suite.gyro, slice(1, None))
    F, Q = discretized(suite, rates, batch.durations, follows)
    # of the gyro's constants alone, which are the leading ones
    turned_by = F[:, :3, parts.constant[parts.constant < suite.n_kinematic]]
    F, Q = (each.take(parts.driven, axis=1).take(parts.driven, axis=2) for each in (F, Q))
    grown = np.ascontiguousarray(growth(batch, parts) if grown is None else grown)
    G = np.zeros((n, 3, len(parts.constant)))
    # rows of F from the fourth on are of a diagonal
    c = turned_by.shape[2]
    G[:, :, :c] = turned_by * grown[:-1, None, :c]
    bias = parts.driven[3:]
    defect = np.zeros((n, len(parts.driven)))
    reached = at.attitude[1:].swapaxes(1, 2) @ at.attitude[:-1] @ turn.swapaxes(1, 2)
    defect[:, :3] = rotation_vector(np.moveaxis(reached, 0, -1)).T
    defect[:, 3:] = np.einsum("nii->ni", F)[:, 3:] * at.states[:-1, bias] - at.states[1:, bias]
    Q[:, range(3), range(3)] += batch.added
    if batch.held is not None:
        F[:, :3], G[:], Q[:, :3], Q[:, :, :3] = 0.0, 0.0, 0.0, 0.0
        F[:, :3, :3], Q[:, :3, :3], defect[:, :3] = _pointing(batch.held, at, batch.durations)
    correlate(suite, parts.driven, batch.durations, Q)
    if batch.breaks.any():
        F[batch.breaks, :3], G[batch.breaks], defect[batch.breaks, :3] = 0.0, 0.0, 0.0
        Q[batch.breaks, :3], Q[batch.breaks, :, :3] = 0.0, 0.0
        Q[np.flatnonzero(batch.breaks)[:, None], range(3), range(3)] = UNKNOWN**2
    return Steps(F, G, Q, defect, grown)


def _pointing(held: Held, at: Trajectory, durations: Floats) -> tuple[Floats, Floats, Floats]:
    """Return F, Q and defect of the attitude if its error is a process about the held attitude.

    The vectors p of the rotations from the held attitude satisfy p_{k+1} = φ p_k + w exactly. An
    error e of the attitude changes them by J e.
    """
    decay, variance = held.error.over(durations)
    p = rotation_vector(np.moveaxis(held.attitude.swapaxes(1, 2) @ at.attitude, 0, -1))
    J = np.moveaxis(rotation_jacobian(p), -1, 0)
    inverse = np.linalg.inv(J[1:])
    F = decay[:, None, None] * inverse @ J[:-1]
    Q = variance[:, None, None] * inverse @ inverse.swapaxes(1, 2)
    return F, Q, np.einsum("nij,jn->ni", inverse, decay * p[:, :-1] - p[:, 1:])


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
    if is_uneven(density):
        load("process_noise").process_noise(
            suite.gyro.bias_decay, density[:6], turning, durations, Q
        )
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


def _sinhc(x: Floats) -> Floats:
    """sinh(x) / x."""
    ratio: Floats = np.divide(np.sinh(x), x, out=np.ones_like(x), where=x != 0.0)
    return ratio
