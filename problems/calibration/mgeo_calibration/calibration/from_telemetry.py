"""Calibration of a scenario from telemetry."""

from __future__ import annotations

import dataclasses
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.quaternion import quaternions
from mgeo_attitude.geometry.rotation import matrix
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import with_noise
from mgeo_attitude.settings.errors import InvalidValue

from mgeo_calibration.calibration import model_tests as models
from mgeo_calibration.calibration.agreement import (
    MOST_REJECTED,
    SIGNIFICANCE,
    caution_notes,
    number_of_tests,
    prior_tests,
    sensor_tests,
)
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.diagnosis import (
    BEFORE_TESTS,
    CannotCalibrate,
    causes,
    check,
)
from mgeo_calibration.calibration.hypotheses import channels_of, hypotheses
from mgeo_calibration.estimation.batch import Batch, batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.departures import gyro_walk
from mgeo_calibration.estimation.fit import Fit, NoFit, fit, settle
from mgeo_calibration.estimation.kinematics import discretized, turns
from mgeo_calibration.estimation.residuals import Filtered, History, filtered
from mgeo_calibration.estimation.smoother import Solution, last_covariance
from mgeo_calibration.estimation.step_noise import for_delays, without_step_noise
from mgeo_calibration.estimation.trajectory import spans
from mgeo_calibration.telemetry.gyro_samples import (
    gyro_noise,
    gyro_spikes,
    reported,
    usual_step,
)
from mgeo_calibration.telemetry.mapping import TelemetryMapping
from mgeo_calibration.telemetry.quantization import LEAST, matters
from mgeo_calibration.telemetry.reading import read_telemetry
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Probability of rejecting a valid reading.
GATE = 1e-5
#: Factor of the gyro noise for a second attempt of a fit that does not converge.
_NOISIER = 10.0


def calibrate(
    scenario: Scenario,
    telemetry: Telemetry | pd.DataFrame | Path | str,
    mapping: TelemetryMapping | None = None,
    *,
    gate: float = GATE,
) -> Calibration:
    """Estimate attitude, gyro bias and sensor calibration parameters from telemetry.

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
        Interpretation of the columns of a table or a file.
    gate : float
        Probability of rejecting a valid reading.

    Returns
    -------
    Calibration

    Raises
    ------
    ValueError, OSError, ImportError
        From `read_telemetry`.
    CannotCalibrate
        (ValueError) If readings have another unit or belong to other sensors, if they do not
        determine the attitude, or if the fit does not converge.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import calibrate, fly
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> calibrate(scenario, fly(scenario, design, seed=1)).supported
    True
    """
    if not 0.0 < gate < 0.5:
        raise ValueError(f"gate = {gate!r}: expected a probability in (0, 0.5)")
    if mapping is not None and mapping.gyro.holds == "unknown":
        raise InvalidValue("gyro.holds", "unknown", "expected none, or that of calibrate_alone")
    if not isinstance(telemetry, Telemetry):
        telemetry = read_telemetry(telemetry, scenario, mapping)
    data = None
    try:
        data = batch(scenario, telemetry)
        data, belief = for_delays(data, Belief.of(scenario, data.held))
        calibration = _build_calibration(scenario, telemetry, belief, fit(data, belief, gate))
    except NoFit as error:
        assert data is not None
        calibration = _calibrate_without_fit(scenario, telemetry, data, belief, error)
    except ValueError as error:
        raise CannotCalibrate(str(error), check(scenario, telemetry, data)) from error
    if calibration.supported:
        return calibration
    checks = check(scenario, telemetry, None)
    certain = {name: result for name, result in checks.items() if name in BEFORE_TESTS}
    return dataclasses.replace(calibration, causes=causes(certain))


