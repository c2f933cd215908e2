"""Calibration of gyro and sensors from telemetry: fit, consistency tests and assembly of the
result.
"""

from __future__ import annotations

import dataclasses
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.quaternion import quaternions_from_matrices
from mgeo_attitude.geometry.rotation import rotation_matrix
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import scale_noise
from mgeo_attitude.settings.errors import InvalidValue

from mgeo_calibration.calibration import model_tests as models
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.consistency_tests import (
    MAX_OUTLIER_FRACTION,
    SIGNIFICANCE,
    count_prior_tests,
    describe_overestimated_errors,
    run_prior_tests,
    run_sensor_tests,
)
from mgeo_calibration.calibration.diagnosis import (
    EXPLANATORY_CHECKS,
    CalibrationError,
    list_data_faults,
    run_checks,
)
from mgeo_calibration.calibration.hypotheses import build_hypotheses, select_correlated_channels
from mgeo_calibration.estimation.batch import Batch, build_batch
from mgeo_calibration.estimation.fit import Fit, FitError, fit, fit_from_trajectory
from mgeo_calibration.estimation.kinematics import compute_rates_and_rotations, discretize_dynamics
from mgeo_calibration.estimation.model_errors import estimate_angle_random_walk
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.residuals import FilterEstimates, History, compute_filter_estimates
from mgeo_calibration.estimation.smoother import Solution, compute_last_covariance
from mgeo_calibration.estimation.step_noise import add_step_noise, list_states_without_step_noise
from mgeo_calibration.estimation.trajectory import split_into_spans
from mgeo_calibration.telemetry.gyro_samples import (
    compute_median_step,
    compute_rate_sigma,
    find_gyro_spikes,
    select_gyro_samples,
)
from mgeo_calibration.telemetry.mapping import TelemetryMapping
from mgeo_calibration.telemetry.quantization import MIN_VARIANCE_RATIO, is_quantization_relevant
from mgeo_calibration.telemetry.reading import read_telemetry
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Probability of rejecting a valid reading.
GATE_PROBABILITY = 1e-5
#: Factor of the gyro noise for a second attempt of a fit that does not converge.
_RETRY_NOISE_FACTOR = 10.0


def calibrate(
    scenario: Scenario,
    telemetry: Telemetry | pd.DataFrame | Path | str,
    mapping: TelemetryMapping | None = None,
    *,
    gate: float = GATE_PROBABILITY,
) -> Calibration:
    """Estimate the attitude and the calibration parameters of gyro and sensors from telemetry.

    The returned calibration includes tests of its statistical consistency.

    No prior attitude is needed. The initial 1-sigmas of the parameters, noise, orbit and eclipses
    come from the scenario; a scenario that continues a calibration provides its estimates as the
    prior. An iterated smoother estimates all samples at once, and a chi-square test rejects
    readings that contradict all other readings. Considered states keep their prior estimate and
    uncertainty.

    Parameters
    ----------
    scenario : Scenario
    telemetry : Telemetry, DataFrame or path
        See `read_telemetry`.
    mapping : TelemetryMapping, optional
        Conventions of a table or a file. Default: see `TelemetryMapping`.
    gate : float
        Probability of rejecting a valid reading.

    Returns
    -------
    Calibration

    Raises
    ------
    ValueError, OSError, ImportError
        From `read_telemetry`.
    CalibrationError
        (ValueError) If readings have another unit or belong to other sensors, if they do not
        determine the attitude, or if the fit does not converge.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import calibrate, simulate_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> telemetry = simulate_telemetry(scenario, design, seed=1)
    >>> calibrate(scenario, telemetry).is_consistent
    True
    """
    if not 0.0 < gate < 0.5:
        raise ValueError(f"gate = {gate!r}: expected a probability in (0, 0.5)")
    if mapping is not None and mapping.gyro.reference_axes == "unknown":
        raise InvalidValue(
            "gyro.reference_axes",
            "unknown",
            "expected 'lvlh', 'inertial' or no value. Use calibrate_magnetometers",
        )
    if not isinstance(telemetry, Telemetry):
        telemetry = read_telemetry(telemetry, scenario, mapping)
    data = None
    try:
        data = build_batch(scenario, telemetry)
        data, prior = add_step_noise(data, PriorEstimate.from_scenario(scenario, data.pointing))
        calibration = _build_calibration(scenario, telemetry, prior, fit(data, prior, gate))
    except FitError as error:
        assert data is not None
        calibration = _calibrate_without_fit(scenario, telemetry, data, prior, error)
    except ValueError as error:
        raise CalibrationError(str(error), run_checks(scenario, telemetry, data)) from error
    if calibration.is_consistent:
        return calibration
    checks = run_checks(scenario, telemetry, None)
    certain = {name: result for name, result in checks.items() if name in EXPLANATORY_CHECKS}
    return dataclasses.replace(calibration, data_faults=list_data_faults(certain))


