"""Calibration of magnetometers from the measured field strength, without an attitude."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.geometry.quaternion import quaternions_from_matrices
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.vector_sensors import Magnetometer

from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.consistency_tests import (
    SIGNIFICANCE,
    SensorTest,
    compute_correlation_bound,
    compute_max_autocorrelation,
    compute_nis_bounds,
    count_prior_tests,
    run_prior_tests,
)
from mgeo_calibration.estimation.batch import Batch, build_batch
from mgeo_calibration.estimation.field_strength import (
    BLOCKS,
    FieldStrengthFit,
    compute_response_matrix,
    fit_magnetometer,
)
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.residuals import Innovations
from mgeo_calibration.telemetry.mapping import TelemetryMapping
from mgeo_calibration.telemetry.reading import read_telemetry
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Note on the limits of the method in each calibration.
METHOD_NOTE = (
    "magnetometers are calibrated from the field strength alone: misalignments and varying errors "
    "keep their prior, and attitude and rate are those of [initial]"
)


def calibrate_magnetometers(
    scenario: Scenario,
    telemetry: Telemetry | pd.DataFrame | Path | str,
    mapping: TelemetryMapping | None = None,
) -> Calibration:
    """Calibrate each magnetometer from the measured field strength alone, without an attitude.

    The estimated errors are bias, scale factor and non-orthogonality.

    A scale factor or non-orthogonality is estimated only if the scenario contains its state. All
    other states, the attitude and the rate keep their prior, so that a scenario can continue from
    the result as from any calibration.

    Parameters
    ----------
    scenario : Scenario
    telemetry, mapping
        As in `calibrate`. A mapping with ``reference_axes = "unknown"`` under ``gyro`` needs no
        gyro.

    Returns
    -------
    Calibration
        Calibration without history.

    Raises
    ------
    ValueError, OSError, ImportError
        From `read_telemetry`; or if the scenario has no magnetometer, or the readings do not
        determine the parameters.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import calibrate_magnetometers, simulate_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> telemetry = simulate_telemetry(scenario, design, seed=1)
    >>> calibration = calibrate_magnetometers(scenario, telemetry)
    >>> calibration.compute_corrections()["mag"]["unit"], calibration.is_consistent
    ('nT', True)
    """
    if not isinstance(telemetry, Telemetry):
        telemetry = read_telemetry(telemetry, scenario, mapping)
    data, prior, suite = (
        build_batch(scenario, telemetry),
        PriorEstimate.from_scenario(scenario),
        scenario.suite,
    )
    magnetometers = [k for k, s in enumerate(suite.sensors) if isinstance(s, Magnetometer)]
    if not magnetometers:
        raise ValueError(
            "sensors: expected at least one magnetometer to calibrate by the field strength"
        )
    states = prior.states.copy()
    covariance = prior.sigma[:, None] * prior.correlation * prior.sigma
    n_tests = count_prior_tests(prior) + 2 * len(magnetometers)
    tests = []
    for index in magnetometers:
        sensor = suite.sensors[index]
        try:
            result = fit_magnetometer(data, index, prior)
        except ValueError as error:
            raise ValueError(f"{sensor.name}: {error}") from None
        first_indices = suite.get_first_indices(sensor)
        numbers = [i for i, block in enumerate(BLOCKS) if block in first_indices]
        state_indices = np.concatenate([first_indices[BLOCKS[i]] + np.arange(3) for i in numbers])
        fit_indices = np.concatenate([3 * i + np.arange(3) for i in numbers])
        states[state_indices] = result.parameters[fit_indices]
        covariance[state_indices], covariance[:, state_indices] = 0.0, 0.0
        covariance[np.ix_(state_indices, state_indices)] = result.covariance[
            np.ix_(fit_indices, fit_indices)
        ]
        tests.append(_test_residuals(data, index, result, n_tests))
    time = float(data.times[-1])
    last = Environment.from_times(
        scenario, data.times[-1:], telemetry.interpolate_positions(data.times[-1:])
    )
    covariance[:3], covariance[:, :3] = 0.0, 0.0
    covariance[:3, :3] = scenario.initial_attitude_covariance
    constant_prior = prior.reset_varying_states()
    return Calibration(
        scenario=scenario,
        time=time,
        quaternion=quaternions_from_matrices(scenario.compute_initial_attitude(last)[None])[0],
        rate_deg_s=np.degrees(scenario.compute_initial_rate(last)),
        states=states,
        covariance=covariance,
        tests=tuple(tests),
        outliers=(),
        prior_tests=run_prior_tests(constant_prior, np.eye(3), states, SIGNIFICANCE / n_tests),
        notes=(METHOD_NOTE, *(note for test in tests for note in test.describe_excess_noise())),
    )


def _test_residuals(data: Batch, index: int, fit: FieldStrengthFit, n_tests: int) -> SensorTest:
    sensor, residuals = data.suite.sensors[index], fit.residuals
    measured = data.readings[index][:, 0]
    is_measured = np.isfinite(measured[:, 0])
    strength = np.linalg.norm(data.vectors[is_measured, index], axis=1)
    unbiased = (measured[is_measured] - fit.parameters[:3]) @ np.linalg.inv(
        compute_response_matrix(fit.parameters)
    )

    def rms(values: Floats) -> float:
        return sensor.telemetry_unit.factor * float(np.sqrt((values**2).mean()))

    low, high = compute_nis_bounds(len(residuals), n_tests)
    return SensorTest(
        sensor=sensor.name,
        n_readings=int(is_measured.sum()),
        n_outliers=int(is_measured.sum()) - len(residuals),
        nis=float((residuals**2).mean()),
        nis_low=low,
        nis_high=high,
        correlation=compute_max_autocorrelation(
            Innovations(np.arange(len(residuals)), residuals[:, None])
        ),
        correlation_bound=compute_correlation_bound(len(residuals), n_tests),
        unit=sensor.telemetry_unit.text,
        rms_noise=rms(data.noise[index]),
        rms_before=rms(np.linalg.norm(measured[is_measured], axis=1) - strength),
        rms_after=rms(np.linalg.norm(unbiased, axis=1) - strength),
    )
