"""From telemetry to a calibration."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.geometry import matrix, quaternions
from mgeo_attitude.scenario import Scenario

from mgeo_calibration import diagnosis
from mgeo_calibration.calibration import model_tests as models
from mgeo_calibration.calibration.agreement import (
    MOST_REJECTED,
    SIGNIFICANCE,
    SensorTest,
    correlation_bound,
    greatest_correlation,
    nis_bounds,
    number_of_tests,
    prior_tests,
)
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.corrections import unit_of_innovations
from mgeo_calibration.calibration.questions import channels_of, questions
from mgeo_calibration.calibration.refused import CannotCalibrate, of_a_wide_fit
from mgeo_calibration.estimation import memory
from mgeo_calibration.estimation.batch import Batch, batch, gyro_noise, gyro_spikes, usual_step
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.considered import as_believed
from mgeo_calibration.estimation.fit import Fit, fit
from mgeo_calibration.estimation.kinematics import turns
from mgeo_calibration.estimation.linearization import misfits
from mgeo_calibration.estimation.residuals import Filtered, History, filtered
from mgeo_calibration.estimation.smoother import last_covariance
from mgeo_calibration.estimation.step_noise import for_delays, with_step_noise, without_step_noise
from mgeo_calibration.estimation.trajectory import Trajectory
from mgeo_calibration.telemetry import Telemetry, TelemetryMapping, read_telemetry
from mgeo_calibration.telemetry.quantization import LEAST, matters

#: Probability that a reading without fault is taken for an outlier.
GATE = 1e-5


def calibrate(
    scenario: Scenario,
    telemetry: Telemetry | pd.DataFrame | Path | str,
    mapping: TelemetryMapping | None = None,
    *,
    gate: float = GATE,
) -> Calibration:
    """Estimate attitude, gyro and sensor errors from telemetry.

    Nothing has to be known of the attitude. The errors' initial 1-sigmas are the scenario's, as are
    noise, orbit and eclipses; if the scenario goes on from a calibration, so does this. All samples
    are estimated at once, by a smoother that is iterated until it settles; a reading that all
    others contradict, by a chi-square test, is left out. States that are only considered stay what
    was believed of them, and as uncertain.

    Parameters
    ----------
    telemetry : Telemetry, DataFrame or path
        See `read_telemetry`.
    mapping : TelemetryMapping, optional
        How a table or a file is to be read.
    gate : float
        Probability that a reading without fault is left out.

    Returns
    -------
    Calibration

    Raises
    ------
    ValueError, OSError, ImportError
        From `read_telemetry`; or, as `CannotCalibrate`, for readings of another unit or of other
        sensors, an attitude that does not follow from them, more outliers than not, or an estimate
        that does not settle.

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
    memory.told(with_step_noise(scenario.suite, scenario.step), len(telemetry.times))
    belief, data = Belief.of(scenario), None
    try:
        data, belief = for_delays(batch(scenario, telemetry), belief)
        found = fit(data, belief, gate)
    except ValueError as error:
        checks = diagnosis.checks(scenario, telemetry, data)
        raise CannotCalibrate.of(str(error), checks, data, belief, gate, telemetry) from error
    made = _concluded(scenario, telemetry, belief, found)
    if made.supported:
        return made
    if _left_out(made) and not any(test.named for test in made.model_tests):
        # what is left does not show it
        wide = of_a_wide_fit(data, belief, gate, telemetry)[1]
        if any(test.named for test in wide):
            made = dataclasses.replace(made, model_tests=wide)
    return dataclasses.replace(made, causes=diagnosis.causes(scenario, telemetry, data))


def _left_out(made: Calibration) -> bool:
    """Whether a sensor has more outliers than chance and a few faults leave."""
    return any(test.rejected > MOST_REJECTED * test.readings for test in made.tests)