def _calibrate_without_fit(
    scenario: Scenario, telemetry: Telemetry, data: Batch, prior: PriorEstimate, error: FitError
) -> Calibration:
    """Calibrate without outlier rejection after the regular fit has failed to converge.

    Raises
    ------
    CalibrationError
        With the gyro noise for which a fit is consistent, with the cause that a check found, or
        with the original error if the fit without outlier rejection fails, too.
    """
    walk = _estimate_gyro_walk(scenario, telemetry) if telemetry.has_gyro else None
    if walk is not None:
        sample = walk / (60.0 * np.sqrt(np.median(data.durations)))
        raise CalibrationError(
            f"gyro is noisier than declared, about {walk:.2g} deg/sqrt(h). Set "
            f"gyro.angle_random_walk_deg_per_sqrt_h, or gyro.sample_noise_deg_s = {sample:.2g}, in "
            f"the scenario. Message of the fit: {error}"
        )
    checks = run_checks(scenario, telemetry, data)
    if not list_data_faults(checks):
        with suppress(ValueError):
            return _build_calibration(scenario, telemetry, prior, fit(data, prior, 0.0))
    raise CalibrationError(str(error), checks) from error


def _estimate_gyro_walk(scenario: Scenario, telemetry: Telemetry) -> float | None:
    """Estimate the angle random walk [deg/sqrt(h)] of a gyro that is noisier than declared.

    Return None if a larger gyro noise does not make the fit consistent with the telemetry.
    """
    noisy = dataclasses.replace(scenario, gyro=scale_noise(scenario.gyro, _RETRY_NOISE_FACTOR))
    try:
        data, prior = add_step_noise(
            build_batch(noisy, telemetry), PriorEstimate.from_scenario(noisy)
        )
        result = fit(data, prior, GATE_PROBABILITY)
    except ValueError:
        return None
    if not _build_calibration(noisy, telemetry, prior, result).is_consistent:
        return None
    return float(60.0 * np.degrees(estimate_angle_random_walk(result.solution)))


def _build_calibration(
    scenario: Scenario, telemetry: Telemetry, prior: PriorEstimate, fit_result: Fit
) -> Calibration:
    data, n = fit_result.batch, len(fit_result.batch.times)
    last = fit_result.solution.estimate
    filter_results = compute_filter_estimates(fit_result.solution)
    states, covariance = compute_final_estimate(prior, fit_result)
    full_fit = _refit_all_readings(prior, fit_result)
    full_filter_results = (
        filter_results if full_fit is fit_result else compute_filter_estimates(full_fit.solution)
    )
    channels, left_out = select_correlated_channels(
        telemetry, data, full_filter_results.innovations
    )
    hypotheses = build_hypotheses(full_fit.solution, channels, telemetry.has_gyro)
    before = PriorEstimate.from_scenario(scenario, data.pointing)
    n_tests: float = count_prior_tests(before) + left_out * (1 + len(filter_results.innovations))
    n_tests += sum(each.weight for each in hypotheses.values())
    # The NIS test and the correlation test are one-sided. Together they count as one test.
    n_tests += sum(len(each.samples) > 0 for each in filter_results.innovations)
    tests = run_sensor_tests(fit_result, filter_results, n_tests)
    all_tests = (
        tests
        if full_fit is fit_result
        else run_sensor_tests(full_fit, full_filter_results, n_tests)
    )
    variance_ratio = models.compute_variance_ratio(all_tests)
    model_tests, doubts = models.run_model_tests(
        full_fit.solution, hypotheses, n_tests, variance_ratio
    )
    return Calibration(
        scenario=scenario,
        time=float(data.times[-1]),
        quaternion=quaternions_from_matrices(last.attitude[-1:].swapaxes(1, 2))[0],
        rate_deg_s=np.degrees(
            compute_rates_and_rotations(data.select_samples(n - 2, n), last.states[-2:])[0][-1]
        ),
        states=states,
        covariance=covariance,
        tests=tests,
        outliers=_list_outliers(fit_result),
        prior_tests=run_prior_tests(
            before,
            last.attitude[0],
            last.states[0, list_states_without_step_noise(data.suite)],
            SIGNIFICANCE / n_tests,
        ),
        model_tests=model_tests,
        notes=(
            *_describe_readings(telemetry, data),
            *(note for test in tests for note in test.describe_excess_noise()),
            *describe_overestimated_errors(fit_result.solution, tests),
            *doubts,
        ),
        history=_build_history(fit_result, filter_results),
    )


