"""Regressors of score tests for model errors, such as latencies, drifts and scale factors.

All regressors are linear about a smoother solution and follow from the smoothed trajectory, whose
errors are independent of the residuals. The measured gyro rates are not independent: their noise is
part of the residuals, and a healthy gyro at rest would appear to have a scale factor error of 100 %
(W. A. Fuller, Measurement Error Models, Wiley 1987).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import rotation_matrix, shear, skew
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

from mgeo_calibration.estimation.kinematics import compute_rates_and_rotations
from mgeo_calibration.estimation.linearization import Equations, compute_sensor_innovations
from mgeo_calibration.estimation.score import ModelError, ModelErrorCombination
from mgeo_calibration.estimation.smoother import Solution

#: Number of equal parts of the data. A slowly varying offset is piecewise linear over the parts.
N_PARTS = 8
#: Largest number of half waves of the cosines that represent a slow drift.
N_HALF_WAVES = 3
#: Cycles over the data of the sinusoids that represent gyro noise; all are faster than a drift.
CYCLES = (3.0, 6.0, 12.0, 24.0)
#: Savitzky-Golay filter of the rates: window lengths in steps, polynomial order, variance gain of
#: differences of the next order for white noise, and largest change of the rates by the filter in
#: units of their noise.
_WINDOW_LENGTHS, _POLYNOMIAL_ORDER, _DIFFERENCE_VARIANCE_GAIN, _MAX_SMOOTHING_CHANGE = (
    (33, 17, 9, 5),
    2,
    20.0,
    1.5,
)
#: Error sizes for a coefficient of one. A combination of coefficients with a larger 1-sigma is not
#: tested.
LARGE_DELAY_S = 10.0
LARGE_AXES_ERROR = 0.1
LARGE_OFFSET = 10.0  # in units of the 1-sigma of a sensor's noise
#: Function from the fraction of elapsed time, shape (n,), to k offset profiles, shape (n, k).
Profile = Callable[[Floats], Floats]
#: Function that returns the rate of a sensor's readings due to the inertial motion of the observed
#: vector, shape (n, 3) [1/s].
VectorRates = Callable[[Equations, int], Floats]


def compute_smoothed_rates(solution: Solution) -> Floats:
    """Compute the mean body rate in each step [rad/s] from the smoothed attitude, as an array of
    shape (N - 1, 3).

    If the declared gyro noise is too large, the smoothed attitude follows the noise of single
    readings. The rates are therefore filtered over as many steps as the motion allows (A. Savitzky,
    M. J. E. Golay, Analytical Chemistry 36 (1964) 1627-1639).

    Parameters
    ----------
    solution : Solution
        Converged smoother solution.
    """
    rates = _compute_attitude_rates(solution)
    noise = np.median(np.abs(np.diff(rates, _POLYNOMIAL_ORDER + 1, axis=0)), axis=0) / math.sqrt(
        _DIFFERENCE_VARIANCE_GAIN
    )
    for width in _WINDOW_LENGTHS:
        if width < len(rates):
            result = savgol_filter(rates, width, _POLYNOMIAL_ORDER, axis=0)
            if (np.median(np.abs(rates - result), axis=0) <= _MAX_SMOOTHING_CHANGE * noise).all():
                return np.asarray(result, dtype=np.float64)
    return rates


def estimate_angle_random_walk(solution: Solution) -> float:
    """Estimate the gyro's angle random walk [rad/sqrt(s)] by comparing its rates with the smoothed
    attitude.

    Parameters
    ----------
    solution : Solution
        Converged smoother solution.
    """
    batch = solution.batch
    rates, _ = compute_rates_and_rotations(batch, solution.estimate.states)
    differences = (rates - _compute_attitude_rates(solution))[~batch.breaks]
    return float(np.sqrt(np.mean(differences**2 * batch.durations[~batch.breaks, None])))


def _compute_attitude_rates(solution: Solution) -> Floats:
    attitude, batch = solution.estimate.attitude, solution.batch
    rotations = attitude[:-1].swapaxes(1, 2) @ attitude[1:]
    rates: Floats = Rotation.from_matrix(rotations).as_rotvec() / batch.durations[:, None]
    rates[batch.breaks] = 0.0
    return rates


def build_bias_decay_error(solution: Solution) -> ModelError:
    """Build the score-test regressors for an error in the correlation time of the gyro bias.

    A coefficient of one increases the inverse correlation time by one over the duration of the
    data.

    Parameters
    ----------
    solution : Solution
        Converged smoother solution.
    """
    times = solution.batch.times
    elapsed, dt, bias = times - times[0], np.diff(times), solution.estimate.states[:-1, 3:6]
    decay = np.exp(-solution.batch.suite.gyro.bias_decay * elapsed)[:, None]
    integral = np.cumsum(dt[:, None] * bias / decay[:-1], axis=0) / elapsed[-1]
    rate_errors = -decay * np.vstack([np.zeros(3), integral])
    return _build_rate_error(
        lambda equations: rate_errors[equations.low : equations.high - 1, :, None],
        1,
        rate_errors[-1:].T,
    )


def build_bias_drift_error(solution: Solution) -> ModelError:
    """Build the score-test regressors for a gyro bias drift that is piecewise linear in time. Each
    axis has one coefficient for each of the `N_PARTS` equal parts of the data.

    A coefficient of one changes the bias by its initial 1-sigma within its part.

    Parameters
    ----------
    solution : Solution
        Converged smoother solution.
    """
    fractions, size = (
        _compute_elapsed_fractions(solution),
        solution.batch.suite.gyro.states()["bias"],
    )

    def attitude_changes(equations: Equations) -> Floats:
        ramps = size * compute_ramps(fractions[equations.low : equations.high - 1])
        result: Floats = ramps[:, None, :, None] * _compute_rate_sensitivity(equations)[:, :, None]
        return result.reshape(len(ramps), 3, -1)

    return ModelError(
        n_coefficients=3 * N_PARTS,
        attitude_changes=attitude_changes,
        last_bias_change=np.tile(size * np.eye(3), N_PARTS),
    )


def build_gyro_noise_error(solution: Solution) -> ModelError:
    """Build the score-test regressors for excess gyro noise, represented by sinusoids about each
    axis.

    The sinusoids have `CYCLES` cycles over the data. A coefficient of one is an amplitude equal to
    the 1-sigma of the gyro noise in one step.

    Parameters
    ----------
    solution : Solution
        Converged smoother solution.
    """
    batch = solution.batch
    density = np.sqrt(np.array(batch.suite.gyro.compute_noise_density()["theta"]))
    size, fractions = (
        density / np.sqrt(np.median(batch.durations)),
        _compute_elapsed_fractions(solution),
    )

    def rate_errors(equations: Equations) -> Floats:
        phase = 2.0 * np.pi * fractions[equations.low : equations.high - 1, None] * np.array(CYCLES)
        waves = np.concatenate([np.sin(phase), np.cos(phase)], axis=1)
        result: Floats = waves[:, None, :, None] * np.diag(size)[:, None]
        return result.reshape(len(waves), 3, -1)

    return _build_rate_error(rate_errors, 6 * len(CYCLES))


def build_gyro_parameter_error(rates: Floats, state: str) -> ModelError:
    """Build the score-test regressors for a gyro calibration parameter with one coefficient per
    axis.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        Body rates from `compute_smoothed_rates` [rad/s].
    state : str
        "scale_factor", "misalignment", "nonorthogonality" or "scale_asymmetry".
    """
    return _build_rate_error(
        lambda equations: _compute_vector_changes(state, rates[equations.low : equations.high - 1]),
        3,
    )


def build_gyro_time_tag_error(rates: Floats, durations: Floats) -> ModelError:
    """Build the score-test regressor for gyro time stamps that are `LARGE_DELAY_S` too early.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        Body rates from `compute_smoothed_rates` [rad/s].
    durations : array, shape (N - 1,)
        Durations of the steps [s].
    """

    def rate_errors(equations: Equations) -> Floats:
        steps = np.arange(equations.low, equations.high - 1)
        change = rates[steps] - rates[np.maximum(steps - 1, 0)]
        result: Floats = LARGE_DELAY_S * change / durations[steps, None]
        return result[:, :, None]

    return _build_rate_error(rate_errors, 1)


def build_gyro_channel_error(solution: Solution, channel: Floats) -> ModelError:
    """Build the score-test regressors for a gyro bias proportional to a telemetry channel, with one
    coefficient per axis.

    A coefficient of one is a bias of its initial 1-sigma for a channel value of one.

    Parameters
    ----------
    solution : Solution
    channel : array, shape (N,)
        Channel value at each sample.
    """
    size = solution.batch.suite.gyro.states()["bias"]
    return _build_rate_error(
        lambda equations: (
            size * channel[equations.low : equations.high - 1, None, None] * np.eye(3)
        ),
        3,
        size * channel[-1] * np.eye(3),
    )


def build_vector_rates(solution: Solution) -> VectorRates:
    """Build a cached function that computes how fast a sensor's readings change because the
    observed vector moves in GCRS.

    Parameters
    ----------
    solution : Solution
        Converged smoother solution.

    Returns
    -------
    VectorRates
    """
    sensors = len(solution.batch.suite.sensors)
    return lru_cache(maxsize=sensors)(partial(_compute_vector_rate, solution))


def build_latency_error(index: int, rates: Floats, vector_rates: VectorRates) -> ModelError:
    """Build the score-test regressor for a measurement latency of `LARGE_DELAY_S` in one sensor.

    Parameters
    ----------
    index : int
        Index of the sensor in the suite.
    rates : array, shape (N - 1, 3)
        Body rates from `compute_smoothed_rates` [rad/s].
    vector_rates : VectorRates
        Function from `build_vector_rates`.
    """

    def reading_changes(equations: Equations) -> Floats:
        step_rates = rates[np.maximum(np.arange(equations.low, equations.high) - 1, 0)]
        by_rotation = np.einsum("nij,nj->ni", _select_jacobian(equations, index, 0), step_rates)
        result: Floats = -LARGE_DELAY_S * (by_rotation + vector_rates(equations, index))
        return result[:, :, None]

    return ModelError(n_coefficients=1, reading_changes={index: reading_changes})


def build_along_track_error(n_sensors: int, vector_rates: VectorRates) -> ModelError:
    """Build the score-test regressor for a satellite that is `LARGE_DELAY_S` behind its predicted
    orbital position.

    Parameters
    ----------
    n_sensors : int
        Number of sensors in the suite.
    vector_rates : VectorRates
        Function from `build_vector_rates`.
    """

    def build_changes(index: int) -> Callable[[Equations], Floats]:
        return lambda equations: -LARGE_DELAY_S * vector_rates(equations, index)[:, :, None]

    return ModelError(
        n_coefficients=1,
        reading_changes={index: build_changes(index) for index in range(n_sensors)},
    )


def build_vector_error(index: int, state: str) -> ModelError:
    """Build the score-test regressors for undeclared scale factors or non-orthogonality of a vector
    sensor, with one coefficient per axis.

    If the satellite is assumed to hold an attitude, the vectors are those at the held attitude,
    because the smoothed attitude contains the pointing error that is part of the innovations.

    Parameters
    ----------
    index : int
        Index of the sensor in the suite.
    state : str
        "scale_factor" or "nonorthogonality".
    """

    def reading_changes(equations: Equations) -> Floats:
        batch, trajectory = equations.batch, equations.trajectory
        first = batch.suite.get_first_indices(batch.suite.sensors[index]).get("misalignment")
        attitude = trajectory.attitude if batch.pointing is None else batch.pointing.attitude
        body = np.einsum("nji,nj->ni", attitude, batch.vectors[:, index])
        mounting = (
            np.eye(3) if first is None else rotation_matrix(trajectory.states[0, first : first + 3])
        )
        columns: Floats = mounting @ _compute_vector_changes(state, body)
        return columns

    return ModelError(n_coefficients=3, reading_changes={index: reading_changes})


def build_offset_drift_error(solution: Solution, index: int) -> ModelError:
    """Build the score-test regressors for a sensor offset drift that is piecewise linear in time.
    Each axis has one coefficient for each of the `N_PARTS` equal parts of the data.

    A coefficient of one changes the offset by `LARGE_OFFSET` noise 1-sigmas within its part.

    Parameters
    ----------
    solution : Solution
    index : int
        Index of the sensor in the suite.
    """
    fractions = _compute_elapsed_fractions(solution)

    def reading_changes(equations: Equations) -> Floats:
        ramps = compute_ramps(fractions[equations.low : equations.high])
        result = ramps[:, None, :, None] * _compute_offset_columns(equations, index)[:, :, None]
        return result.reshape(len(ramps), 3, -1)

    return ModelError(n_coefficients=3 * N_PARTS, reading_changes={index: reading_changes})


def build_offset_channel_error(index: int, channel: Floats) -> ModelError:
    """Build the score-test regressors for a sensor offset proportional to a telemetry channel, with
    one coefficient per axis.

    Parameters
    ----------
    index : int
        Index of the sensor in the suite.
    channel : array, shape (N,)
        Channel value at each sample.
    """

    def reading_changes(equations: Equations) -> Floats:
        return channel[equations.low : equations.high, None, None] * _compute_offset_columns(
            equations, index
        )

    return ModelError(n_coefficients=3, reading_changes={index: reading_changes})


def build_misalignment_channel_error(index: int, channel: Floats) -> ModelError:
    """Build the score-test regressors for a sensor misalignment proportional to a telemetry
    channel, with one coefficient per axis.

    Parameters
    ----------
    index : int
        Index of the sensor in the suite.
    channel : array, shape (N,)
        Channel value at each sample.
    """

    def reading_changes(equations: Equations) -> Floats:
        by_attitude = -_select_jacobian(equations, index, 0)
        return LARGE_AXES_ERROR * channel[equations.low : equations.high, None, None] * by_attitude

    return ModelError(n_coefficients=3, reading_changes={index: reading_changes})


def compute_ramps(elapsed_fractions: Floats) -> Floats:
    """Evaluate `N_PARTS` ramp functions at the given times, as an array of shape (n, N_PARTS). Each
    ramp rises from zero to one within its part of the data.

    Parameters
    ----------
    elapsed_fractions : array, shape (n,)
        Elapsed time as a fraction of the duration of the data.
    """
    ramps: Floats = np.clip(N_PARTS * elapsed_fractions[:, None] - np.arange(N_PARTS), 0.0, 1.0)
    return ramps


def build_step_profile(part: int) -> Profile:
    """Return an offset profile that rises from zero to one within one part of the data.

    Parameters
    ----------
    part : int
        Index of one of the `N_PARTS` equal parts of the data.

    Returns
    -------
    Profile
    """
    return lambda fractions: compute_ramps(fractions)[:, [part]]


def compute_linear_profile(elapsed_fractions: Floats) -> Floats:
    """Evaluate an offset profile that grows linearly from zero at the start of the data to one at
    the end, as an array of shape (n, 1).

    Parameters
    ----------
    elapsed_fractions : array, shape (n,)
        Elapsed time as a fraction of the duration of the data.
    """
    return elapsed_fractions[:, None]


def compute_cosine_profiles(elapsed_fractions: Floats) -> Floats:
    """Evaluate cosine offset profiles with 1 to `N_HALF_WAVES` half waves, as columns of an array
    of shape (n, N_HALF_WAVES). All profiles start at zero.

    Parameters
    ----------
    elapsed_fractions : array, shape (n,)
        Elapsed time as a fraction of the duration of the data.
    """
    half_periods = np.arange(1, N_HALF_WAVES + 1)
    result: Floats = 0.5 - 0.5 * np.cos(np.pi * elapsed_fractions[:, None] * half_periods)
    return result


def build_profile_errors(
    drift_error: ModelError, profiles: Sequence[Profile]
) -> tuple[ModelErrorCombination, ...]:
    """Build the score-test regressors for offset profiles by combining the regressors of a
    piecewise linear drift.

    Parameters
    ----------
    drift_error : ModelError
        Model error with a coefficient for each part and axis, from `build_bias_drift_error` or
        `build_offset_drift_error`.
    profiles : sequence of Profile
        Functions from the fraction of elapsed time to offsets.

    Returns
    -------
    tuple of ModelErrorCombination
        In the order of the profiles.
    """
    part_ends = np.linspace(0.0, 1.0, N_PARTS + 1)
    return tuple(
        ModelErrorCombination(
            drift_error,
            np.asarray(np.kron(np.diff(profile(part_ends), axis=0), np.eye(3)), dtype=np.float64),
        )
        for profile in profiles
    )


def _compute_elapsed_fractions(solution: Solution) -> Floats:
    times = solution.batch.times
    fractions: Floats = (times - times[0]) / (times[-1] - times[0])
    return fractions


def _build_rate_error(
    rate_errors: Callable[[Equations], Floats],
    n_coefficients: int,
    last_bias_change: Floats | None = None,
) -> ModelError:
    """Build the score-test regressors for an additive error of the gyro rates.

    Parameters
    ----------
    rate_errors : function of Equations
        Rate error in each step for each of the coefficients, shape (n - 1, 3, k) [rad/s].
    n_coefficients : int
        Number k of coefficients.
    last_bias_change : array, shape (3, k), optional
        Change of the gyro bias at the last sample, if the rate error is a bias error.
    """

    def attitude_changes(equations: Equations) -> Floats:
        changes: Floats = _compute_rate_sensitivity(equations) @ rate_errors(equations)
        return changes

    return ModelError(
        n_coefficients=n_coefficients,
        attitude_changes=attitude_changes,
        last_bias_change=last_bias_change,
    )


def _compute_rate_sensitivity(equations: Equations) -> Floats:
    """Return the derivative of the attitude error with respect to the gyro rate error in each step
    [s], as an array of shape (n - 1, 3, 3).
    """
    partition, process = equations.partition, equations.process
    if (partition.stochastic == 3).any():
        first = int(np.flatnonzero(partition.stochastic == 3)[0])
        return process.F[:, :3, first : first + 3]
    first = int(np.flatnonzero(partition.constant == 3)[0])
    sensitivity: Floats = (
        process.G[:, :, first : first + 3] / process.constant_factors[:-1, None, first : first + 3]
    )
    return sensitivity


def _compute_vector_changes(state: str, vectors: Floats) -> Floats:
    """Return an array of shape (n, 3, 3) with the change of each vector due to a calibration
    parameter of `LARGE_AXES_ERROR` on each axis.
    """
    if state == "misalignment":
        columns: Floats = -np.moveaxis(skew(vectors.T), -1, 0)
    elif state == "nonorthogonality":
        columns = np.stack([shear(axis, vectors) for axis in np.eye(3)], axis=-1)
    else:
        by_axis = np.abs(vectors) if state == "scale_asymmetry" else vectors
        columns = by_axis[:, :, None] * np.eye(3)
    return LARGE_AXES_ERROR * columns


def _compute_vector_rate(solution: Solution, equations: Equations, index: int) -> Floats:
    all_samples, vectors = solution.batch, equations.batch.vectors.copy()
    low, high = max(0, equations.low - 1), min(len(all_samples.times), equations.high + 1)
    rate = np.gradient(all_samples.vectors[low:high, index], all_samples.times[low:high], axis=0)
    vectors[:, index] += rate[equations.low - low : equations.high - low]
    shifted_batch = dataclasses.replace(equations.batch, vectors=vectors)
    samples, z = compute_sensor_innovations(shifted_batch, index, equations.trajectory)
    change = np.zeros((len(vectors), 3))
    k = z.shape[1]
    change[samples, :k] = equations.measurements.z[index, samples, :k] - z
    return change


def _compute_offset_columns(equations: Equations, index: int) -> Floats:
    """Return the change of a sensor's readings due to an offset of `LARGE_OFFSET` noise 1-sigmas on
    each axis. The result has the shape (n, 3, 3): samples, reading components and offset axes.
    """
    suite = equations.batch.suite
    sensor = suite.sensors[index]
    first_indices = suite.get_first_indices(sensor)
    if (state := sensor.offset_state) in first_indices:
        columns = _select_jacobian(equations, index, first_indices[state])
    else:  # A misalignment rotates the readings opposite to an attitude error.
        columns = -_select_jacobian(equations, index, 0)
    offset: Floats = LARGE_OFFSET * float(np.max(sensor.noise_sigmas())) * columns
    return offset


def _select_jacobian(equations: Equations, index: int, first_state: int) -> Floats:
    measurements, partition = equations.measurements, equations.partition
    n_stochastic, n_constant = measurements.n_columns[index]
    state_columns = measurements.columns[index]
    states = np.concatenate(
        [
            partition.stochastic[state_columns[:n_stochastic]],
            partition.constant[state_columns[n_stochastic:]],
        ]
    )
    k = int(np.flatnonzero(states[: n_stochastic + n_constant] == first_state)[0])
    columns: Floats = measurements.H[index, :, :, k : k + 3]
    return columns
