"""Flights to calibrate from, errors of calibrations, and ways to spoil telemetry."""

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
    """The scenario in less time, with three maneuvers."""
    window = Convergence(window=min(300.0, duration))
    changes = {"maneuvers": dataclasses.replace(scenario.maneuvers, count=3)} | changes
    return dataclasses.replace(scenario, duration=duration, convergence=window, **changes)


def options(asked):
    """All departures that questions are of, by name and number."""
    return {f"{name} {i}": each for name, of in asked.items() for i, each in enumerate(of.options)}


def anywhere(scenario):
    """The scenario's satellite, pointing anywhere at the start."""
    return dataclasses.replace(
        scenario, initial=dataclasses.replace(scenario.initial, attitude_deg=90.0)
    )


def flown(scenario, seed, environment=None, plan=PLAN):
    """Telemetry of a flight that starts anywhere."""
    return simulate_telemetry(
        scenario, plan, seed, truth=anywhere(scenario), environment=environment
    )


def error(calibration, telemetry):
    """Truth less estimate at the last sample, of rotations the vector that remains."""
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


def normalized(calibration, telemetry):
    """NEES per state, and the error of every state over its 1-sigma."""
    e, P = error(calibration, telemetry), calibration.covariance
    return e @ np.linalg.solve(P, e) / len(e), e / np.sqrt(np.diag(P))


def check_claimed(found, chance=0.99, worst=4.0):
    """Assert that errors are as large as is claimed, of `normalize_covariance` ones.

    NEES per state in the mean within what has this probability, and none of so many 1-sigmas.
    """
    nees, x = zip(*found, strict=True)
    n = np.size(x)
    low, high = chi2.ppf([0.5 - 0.5 * chance, 0.5 + 0.5 * chance], n) / n
    assert low < np.mean(nees) < high
    assert np.abs(x).max() < worst


def check_fifty_flights(scenario, seed, plan=PLAN):
    """NEES and NIS of a filter in 50 flights, and NEES of calibrations of four, within 99 %."""
    report = evaluate_consistency(simulate(scenario, plan, 50, seed=seed))
    tested = report[report.index.str.startswith(("nees", "nis"))]
    assert len(tested) >= len(scenario.sensors)  # of faces one may stay dark
    assert tested["passed"].all(), report
    environment, found = Environment.from_scenario(scenario), []
    for number in range(4):
        flight = simulate_telemetry(scenario, plan, number, environment=environment)
        found.append(normalized(calibrate(scenario, flight), flight))
    check_claimed(found, worst=np.inf)


def thinned(telemetry, name, every):
    """With every so many samples of a sensor alone."""
    rows = telemetry.sensors[name].copy()
    rows[np.arange(len(rows)) % every != 0] = np.nan
    return dataclasses.replace(telemetry, sensors={**telemetry.sensors, name: rows})


def with_holes(telemetry, share, rng):
    """Without this share of all samples, of gyro and sensors independently."""

    def holed(rows):
        return np.where(rng.random(len(rows))[:, None] < share, np.nan, rows)

    return dataclasses.replace(
        telemetry,
        gyro_deg_s=holed(telemetry.gyro_deg_s),
        sensors={name: holed(rows) for name, rows in telemetry.sensors.items()},
    )


def with_outliers(telemetry, share, rng):
    """With this share of the sensors' vectors turned anywhere; and how many of each."""
    sensors, counts = {}, {}
    for name, rows in telemetry.sensors.items():
        wrong = (rng.random(len(rows)) < share) & np.isfinite(rows[:, 0])
        turned = rows.copy()
        turned[wrong] = Rotation.random(wrong.sum(), rng=rng).apply(rows[wrong])
        sensors[name], counts[name] = turned, int(wrong.sum())
    return dataclasses.replace(telemetry, sensors=sensors), counts