def _refit_all_readings(prior: PriorEstimate, fit_result: Fit) -> Fit:
    """Repeat a fit without outlier rejection if it rejected too many readings of a sensor.

    Return the given fit if no sensor has too many outliers, or if the new fit does not converge.
    """
    counts = fit_result.solution.is_used.sum(axis=1) + fit_result.is_rejected.sum(axis=1)
    if not (fit_result.is_rejected.sum(axis=1) > MAX_OUTLIER_FRACTION * counts).any():
        return fit_result
    full_fit = fit_from_trajectory(fit_result.batch, prior, fit_result.solution.estimate, 0.0)
    return full_fit if full_fit.solution.is_converged() else fit_result


def compute_final_estimate(prior: PriorEstimate, fit_result: Fit) -> tuple[Floats, Floats]:
    """Return the state estimate and its covariance matrix at the last sample.

    The estimates of considered states are replaced by their propagated prior.

    Parameters
    ----------
    prior : PriorEstimate
        Prior at the first sample.
    fit_result : Fit

    Returns
    -------
    states : array, shape (n_states,)
        Rotations are vectors of `rotation.rotate`; the attitude block is zero.
    covariance : array, shape (n_states, n_states)
    """
    solution, state_indices = (
        fit_result.solution,
        list_states_without_step_noise(fit_result.batch.suite),
    )
    states = solution.estimate.states[-1]
    states, covariance = reset_considered_states(
        prior, solution, states, compute_last_covariance(solution)
    )
    return states[state_indices], covariance[np.ix_(state_indices, state_indices)]


def reset_considered_states(
    prior: PriorEstimate, solution: Solution, states: Floats, covariance: Floats
) -> tuple[Floats, Floats]:
    """Replace the estimates of considered states with their prior, propagated to the last sample.

    The smoother weights all readings at once. Errors of the best estimate are independent of the
    readings, so that estimating the considered states does not degrade the other states or their
    correlations. A sequential filter would not have this property.

    Parameters
    ----------
    prior : PriorEstimate
        Prior at the first sample.
    solution : Solution
    states : array, shape (n_states,)
        States at the last sample, with the considered states estimated.
    covariance : array, shape (n_states, n_states)
        Covariance of these states.

    Returns
    -------
    states : array, shape (n_states,)
    covariance : array, shape (n_states, n_states)
    """
    c = prior.suite.considered_indices
    if not c.size:
        return states, covariance
    decay_factors, added_variances = _propagate_prior(prior, solution)
    states, covariance = states.copy(), covariance.copy()
    states[c] = decay_factors[c] * prior.states[c]
    sigma = decay_factors[c] * prior.sigma[c]
    covariance[np.ix_(c, c)] = sigma[:, None] * prior.correlation[np.ix_(c, c)] * sigma
    covariance[c, c] += added_variances[c]
    return states, covariance


