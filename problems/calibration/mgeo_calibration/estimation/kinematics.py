"""Process equations of a trajectory from the measured gyro rates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import (
    cross,
    exponential_map,
    rotation_jacobian,
    rotation_vector,
)
from mgeo_attitude.sensors.error_models import apply_bias_sensitivities
from mgeo_attitude.sensors.gyro import has_axis_dependent_noise
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.kernels import load_compiled_module
from mgeo_calibration.estimation.prior import UNKNOWN_ATTITUDE_SIGMA
from mgeo_calibration.estimation.step_noise import correlate_step_noise
from mgeo_calibration.estimation.trajectory import Partition, Trajectory
from mgeo_calibration.telemetry.attitude_hold import AssumedAttitude


@dataclass(frozen=True, eq=False)
class ProcessEquations:
    """Process equations defect + F e_k + G e_c - e_{k+1} ~ N(0, Q).

    e_k are the errors of the stochastic states, e_c the errors of the constant states. Constant
    states affect only the attitude, so G has three rows.

    Attributes
    ----------
    F, Q : arrays, shape (n, d, d)
        Transition matrices and process noise covariances.
    G : array, shape (n, 3, c)
        Change of the attitude error by the constant states.
    defect : array, shape (n, d)
        Propagated minus estimated states at the end of each step.
    constant_factors : array, shape (n + 1, c)
        Factor of each constant state since the first sample of the batch; below one for a gyro bias
        that decays without process noise.
    """

    F: Floats
    G: Floats
    Q: Floats
    defect: Floats
    constant_factors: Floats

    @property
    def arrays(self) -> tuple[Floats, Floats, Floats, Floats]:
        """F, G, Q and defect, as the compiled loops expect them."""
        return self.F, self.G, self.Q, self.defect


def compute_constant_factors(batch: Batch, partition: Partition) -> Floats:
    """Return the factors of the constant states since the first sample, shape (N, c)."""
    suite, N = batch.suite, len(batch.times)
    decay = np.zeros(suite.n_states)
    decay[: suite.n_dynamic] = -np.diag(suite.dynamics_matrix(np.zeros(3)))
    if not decay[partition.constant].any():
        return np.broadcast_to(1.0, (N, len(partition.constant)))
    result: Floats = np.exp(-decay[partition.constant] * (batch.times - batch.times[0])[:, None])
    return result


def compute_rates_and_rotations(batch: Batch, states: Floats) -> tuple[Floats, Floats]:
    """Return the corrected body rates and the rotation of the body in each step.

    The rotation of a linearly varying rate includes the coning term (J. E. Bortz, A New
    Mathematical Formulation for Strapdown Inertial Navigation, IEEE Transactions on Aerospace and
    Electronic Systems AES-7 (1971) 61-66).

    Parameters
    ----------
    states : array, shape (n + 1, n_states)
        States of the gyro and the sensors at each sample.

    Returns
    -------
    rates : array, shape (n, 3)
        Corrected rates [rad/s].
    turn : array, shape (n, 3, 3)
        Matrices that multiply GCRS-to-body rotation matrices from the left.
    """
    gyro, suite, dt = batch.suite.gyro, batch.suite, batch.durations[:, None]
    # All gyro states except the bias are constant.
    x = {name: states[:1, i : i + 3] for name, i in suite.get_first_indices(gyro).items()}
    half = 0.5 * gyro.bias_decay * dt
    # Mean of the decaying bias over the step, (1 - exp(-2 h)) / (2 h).
    x["bias"] = states[:-1, 3:6] * np.exp(-half) * _sinhc(half)
    apply_bias_sensitivities(
        gyro.bias_sensitivities, x, batch.select_channel_values(gyro, slice(1, None))
    )
    errors = SimpleNamespace(**x)
    rates = gyro.correct_measurement(errors, batch.gyro_rates)
    later = gyro.correct_measurement(errors, batch.gyro_rates + batch.rate_changes)
    turn = dt * rates + dt**2 / 12.0 * cross(rates, later)
    return rates, np.moveaxis(exponential_map(-turn.T), -1, 0)


def linearize_process(
    batch: Batch,
    trajectory: Trajectory,
    partition: Partition,
    constant_factors: Floats | None = None,
) -> ProcessEquations:
    """Linearize the process equations about a trajectory.

    Parameters
    ----------
    trajectory : Trajectory
        Trajectory to linearize about.
    constant_factors : array, shape (n + 1, c), optional
        Factors of the constant states, if the first sample is not the first sample of the batch.
    """
    suite, n = batch.suite, len(batch.gyro_rates)
    rates, turn = compute_rates_and_rotations(batch, trajectory.states)
    follows = batch.select_channel_values(suite.gyro, slice(1, None))
    F, Q = discretize_dynamics(suite, rates, batch.durations, follows)
    # Only the constant states of the gyro, which come first, change the attitude.
    turned_by = F[:, :3, partition.constant[partition.constant < suite.n_kinematic]]
    F, Q = (
        each.take(partition.stochastic, axis=1).take(partition.stochastic, axis=2)
        for each in (F, Q)
    )
    constant_factors = np.ascontiguousarray(
        compute_constant_factors(batch, partition) if constant_factors is None else constant_factors
    )
    G = np.zeros((n, 3, len(partition.constant)))
    # F is diagonal from the fourth row on.
    c = turned_by.shape[2]
    G[:, :, :c] = turned_by * constant_factors[:-1, None, :c]
    bias = partition.stochastic[3:]
    defect = np.zeros((n, len(partition.stochastic)))
    reached = (
        trajectory.attitude[1:].swapaxes(1, 2) @ trajectory.attitude[:-1] @ turn.swapaxes(1, 2)
    )
    defect[:, :3] = rotation_vector(np.moveaxis(reached, 0, -1)).T
    defect[:, 3:] = (
        np.einsum("nii->ni", F)[:, 3:] * trajectory.states[:-1, bias] - trajectory.states[1:, bias]
    )
    Q[:, range(3), range(3)] += batch.excess_angle_variance
    if batch.pointing is not None:
        F[:, :3], G[:], Q[:, :3], Q[:, :, :3] = 0.0, 0.0, 0.0, 0.0
        F[:, :3, :3], Q[:, :3, :3], defect[:, :3] = _linearize_pointing(
            batch.pointing, trajectory, batch.durations
        )
    correlate_step_noise(suite, partition.stochastic, batch.durations, Q)
    if batch.breaks.any():
        F[batch.breaks, :3], G[batch.breaks], defect[batch.breaks, :3] = 0.0, 0.0, 0.0
        Q[batch.breaks, :3], Q[batch.breaks, :, :3] = 0.0, 0.0
        Q[np.flatnonzero(batch.breaks)[:, None], range(3), range(3)] = UNKNOWN_ATTITUDE_SIGMA**2
    return ProcessEquations(F, G, Q, defect, constant_factors)


def _linearize_pointing(
    pointing: AssumedAttitude, trajectory: Trajectory, durations: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return F, Q and defect of the attitude if its error is a process about the held attitude.

    The vectors p of the rotations from the held attitude satisfy p_{k+1} = φ p_k + w exactly. An
    error e of the attitude changes them by J e.
    """
    decay, variance = pointing.pointing_error.discretize(durations)
    p = rotation_vector(np.moveaxis(pointing.attitude.swapaxes(1, 2) @ trajectory.attitude, 0, -1))
    J = np.moveaxis(rotation_jacobian(p), -1, 0)
    inverse = np.linalg.inv(J[1:])
    F = decay[:, None, None] * inverse @ J[:-1]
    Q = variance[:, None, None] * inverse @ inverse.swapaxes(1, 2)
    return F, Q, np.einsum("nij,jn->ni", inverse, decay * p[:, :-1] - p[:, 1:])


