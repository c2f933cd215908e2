"""Process equations of attitude, gyro states and sensor states from the measured gyro rates."""

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
    """Process equations of all steps of a batch, linearized about a trajectory.

    Consecutive samples satisfy defect + F e_k + G e_c - e_{k+1} ~ N(0, Q). Here e_k are the errors
    of the stochastic states, and e_c the errors of the constant states. Constant states affect only
    the attitude, so that G has three rows.

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
        """Arrays F, G, Q and defect in the order that the compiled functions expect."""
        return self.F, self.G, self.Q, self.defect


def compute_constant_factors(batch: Batch, partition: Partition) -> Floats:
    """Return the factors by which states without process noise have decayed since the first sample,
    as an array of shape (N, c).

    All factors are one, except for a gyro bias that decays without process noise.

    Parameters
    ----------
    batch : Batch
        Batch of N samples.
    partition : Partition
        Stochastic states and c constant states.
    """
    suite, N = batch.suite, len(batch.times)
    decay = np.zeros(suite.n_states)
    decay[: suite.n_dynamic] = -np.diag(suite.dynamics_matrix(np.zeros(3)))
    if not decay[partition.constant].any():
        return np.broadcast_to(1.0, (N, len(partition.constant)))
    result: Floats = np.exp(-decay[partition.constant] * (batch.times - batch.times[0])[:, None])
    return result


def compute_rates_and_rotations(batch: Batch, states: Floats) -> tuple[Floats, Floats]:
    """Return the mean body rate and the rotation matrix of each step, from gyro rates corrected by
    the estimated gyro states.

    The rotation of a linearly varying rate includes the coning term (J. E. Bortz, A New
    Mathematical Formulation for Strapdown Inertial Navigation, IEEE Transactions on Aerospace and
    Electronic Systems AES-7 (1971) 61-66).

    Parameters
    ----------
    batch : Batch
        Batch of n steps.
    states : array, shape (n + 1, n_states)
        Estimated states of the gyro and the sensors at each sample.

    Returns
    -------
    rates : array, shape (n, 3)
        Corrected rates [rad/s].
    rotations : array, shape (n, 3, 3)
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
    gyro_states = SimpleNamespace(**x)
    rates = gyro.correct_measurement(gyro_states, batch.gyro_rates)
    end_rates = gyro.correct_measurement(gyro_states, batch.gyro_rates + batch.rate_changes)
    rotation_vectors = dt * rates + dt**2 / 12.0 * cross(rates, end_rates)
    return rates, np.moveaxis(exponential_map(-rotation_vectors.T), -1, 0)


