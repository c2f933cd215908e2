"""Simulated runs to calibrate from, errors of calibrations, and changes of telemetry."""

import dataclasses

import numpy as np
from mgeo_attitude import Environment
from mgeo_attitude.geometry.rotation import rotation_matrix, rotation_vector
from mgeo_attitude.scenario import Convergence
from mgeo_calibration import calibrate, evaluate_consistency, simulate, simulate_telemetry
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

PLAN = (0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0)


def short(scenario, duration, **changes):
    """Return a scenario with a shorter duration and three maneuvers."""
    window = Convergence(window=min(300.0, duration))
    changes = {"maneuvers": dataclasses.replace(scenario.maneuvers, count=3)} | changes
    return dataclasses.replace(scenario, duration=duration, convergence=window, **changes)


def list_model_errors(asked):
    """Return the model errors of all hypotheses, as a dict by name and number."""
    return {f"{name} {i}": each for name, of in asked.items() for i, each in enumerate(of.options)}


def with_any_attitude(scenario):
    """Return a scenario whose initial attitude error is so large that any attitude is possible."""
    return dataclasses.replace(
        scenario, initial=dataclasses.replace(scenario.initial, attitude_deg=90.0)
    )


def simulate_from_any_attitude(scenario, seed, environment=None, plan=PLAN):
    """Return the telemetry of a run with an arbitrary initial attitude."""
    return simulate_telemetry(
        scenario, plan, seed, truth=with_any_attitude(scenario), environment=environment
    )


def compute_error(calibration, telemetry):
    """Return the true minus the estimated states at the last sample; for rotations, the vector of
    the remaining rotation.
    """
    k = int(np.argmin(np.abs(telemetry.times - calibration.time)))
    e = telemetry.truth.states[k] - calibration.states
    for first in calibration.suite.rotation_indices[1:]:
        block = slice(first, first + 3)
        believed, true = (
            rotation_matrix(x[block]) for x in (calibration.states, telemetry.truth.states[k])
        )
        e[block] = rotation_vector(believed.T @ true)
    body_to_gcrs = Rotation.from_quat(calibration.quaternion).as_matrix()
    e[:3] = rotation_vector(body_to_gcrs.T @ telemetry.truth.attitude[k].T)
    return e


def normalize_error(calibration, telemetry):
    """Return the NEES per state, and the error of every state in units of its 1-sigma."""
    e, P = compute_error(calibration, telemetry), calibration.covariance
    return e @ np.linalg.solve(P, e) / len(e), e / np.sqrt(np.diag(P))


def check_errors(found, chance=0.99, worst=4.0):
    """Assert that the normalized errors of several calibrations agree with their covariances.

    The mean NEES per state lies within an interval of the probability `chance`, and no error
    exceeds `worst` 1-sigmas.
    """
    nees, x = zip(*found, strict=True)
    n = np.size(x)
    low, high = chi2.ppf([0.5 - 0.5 * chance, 0.5 + 0.5 * chance], n) / n
    assert low < np.mean(nees) < high
    assert np.abs(x).max() < worst


def check_fifty_runs(scenario, seed, plan=PLAN):
    """Assert that NEES and NIS of the filter in 50 runs, and the NEES of four calibrations, lie
    within 99 % intervals.
    """
    report = evaluate_consistency(simulate(scenario, plan, 50, seed=seed))
    tested = report[report.index.str.startswith(("nees", "nis"))]
    assert len(tested) >= len(scenario.sensors)  # A photodiode may stay dark.
    assert tested["passed"].all(), report
    environment, found = Environment.from_scenario(scenario), []
    for number in range(4):
        flight = simulate_telemetry(scenario, plan, number, environment=environment)
        found.append(normalize_error(calibrate(scenario, flight), flight))
    check_errors(found, worst=np.inf)


def thin_samples(telemetry, name, every):
    """Return telemetry with only every n-th sample of one sensor."""
    rows = telemetry.sensors[name].copy()
    rows[np.arange(len(rows)) % every != 0] = np.nan
    return dataclasses.replace(telemetry, sensors={**telemetry.sensors, name: rows})


def remove_samples(telemetry, share, rng):
    """Return telemetry without a random share of the samples of gyro and sensors."""

    def holed(rows):
        return np.where(rng.random(len(rows))[:, None] < share, np.nan, rows)

    return dataclasses.replace(
        telemetry,
        gyro_deg_s=holed(telemetry.gyro_deg_s),
        sensors={name: holed(rows) for name, rows in telemetry.sensors.items()},
    )


def add_outliers(telemetry, share, rng):
    """Return telemetry in which a share of the sensor vectors has a random direction, and the
    number of changed vectors per sensor.
    """
    sensors, counts = {}, {}
    for name, rows in telemetry.sensors.items():
        wrong = (rng.random(len(rows)) < share) & np.isfinite(rows[:, 0])
        turned = rows.copy()
        turned[wrong] = Rotation.random(wrong.sum(), rng=rng).apply(rows[wrong])
        sensors[name], counts[name] = turned, int(wrong.sum())
    return dataclasses.replace(telemetry, sensors=sensors), counts