def _calibrate_without_fit(
    scenario: Scenario, telemetry: Telemetry, data: Batch, belief: Belief, error: NoFit
) -> Calibration:
    """Return an inconsistent calibration from all readings if no check finds a cause.

    Raises
    ------
    CannotCalibrate
        With the gyro noise of a consistent fit, or with the cause that a check found.
    """
    walk = _estimate_gyro_walk(scenario, telemetry) if telemetry.has_gyro else None
    if walk is not None:
        sample = walk / (60.0 * np.sqrt(np.median(data.durations)))
        raise CannotCalibrate(
            f"gyro is noisier than declared, about {walk:.2g} deg/sqrt(h): declare "
            f"gyro.angle_random_walk_deg_per_sqrt_h, or gyro.sample_noise_deg_s = {sample:.2g} "
            f"({error})"
        )
    checks = check(scenario, telemetry, data)
    if not causes(checks):
        with suppress(ValueError):
            return _build_calibration(scenario, telemetry, belief, fit(data, belief, 0.0))
    raise CannotCalibrate(str(error), checks) from error


def _estimate_gyro_walk(scenario: Scenario, telemetry: Telemetry) -> float | None:
    """Return an angle random walk [deg/sqrt(h)] that makes telemetry consistent, or None."""
    noisy = dataclasses.replace(scenario, gyro=with_noise(scenario.gyro, _NOISIER))
    try:
        data, belief = for_delays(batch(noisy, telemetry), Belief.of(noisy))
        result = fit(data, belief, GATE)
    except ValueError:
        return None
    if not _build_calibration(noisy, telemetry, belief, result).supported:
        return None
    return float(60.0 * np.degrees(gyro_walk(result.solution)))


def _build_calibration(
    scenario: Scenario, telemetry: Telemetry, belief: Belief, found: Fit
) -> Calibration:
    data, n = found.batch, len(found.batch.times)
    last = found.solution.estimate
    past = filtered(found.solution)
    states, covariance = at_the_end(belief, found)
    whole = _refit_all_readings(belief, found)
    all_past = past if whole is found else filtered(whole.solution)
    channels, left_out = channels_of(telemetry, data, all_past.innovations)
    tested = hypotheses(whole.solution, channels, telemetry.has_gyro)
    before = Belief.of(scenario, data.held)
    n_tests: float = number_of_tests(before) + left_out * (1 + len(past.innovations))
    n_tests += sum(each.weight for each in tested.values())
    # The tests of NIS and correlation are one-sided: together they count as one test.
    n_tests += sum(len(each.samples) > 0 for each in past.innovations)
    tests = sensor_tests(found, past, n_tests)
    all_tests = tests if whole is found else sensor_tests(whole, all_past, n_tests)
    scatter = models.scatter_of(all_tests)
    model_tests, doubts = models.model_tests(whole.solution, tested, n_tests, scatter)
    return Calibration(
        scenario=scenario,
        time=float(data.times[-1]),
        quaternion=quaternions(last.attitude[-1:].swapaxes(1, 2))[0],
        rate_deg_s=np.degrees(turns(data.part(n - 2, n), last.states[-2:])[0][-1]),
        states=states,
        covariance=covariance,
        tests=tests,
        rejected=_list_rejected(found),
        prior_tests=prior_tests(
            before,
            last.attitude[0],
            last.states[0, without_step_noise(data.suite)],
            SIGNIFICANCE / n_tests,
        ),
        model_tests=model_tests,
        notes=(
            *_describe_readings(telemetry, data),
            *(note for test in tests for note in test.notes()),
            *caution_notes(found.solution, tests),
            *doubts,
        ),
        history=_build_history(found, past),
    )


def _refit_all_readings(belief: Belief, found: Fit) -> Fit:
    """Return a fit without outlier rejection if a sensor has too many outliers."""
    counts = found.solution.used.sum(axis=1) + found.rejected.sum(axis=1)
    if not (found.rejected.sum(axis=1) > MOST_REJECTED * counts).any():
        return found
    whole = settle(found.batch, belief, found.solution.estimate, 0.0)
    return whole if whole.solution.settled() else found


def at_the_end(belief: Belief, found: Fit) -> tuple[Floats, Floats]:
    """Return the states at the last sample, rotations as rotation vectors, and their covariance."""
    solution, own = found.solution, without_step_noise(found.batch.suite)
    states = solution.estimate.states[-1]
    states, covariance = as_believed(belief, solution, states, last_covariance(solution))
    return states[own], covariance[np.ix_(own, own)]


