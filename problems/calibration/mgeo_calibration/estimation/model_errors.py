"""Regressors of score tests for errors that the scenario does not model.

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
#: Number of half waves in the model of a slow drift.
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
    """Return the mean body rate of the smoothed attitude in each step, shape (N - 1, 3) [rad/s].

    If the declared gyro noise is too large, the smoothed attitude follows the noise of single
    readings. The rates are therefore filtered over as many steps as the motion allows (A. Savitzky,
    M. J. E. Golay, Analytical Chemistry 36 (1964) 1627-1639).
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
    """Return the angle random walk of the gyro relative to the smoothed attitude [rad/sqrt(s)]."""
    batch = solution.batch
    rates, _ = compute_rates_and_rotations(batch, solution.estimate.states)
    off = (rates - _compute_attitude_rates(solution))[~batch.breaks]
    return float(np.sqrt(np.mean(off**2 * batch.durations[~batch.breaks, None])))


def _compute_attitude_rates(solution: Solution) -> Floats:
    attitude, batch = solution.estimate.attitude, solution.batch
    turn = attitude[:-1].swapaxes(1, 2) @ attitude[1:]
    rates: Floats = Rotation.from_matrix(turn).as_rotvec() / batch.durations[:, None]
    rates[batch.breaks] = 0.0
    return rates


def build_bias_decay_error(solution: Solution) -> ModelError:
    """Return the regressors of a gyro bias with a different correlation time.

    A coefficient of one increases the inverse correlation time by one over the duration of the
    data.
    """
    times = solution.batch.times
    at, dt, bias = times - times[0], np.diff(times), solution.estimate.states[:-1, 3:6]
    left = np.exp(-solution.batch.suite.gyro.bias_decay * at)[:, None]
    more = np.cumsum(dt[:, None] * bias / left[:-1], axis=0) / at[-1]
    off = -left * np.vstack([np.zeros(3), more])
    return _build_rate_error(lambda own: off[own.low : own.high - 1, :, None], 1, off[-1:].T)


def build_bias_drift_error(solution: Solution) -> ModelError:
    """Return the regressors of a gyro bias that drifts.

    A coefficient of one changes the bias by its initial 1-sigma within one of the `N_PARTS` of the
    data.
    """
    share, size = _compute_elapsed_fractions(solution), solution.batch.suite.gyro.states()["bias"]

    def moves(own: Equations) -> Floats:
        rises = size * compute_ramps(share[own.low : own.high - 1])
        result: Floats = rises[:, None, :, None] * _compute_rate_sensitivity(own)[:, :, None]
        return result.reshape(len(rises), 3, -1)

    return ModelError(
        n_coefficients=3 * N_PARTS,
        attitude_changes=moves,
        last_bias_change=np.tile(size * np.eye(3), N_PARTS),
    )


def build_gyro_noise_error(solution: Solution) -> ModelError:
    """Return the regressors of sinusoidal gyro errors with `CYCLES` cycles about each axis.

    The amplitude equals the 1-sigma of the gyro noise in one step. The departure represents gyro
    noise that exceeds the declared noise.
    """
    batch = solution.batch
    density = np.sqrt(np.array(batch.suite.gyro.compute_noise_density()["theta"]))
    size, share = (
        density / np.sqrt(np.median(batch.durations)),
        _compute_elapsed_fractions(solution),
    )

    def off(own: Equations) -> Floats:
        phase = 2.0 * np.pi * share[own.low : own.high - 1, None] * np.array(CYCLES)
        waves = np.concatenate([np.sin(phase), np.cos(phase)], axis=1)
        result: Floats = waves[:, None, :, None] * np.diag(size)[:, None]
        return result.reshape(len(waves), 3, -1)

    return _build_rate_error(off, 6 * len(CYCLES))


def build_gyro_parameter_error(rates: Floats, state: str) -> ModelError:
    """Return the regressors of one calibration parameter of the gyro.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        Body rates from `compute_smoothed_rates` [rad/s].
    state : str
        "scale_factor", "misalignment", "nonorthogonality" or "scale_asymmetry".
    """
    return _build_rate_error(
        lambda own: _compute_vector_changes(state, rates[own.low : own.high - 1]), 3
    )


def build_gyro_time_tag_error(rates: Floats, durations: Floats) -> ModelError:
    """Return the regressors of a gyro that reports rates `LARGE_DELAY_S` ahead of its time stamps.

    Parameters
    ----------
    rates : array, shape (N - 1, 3)
        Body rates from `compute_smoothed_rates` [rad/s].
    durations : array, shape (N - 1,)
        Durations of the steps [s].
    """

    def changes(own: Equations) -> Floats:
        steps = np.arange(own.low, own.high - 1)
        change = rates[steps] - rates[np.maximum(steps - 1, 0)]
        result: Floats = LARGE_DELAY_S * change / durations[steps, None]
        return result[:, :, None]

    return _build_rate_error(changes, 1)