def linearize_process(
    batch: Batch,
    trajectory: Trajectory,
    partition: Partition,
    constant_factors: Floats | None = None,
) -> ProcessEquations:
    """Linearize the process equations of a batch about a trajectory.

    The process noise of the attitude includes `Batch.excess_angle_variance`. In a suite with
    `StepNoise`, for sensors with a measurement latency, the step noise is correlated with the
    attitude. If the satellite is assumed to hold an attitude (`Batch.pointing`), the attitude
    follows the pointing error instead of the measured rates. A step in `Batch.breaks` makes the
    attitude unknown: its rows of F, G and defect are zero, and its variance is
    `UNKNOWN_ATTITUDE_SIGMA` squared.

    Parameters
    ----------
    batch : Batch
    trajectory : Trajectory
        Trajectory to linearize about.
    partition : Partition
        Stochastic and constant states.
    constant_factors : array, shape (n + 1, c), optional
        Result of `compute_constant_factors` for the batch from which these samples are selected.
        Default: the first sample is the start of the batch.

    Returns
    -------
    ProcessEquations
    """
    suite, n = batch.suite, len(batch.gyro_rates)
    rates, rotations = compute_rates_and_rotations(batch, trajectory.states)
    channel_values = batch.select_channel_values(suite.gyro, slice(1, None))
    F, Q = discretize_dynamics(suite, rates, batch.durations, channel_values)
    # Only the constant states of the gyro, which come first, change the attitude.
    attitude_columns = F[:, :3, partition.constant[partition.constant < suite.n_kinematic]]
    F, Q = (
        each.take(partition.stochastic, axis=1).take(partition.stochastic, axis=2)
        for each in (F, Q)
    )
    constant_factors = np.ascontiguousarray(
        compute_constant_factors(batch, partition) if constant_factors is None else constant_factors
    )
    G = np.zeros((n, 3, len(partition.constant)))
    # F is diagonal from the fourth row on.
    c = attitude_columns.shape[2]
    G[:, :, :c] = attitude_columns * constant_factors[:-1, None, :c]
    bias = partition.stochastic[3:]
    defect = np.zeros((n, len(partition.stochastic)))
    closing_rotations = (
        trajectory.attitude[1:].swapaxes(1, 2) @ trajectory.attitude[:-1] @ rotations.swapaxes(1, 2)
    )
    defect[:, :3] = rotation_vector(np.moveaxis(closing_rotations, 0, -1)).T
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
    """Linearize the attitude of a satellite that holds an attitude with a random pointing error.
    Return the transition matrices, process noise covariances and defects.

    The vectors p represent the rotations from the held attitude (twice the Gibbs vectors) and
    satisfy p_{k+1} = φ p_k + w exactly. An error e of the attitude changes p by J e.
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
    """Discretize the dynamics of attitude, gyro states and time-varying sensor states over n steps.

    The matrices are those of equation (8) of docs/explanation/models-and-filter.md. Attitude and
    gyro use a power series, the independent sensor processes the exact solution. The bias
    sensitivities of the gyro act on the attitude as constant biases.

    Parameters
    ----------
    suite : Suite
    rates : array, shape (n, 3)
        Body rates [rad/s].
    durations : array, shape (n,)
        Durations of the steps [s].
    channel_values : sequence of arrays, shape (n, 1)
        Value of each channel of the gyro's bias sensitivities; see
        `Suite.compute_channel_deviations`.

    Returns
    -------
    F, Q : arrays, shape (n, n_dynamic, n_dynamic)
    """
    n, m, k = len(rates), suite.n_dynamic, suite.n_kinematic
    F, Q = np.zeros((2, n, m, m))
    density, body_rates, rate_derivatives = (
        suite.compute_noise_density(),
        np.ascontiguousarray(rates),
        _differentiate_dynamics(suite),
    )
    densities, kernel = (density[0], density[3]), load_compiled_module("kinematics")
    kernel.discretize_steps(
        suite.gyro.bias_decay, densities, rate_derivatives, body_rates, durations, F, Q
    )
    if has_axis_dependent_noise(density):
        load_compiled_module("process_noise").compute_process_noise(
            suite.gyro.bias_decay, density[:6], body_rates, durations, Q
        )
    if suite.gyro_sensitivity_slices:
        constant = np.zeros((2, n, 6, 6))
        kernel.discretize_steps(
            0.0, densities, rate_derivatives[:, :, :0], body_rates, durations, *constant
        )
        for columns, value in zip(suite.gyro_sensitivity_slices, channel_values, strict=True):
            F[:, :3, columns] = value[:, :, None] * constant[0][:, :3, 3:6]
    for process, first in zip(suite.processes.values(), range(k, m, 3), strict=True):
        decay, variance = process.discretize(durations[:, None])
        states = range(first, first + 3)
        F[:, states, states], Q[:, states, states] = decay, variance
    return F, Q


@lru_cache(maxsize=16)
def _differentiate_dynamics(suite: Suite) -> Floats:
    """Differentiate the dynamics matrix with respect to the body rate. Only the attitude rows and
    the columns of the constant gyro states are returned.

    Element [k, i, j] of the result, shape (3, 3, n), is the derivative of entry (i, j) of the
    dynamics matrix with respect to rate component k, for the n columns of the constant states.
    """
    k, rest_matrix = suite.n_kinematic, suite.dynamics_matrix(np.zeros(3))
    return np.array([(suite.dynamics_matrix(axis) - rest_matrix)[:3, 6:k] for axis in np.eye(3)])


def _sinhc(x: Floats) -> Floats:
    ratio: Floats = np.divide(np.sinh(x), x, out=np.ones_like(x), where=x != 0.0)
    return ratio