def _concluded(scenario: Scenario, telemetry: Telemetry, belief: Belief, found: Fit) -> Calibration:
    """What a fit says, and the tests of it."""
    data, n = found.batch, len(found.batch.times)
    last = found.solution.estimate
    past = filtered(found.solution)
    states, covariance = at_the_end(belief, found)
    channels, left_out = channels_of(telemetry, data, past.innovations)
    asked = questions(found.solution, channels)
    before = Belief.of(scenario)
    n_tests = number_of_tests(before) + len(asked) + left_out * (1 + len(past.innovations))
    n_tests += 2 * sum(len(each.samples) > 0 for each in past.innovations)
    tests = _tests(found, past, n_tests)
    model_tests, doubts = models.model_tests(
        found.solution, asked, n_tests, models.scatter_of(tests)
    )
    return Calibration(
        scenario=scenario,
        time=float(data.times[-1]),
        quaternion=quaternions(last.attitude[-1:].swapaxes(1, 2))[0],
        rate_deg_s=np.degrees(turns(data.part(n - 2, n), last.states[-2:])[0][-1]),
        states=states,
        covariance=covariance,
        tests=tests,
        rejected=_rejected(found),
        prior_tests=prior_tests(
            before,
            last.attitude[0],
            last.states[0, without_step_noise(data.suite)],
            SIGNIFICANCE / n_tests,
        ),
        model_tests=model_tests,
        notes=(
            *_notes(telemetry, data),
            *(note for test in tests for note in test.notes()),
            *doubts,
        ),
        history=_history(found, past),
    )


def at_the_end(belief: Belief, found: Fit) -> tuple[Floats, Floats]:
    """States at the last sample, rotations as vectors, and their covariance."""
    solution, own = found.solution, without_step_noise(found.batch.suite)
    states = solution.estimate.states[-1]
    states, covariance = as_believed(belief, solution, states, last_covariance(solution))
    return states[own], covariance[np.ix_(own, own)]


def _rejected(found: Fit) -> tuple[tuple[float, str, float], ...]:
    listed = [
        (float(found.batch.times[k]), sensor.name, float(square[k]))
        for sensor, no, square in zip(
            found.batch.suite.sensors, found.rejected, found.chi_squares, strict=True
        )
        for k in np.flatnonzero(no)
    ]
    return tuple(sorted(listed))


def _notes(telemetry: Telemetry, data: Batch) -> tuple[str, ...]:
    """Of steps in which gyro and sensors count that noise does not hide, and of wild rates."""
    at = telemetry.times[np.isfinite(telemetry.gyro_deg_s[:, 0])]
    sigma = gyro_noise(data.suite, usual_step(at))
    seen = {"gyro": (matters(np.radians(telemetry.step_of("gyro")), sigma), "deg/s")}
    for sensor, noise in zip(data.suite.sensors, data.noise, strict=True):
        believed = sensor.noise()
        more = noise[: len(believed)] ** 2 >= (1.0 + LEAST) * np.square(believed)
        seen[sensor.name] = more, sensor.channel_unit.text
    told = [
        f"{name} counts in steps of {telemetry.step_of(name).max():.3g} {unit}".rstrip()
        + ", which are part of its noise"
        for name, (some, unit) in seen.items()
        if some.any()
    ]
    off = np.degrees(np.abs(gyro_spikes(data.suite, telemetry)).max(axis=1))
    if off.any():
        told.append(
            f"gyro: {np.count_nonzero(off)} of {len(at)} samples stand apart from both neighbors, "
            f"by {off.max():.3g} deg/s at {at[off.argmax()]:.6f} s: taken half way between these, "
            "with that as 1-sigma"
        )
    return tuple(told)


def _tests(found: Fit, past: Filtered, n_tests: int) -> tuple[SensorTest, ...]:
    """Of sensors that have reported."""
    suite, made = found.batch.suite, []
    at = found.solution.estimate
    aligned = Trajectory(at.attitude, np.zeros_like(at.states))
    for index, (sensor, each) in enumerate(zip(suite.sensors, past.innovations, strict=True)):
        if not len(each.samples):
            continue
        unit = unit_of_innovations(sensor)
        count, rejected = each.whitened.size, int(found.rejected[index].sum())
        low, high = nis_bounds(count, n_tests)
        before = misfits(found.batch, index, aligned)
        made.append(
            SensorTest(
                sensor=sensor.name,
                readings=len(each.samples) + rejected,
                rejected=rejected,
                nis=float((each.whitened**2).mean()),
                nis_low=low,
                nis_high=high,
                correlation=greatest_correlation(each),
                correlation_bound=correlation_bound(count, n_tests),
                unit=unit.text,
                noise=unit.factor * _rms(found.batch.noise[index, : before.shape[1]]),
                before=unit.factor * _rms(before[each.samples]),
                after=unit.factor * _rms(found.residuals.r[index, each.samples, : before.shape[1]]),
            )
        )
    return tuple(made)


def _history(found: Fit, past: Filtered) -> History:
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


def _rms(values: Floats) -> float:
    return float(np.sqrt((values * values).mean()))