def _propagate_prior(prior: PriorEstimate, solution: Solution) -> tuple[Floats, Floats]:
    """Compute how the prior of each state evolves until the last sample.

    Return two arrays with one element per state: the factor by which the prior decays, and the
    variance that process noise adds.
    """
    parts, batch = solution.partition, solution.batch
    decay_factors, added_variances = np.ones_like(prior.sigma), np.zeros_like(prior.sigma)
    decay_factors[parts.constant] = solution.constant_factors[-1]
    driven = parts.stochastic[3:]
    for low, high, _ in split_into_spans(len(batch.times)):
        span = batch.select_samples(low, high)
        durations, channel_values = (
            span.durations,
            span.select_channel_values(span.suite.gyro, slice(1, None)),
        )
        F, Q = discretize_dynamics(
            span.suite, np.zeros((len(durations), 3)), durations, channel_values
        )
        decay, new = (np.einsum("nii->ni", matrix)[:, driven] for matrix in (F, Q))
        # Decay from the start of each step to the end of the batch.
        decay_to_end = np.cumprod(decay[::-1], axis=0)[::-1]
        decay_after = np.vstack([decay_to_end[1:], np.ones_like(decay_to_end[:1])])
        decay_factors[driven] *= decay_to_end[0]
        added_variances[driven] = decay_to_end[0] ** 2 * added_variances[driven] + (
            decay_after**2 * new
        ).sum(axis=0)
    return decay_factors, added_variances


def _list_outliers(fit_result: Fit) -> tuple[tuple[float, str, float], ...]:
    outliers = [
        (float(fit_result.batch.times[k]), sensor.name, float(square[k]))
        for sensor, is_rejected_reading, square in zip(
            fit_result.batch.suite.sensors,
            fit_result.is_rejected,
            fit_result.residuals.normalized_squares,
            strict=True,
        )
        for k in np.flatnonzero(is_rejected_reading)
    ]
    return tuple(sorted(outliers))


def _describe_readings(telemetry: Telemetry, data: Batch) -> tuple[str, ...]:
    """Return notes on quantized readings and on isolated spikes of the gyro, one line each."""
    at, _ = select_gyro_samples(telemetry)
    sigma = compute_rate_sigma(data.suite, compute_median_step(at))
    quantization = {
        "gyro": (
            is_quantization_relevant(np.radians(telemetry.find_quantization_steps("gyro")), sigma),
            "deg/s",
        )
    }
    for sensor, noise in zip(data.suite.sensors, data.noise, strict=True):
        declared = sensor.noise_sigmas()
        is_noisier = noise[: len(declared)] ** 2 >= (1.0 + MIN_VARIANCE_RATIO) * np.square(declared)
        quantization[sensor.name] = is_noisier, sensor.telemetry_unit.text.removeprefix("-")
    notes = [
        f"{name} is quantized in steps of {step:.3g} {unit}".rstrip() + ", which add to its noise"
        for name, (is_relevant, unit) in quantization.items()
        if is_relevant.any()
        for step in [telemetry.find_quantization_steps(name).max()]
    ]
    sizes = np.degrees(np.abs(find_gyro_spikes(data.suite, telemetry)).max(axis=1))
    if sizes.any():
        notes.append(
            f"gyro: {np.count_nonzero(sizes)} of {len(at)} samples differ from both neighbors, by "
            f"{sizes.max():.3g} deg/s at {at[sizes.argmax()]:.6g} s. The mean of the neighbors "
            "replaces each of them, with the difference as its 1-sigma"
        )
    return tuple(notes)


def _build_history(fit_result: Fit, filter_results: FilterEstimates) -> History:
    attitude = fit_result.solution.estimate.attitude
    at_time = fit_result.solution.trajectory.attitude @ np.moveaxis(
        rotation_matrix(filter_results.errors.T), -1, 0
    )
    return History(
        times=fit_result.batch.times,
        smoothed_attitude=attitude.swapaxes(1, 2),
        smoothed_sigma=fit_result.residuals.sigma,
        filtered_attitude=at_time.swapaxes(1, 2),
        filtered_sigma=np.sqrt(np.einsum("nii->ni", filter_results.covariances)),
        innovations=filter_results.innovations,
    )