def build_gyro_channel_error(solution: Solution, channel: Floats) -> ModelError:
    """Return the regressors of a gyro bias that is proportional to a channel, shape (N,)."""
    size = solution.batch.suite.gyro.states()["bias"]
    return _build_rate_error(
        lambda own: size * channel[own.low : own.high - 1, None, None] * np.eye(3),
        3,
        size * channel[-1] * np.eye(3),
    )


def build_vector_rates(solution: Solution) -> VectorRates:
    """Return a cached `VectorRates` function of the solution."""
    sensors = len(solution.batch.suite.sensors)
    return lru_cache(maxsize=sensors)(partial(_compute_vector_rate, solution))


def build_latency_error(index: int, rates: Floats, vector_rates: VectorRates) -> ModelError:
    """Return the regressors of a sensor with readings that are `LARGE_DELAY_S` old.

    Parameters
    ----------
    index : int
        Index of the sensor in the suite.
    rates : array, shape (N - 1, 3)
        Body rates from `compute_smoothed_rates` [rad/s].
    vector_rates : VectorRates
        Function from `vector_rates`.
    """

    def reads(own: Equations) -> Floats:
        before = rates[np.maximum(np.arange(own.low, own.high) - 1, 0)]
        turned = np.einsum("nij,nj->ni", _select_jacobian(own, index, 0), before)
        result: Floats = -LARGE_DELAY_S * (turned + vector_rates(own, index))
        return result[:, :, None]

    return ModelError(n_coefficients=1, reading_changes={index: reads})


def build_along_track_error(n_sensors: int, vector_rates: VectorRates) -> ModelError:
    """Return the regressors of an orbit that lags by `LARGE_DELAY_S` along the track.

    Parameters
    ----------
    n_sensors : int
        Number of sensors in the suite.
    vector_rates : VectorRates
        Function from `vector_rates`.
    """

    def reads(index: int) -> Callable[[Equations], Floats]:
        return lambda own: -LARGE_DELAY_S * vector_rates(own, index)[:, :, None]

    return ModelError(
        n_coefficients=1, reading_changes={index: reads(index) for index in range(n_sensors)}
    )


def build_vector_error(index: int, state: str) -> ModelError:
    """Return the regressors of scale factors or non-orthogonality of a vector sensor.

    For a satellite that holds an attitude, the vectors are those at the held attitude, because the
    smoothed attitude contains the pointing error that is part of the innovations.
    """

    def reads(own: Equations) -> Floats:
        batch, at = own.batch, own.trajectory
        first = batch.suite.get_first_indices(batch.suite.sensors[index]).get("misalignment")
        attitude = at.attitude if batch.pointing is None else batch.pointing.attitude
        body = np.einsum("nji,nj->ni", attitude, batch.vectors[:, index])
        mounted = np.eye(3) if first is None else rotation_matrix(at.states[0, first : first + 3])
        columns: Floats = mounted @ _compute_vector_changes(state, body)
        return columns

    return ModelError(n_coefficients=3, reading_changes={index: reads})


def build_offset_drift_error(solution: Solution, index: int) -> ModelError:
    """Return the regressors of a sensor offset that drifts.

    A coefficient of one changes the offset by `LARGE_OFFSET` within one of the `N_PARTS` of the data.
    """
    share = _compute_elapsed_fractions(solution)

    def reads(own: Equations) -> Floats:
        rises = compute_ramps(share[own.low : own.high])
        result = rises[:, None, :, None] * _compute_offset_columns(own, index)[:, :, None]
        return result.reshape(len(rises), 3, -1)

    return ModelError(n_coefficients=3 * N_PARTS, reading_changes={index: reads})


def build_offset_channel_error(index: int, channel: Floats) -> ModelError:
    """Return the regressors of a sensor offset that is proportional to a channel, shape (N,)."""

    def reads(own: Equations) -> Floats:
        return channel[own.low : own.high, None, None] * _compute_offset_columns(own, index)

    return ModelError(n_coefficients=3, reading_changes={index: reads})


def build_misalignment_channel_error(index: int, channel: Floats) -> ModelError:
    """Return the regressors of a sensor misalignment proportional to a channel, shape (N,)."""

    def reads(own: Equations) -> Floats:
        by_attitude = -_select_jacobian(own, index, 0)
        return LARGE_AXES_ERROR * channel[own.low : own.high, None, None] * by_attitude

    return ModelError(n_coefficients=3, reading_changes={index: reads})


def compute_ramps(elapsed_fractions: Floats) -> Floats:
    """Return ramps from zero to one, one within each part of the data, shape (n, PARTS).

    Parameters
    ----------
    elapsed_fractions : array, shape (n,)
        Fraction of elapsed time.
    """
    rises: Floats = np.clip(N_PARTS * elapsed_fractions[:, None] - np.arange(N_PARTS), 0.0, 1.0)
    return rises