def as_believed(
    belief: Belief, solution: Solution, states: Floats, covariance: Floats
) -> tuple[Floats, Floats]:
    """Reset the considered states at the last sample to their prior.

    The smoother weights all readings at once. Errors of the best estimate are independent of the
    readings, so that estimating the considered states does not degrade the other states or their
    correlations. A sequential filter would not have this property.

    Parameters
    ----------
    belief : Belief
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
    c = belief.suite.considered
    if not c.size:
        return states, covariance
    left, added = _propagate_prior(belief, solution)
    states, covariance = states.copy(), covariance.copy()
    states[c] = left[c] * belief.states[c]
    sigma = left[c] * belief.sigma[c]
    covariance[np.ix_(c, c)] = sigma[:, None] * belief.correlation[np.ix_(c, c)] * sigma
    covariance[c, c] += added[c]
    return states, covariance


def _propagate_prior(belief: Belief, solution: Solution) -> tuple[Floats, Floats]:
    """Propagate the prior to the last sample: decay factor and added variance of each state."""
    parts, batch = solution.parts, solution.batch
    left, added = np.ones_like(belief.sigma), np.zeros_like(belief.sigma)
    left[parts.constant] = solution.growth[-1]
    driven = parts.driven[3:]
    for low, high, _ in spans(len(batch.times)):
        own = batch.part(low, high)
        durations, follows = own.durations, own.follows(own.suite.gyro, slice(1, None))
        F, Q = discretized(own.suite, np.zeros((len(durations), 3)), durations, follows)
        decay, new = (np.einsum("nii->ni", matrix)[:, driven] for matrix in (F, Q))
        later = np.cumprod(decay[::-1], axis=0)[::-1]  # from the start of each step to the end
        after = np.vstack([later[1:], np.ones_like(later[:1])])
        left[driven] *= later[0]
        added[driven] = later[0] ** 2 * added[driven] + (after**2 * new).sum(axis=0)
    return left, added


def _list_rejected(found: Fit) -> tuple[tuple[float, str, float], ...]:
    listed = [
        (float(found.batch.times[k]), sensor.name, float(square[k]))
        for sensor, no, square in zip(
            found.batch.suite.sensors, found.rejected, found.residuals.squares, strict=True
        )
        for k in np.flatnonzero(no)
    ]
    return tuple(sorted(listed))


def _describe_readings(telemetry: Telemetry, data: Batch) -> tuple[str, ...]:
    """Describe quantization that adds to the noise, and spikes of the gyro."""
    at, _ = reported(telemetry)
    sigma = gyro_noise(data.suite, usual_step(at))
    seen = {"gyro": (matters(np.radians(telemetry.step_of("gyro")), sigma), "deg/s")}
    for sensor, noise in zip(data.suite.sensors, data.noise, strict=True):
        believed = sensor.noise()
        more = noise[: len(believed)] ** 2 >= (1.0 + LEAST) * np.square(believed)
        seen[sensor.name] = more, sensor.channel_unit.text
    notes = [
        f"{name} counts in steps of {telemetry.step_of(name).max():.3g} {unit}".rstrip()
        + ", which are part of its noise"
        for name, (some, unit) in seen.items()
        if some.any()
    ]
    off = np.degrees(np.abs(gyro_spikes(data.suite, telemetry)).max(axis=1))
    if off.any():
        notes.append(
            f"gyro: {np.count_nonzero(off)} of {len(at)} samples stand apart from both neighbors, "
            f"by {off.max():.3g} deg/s at {at[off.argmax()]:.6f} s: taken half way between these, "
            "with that as 1-sigma"
        )
    return tuple(notes)


def _build_history(found: Fit, past: Filtered) -> History:
    attitude = found.solution.estimate.attitude
    at_time = found.solution.trajectory.attitude @ np.moveaxis(matrix(past.errors.T), -1, 0)
    return History(
        times=found.batch.times,
        smoothed=attitude.swapaxes(1, 2),
        smoothed_sigma=found.residuals.sigma,
        filtered=at_time.swapaxes(1, 2),
        filtered_sigma=np.sqrt(np.einsum("nii->ni", past.covariances)),
        innovations=past.innovations,
    )