def discretize_dynamics(
    suite: Suite, rates: Floats, durations: Floats, channel_values: Sequence[Floats] = ()
) -> tuple[Floats, Floats]:
    """Discretize the error dynamics of n steps, equation (7).

    Attitude and gyro use a power series, the independent sensor processes the exact solution. The
    bias sensitivities of the gyro act on the attitude as constant biases.

    Parameters
    ----------
    rates : array, shape (n, 3)
        Body rates [rad/s].
    durations : array, shape (n,)
        Durations of the steps [s].
    channel_values : sequence of arrays, shape (n, 1)
        Value of each channel of the gyro's bias sensitivities; see `Suite.compute_channel_deviations`.

    Returns
    -------
    F, Q : arrays, shape (n, n_dynamic, n_dynamic)
    """
    n, m, k = len(rates), suite.n_dynamic, suite.n_kinematic
    F, Q = np.zeros((2, n, m, m))
    density, turning, unit = (
        suite.compute_noise_density(),
        np.ascontiguousarray(rates),
        _differentiate_dynamics(suite),
    )
    densities, kernel = (density[0], density[3]), load_compiled_module("kinematics")
    kernel.discretize_steps(suite.gyro.bias_decay, densities, unit, turning, durations, F, Q)
    if has_axis_dependent_noise(density):
        load_compiled_module("process_noise").compute_process_noise(
            suite.gyro.bias_decay, density[:6], turning, durations, Q
        )
    if suite.gyro_sensitivity_slices:
        constant = np.zeros((2, n, 6, 6))
        kernel.discretize_steps(0.0, densities, unit[:, :, :0], turning, durations, *constant)
        for columns, value in zip(suite.gyro_sensitivity_slices, channel_values, strict=True):
            F[:, :3, columns] = value[:, :, None] * constant[0][:, :3, 3:6]
    for process, first in zip(suite.processes.values(), range(k, m, 3), strict=True):
        decay, variance = process.discretize(durations[:, None])
        own = range(first, first + 3)
        F[:, own, own], Q[:, own, own] = decay, variance
    return F, Q


@lru_cache(maxsize=16)
def _differentiate_dynamics(suite: Suite) -> Floats:
    """Return the derivative of the gyro columns of the dynamics matrix by each rate component."""
    k, rest = suite.n_kinematic, suite.dynamics_matrix(np.zeros(3))
    return np.array([(suite.dynamics_matrix(axis) - rest)[:3, 6:k] for axis in np.eye(3)])


def _sinhc(x: Floats) -> Floats:
    """Return sinh(x) / x."""
    ratio: Floats = np.divide(np.sinh(x), x, out=np.ones_like(x), where=x != 0.0)
    return ratio