def build_step_profile(part: int) -> Profile:
    """Return the offset profile that rises from zero to one within one part of the data."""
    return lambda share: compute_ramps(share)[:, [part]]


def compute_linear_profile(elapsed_fractions: Floats) -> Floats:
    """Return the offset profile that is proportional to time, shape (n, 1)."""
    return elapsed_fractions[:, None]


def compute_cosine_profiles(elapsed_fractions: Floats) -> Floats:
    """Return cosine profiles of one to `N_HALF_WAVES` half waves that start at zero, shape (n, WAVES)."""
    half_periods = np.arange(1, N_HALF_WAVES + 1)
    result: Floats = 0.5 - 0.5 * np.cos(np.pi * elapsed_fractions[:, None] * half_periods)
    return result


def build_profile_errors(
    drift_error: ModelError, profiles: Sequence[Profile]
) -> tuple[ModelErrorCombination, ...]:
    """Return the regressors of each profile, piecewise linear over the parts of the data.

    Parameters
    ----------
    drift_error : Departure
        Departure with a coefficient for each part and axis, from `build_bias_drift_error` or `build_offset_drift_error`.
    profiles : sequence of Course
        Offset profiles.
    """
    ends = np.linspace(0.0, 1.0, N_PARTS + 1)
    return tuple(
        ModelErrorCombination(
            drift_error, np.asarray(np.kron(np.diff(of(ends), axis=0), np.eye(3)), dtype=np.float64)
        )
        for of in profiles
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
    """Return the regressors of a gyro with an additive rate error.

    Parameters
    ----------
    rate_errors : function of Equations
        Rate error in each step for each of the coefficients, shape (n - 1, 3, k) [rad/s].
    n_coefficients : int
        Number k of coefficients.
    last_bias_change : array, shape (3, k), optional
        Change of the gyro bias at the last sample, if the rate error is a bias error.
    """

    def moves(own: Equations) -> Floats:
        moved: Floats = _compute_rate_sensitivity(own) @ rate_errors(own)
        return moved

    return ModelError(
        n_coefficients=n_coefficients, attitude_changes=moves, last_bias_change=last_bias_change
    )


def _compute_rate_sensitivity(equations: Equations) -> Floats:
    """Return the attitude error per gyro rate error in each step, shape (n - 1, 3, 3) [s]."""
    parts, move = equations.partition, equations.process
    if (parts.stochastic == 3).any():
        first = int(np.flatnonzero(parts.stochastic == 3)[0])
        return move.F[:, :3, first : first + 3]
    first = int(np.flatnonzero(parts.constant == 3)[0])
    turned: Floats = (
        move.G[:, :, first : first + 3] / move.constant_factors[:-1, None, first : first + 3]
    )
    return turned


def _compute_vector_changes(state: str, vectors: Floats) -> Floats:
    """Return the change of vectors for each axis of a calibration parameter, shape (n, 3, 3).

    The parameter has the size `LARGE_AXES_ERROR`.
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
    whole, vectors = solution.batch, equations.batch.vectors.copy()
    low, high = max(0, equations.low - 1), min(len(whole.times), equations.high + 1)
    rate = np.gradient(whole.vectors[low:high, index], whole.times[low:high], axis=0)
    vectors[:, index] += rate[equations.low - low : equations.high - low]
    later = dataclasses.replace(equations.batch, vectors=vectors)
    samples, z = compute_sensor_innovations(later, index, equations.trajectory)
    change = np.zeros((len(vectors), 3))
    k = z.shape[1]
    change[samples, :k] = equations.measurements.z[index, samples, :k] - z
    return change


def _compute_offset_columns(equations: Equations, index: int) -> Floats:
    """Return the change of the readings by an offset on each axis, shape (n, 3, 3)."""
    suite = equations.batch.suite
    sensor = suite.sensors[index]
    places = suite.get_first_indices(sensor)
    if (state := sensor.offset_state) in places:
        columns = _select_jacobian(equations, index, places[state])
    else:  # A misalignment rotates the readings opposite to an attitude error.
        columns = -_select_jacobian(equations, index, 0)
    offset: Floats = LARGE_OFFSET * float(np.max(sensor.noise_sigmas())) * columns
    return offset


def _select_jacobian(equations: Equations, index: int, first_state: int) -> Floats:
    seen, parts = equations.measurements, equations.partition
    driven, constants = seen.n_columns[index]
    places = seen.columns[index]
    states = np.concatenate([parts.stochastic[places[:driven]], parts.constant[places[driven:]]])
    k = int(np.flatnonzero(states[: driven + constants] == first_state)[0])
    columns: Floats = seen.H[index, :, :, k : k + 3]
    return columns
