"""Fit of telemetry: any initial attitude, gaps, rates, outliers, and invalid telemetry."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.estimation.initial_attitude import estimate_initial_attitude
from mgeo_calibration.telemetry.gyro_samples import compute_step_rates
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from ...attitude.filter.suites import SUITES
from .runs import (
    add_outliers,
    check_errors,
    compute_error,
    normalize_error,
    short,
    simulate_from_any_attitude,
)


def test_missing_rates_are_interpolated_with_variance():
    """Values by hand: one sample per second, except at 4 and 5 s; an additional row at 3.25 s."""
    at = np.array([0.0, 1.0, 2.0, 3.0, 6.0, 7.0])
    rates = np.column_stack([[0.0, 1.0, 1.0, 1.0, 3.0, 3.0]] * 3)
    times = np.array([0.0, 1.0, 2.0, 3.0, 3.25, 6.0, 7.0, 7.5])
    gyro, change, variance, breaks = compute_step_rates(times, at, rates, 1.0)
    # From 3.25 to 6 s: the last second has the sample 3, the time before the mean, 2.
    np.testing.assert_allclose(gyro[:, 0], [1, 1, 1, 2, (1.75 * 2 + 1 * 3) / 2.75, 3, 3])
    # A rate error of 1 over two seconds rotates the attitude by 2: variance 4, in two parts.
    np.testing.assert_allclose(variance, [0, 0, 0, 0.25 * 2, 1.75 * 2, 0, 0])
    assert not breaks.any()
    assert not change[[3, 4, 6]].any()  # In gaps and after the last sample.
    at[4:] += 20.0
    times[5:] += 20.0
    assert np.flatnonzero(compute_step_rates(times, at, rates, 1.0)[3]).tolist() == [3, 4]


def test_initial_attitude_is_estimated_from_any_attitude(scenario):
    for seed in range(4):
        telemetry = simulate_from_any_attitude(scenario, seed)
        data = build_batch(scenario, telemetry)
        zero = np.zeros((len(data.times), data.suite.n_states))
        attitude, where = estimate_initial_attitude(data, zero)
        k = where.start
        row = int(np.searchsorted(telemetry.times, data.times[k]))
        turn = Rotation.from_matrix(telemetry.truth.attitude[row] @ attitude[k])
        # Biases of 1.1 (Sun) and 2.5 deg (field) and misalignments of 1 deg, 1-sigma per axis; an
        # angle between the vectors of 60 deg or less.
        assert np.degrees(turn.magnitude()) < 15.0


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    "name",
    [
        "two Sun sensors",
        "star tracker",
        "full gyro",
        "varying errors",
        "orbit error",
        "considered",
    ],
)
def test_suite_is_calibrated_within_sigma(name):
    suite = SUITES[name]
    of = dataclasses.replace(
        Scenario.paper(),
        gyro=suite.gyro,
        sensors=suite.sensors,
        environment_errors=suite.environment_errors,
    )
    of = short(of, 1500.0)
    telemetry = simulate_from_any_attitude(of, 7)
    found = calibrate(of, telemetry)
    check_errors([normalize_error(found, telemetry)], 0.998)


def test_gyro_outage_splits_batch(scenario, telemetry):
    gyro = telemetry.gyro_deg_s.copy()
    gyro[(telemetry.times > 300.0) & (telemetry.times < 520.0)] = (
        np.nan
    )  # The outage includes a change of rates.
    found = calibrate(scenario, dataclasses.replace(telemetry, gyro_deg_s=gyro))
    check_errors([normalize_error(found, telemetry)], 0.998)
    assert not ((found.history.times > 300.0) & (found.history.times < 520.0)).any()


def test_outliers_are_rejected_and_listed(scenario, telemetry):
    wrong, counts = add_outliers(telemetry, 0.01, np.random.default_rng(1))
    found = calibrate(scenario, wrong)
    clean = calibrate(scenario, telemetry)
    assert found.is_consistent
    for test in found.tests:
        # A rotation by few 1-sigmas of noise is no outlier.
        assert 0.8 * counts[test.sensor] <= test.n_outliers <= counts[test.sensor] + 1
    for time, sensor, square in found.outliers:
        k = int(np.searchsorted(telemetry.times, time))
        assert square > chi2.isf(1e-5, 3)
        changed = (wrong.sensors[sensor][k] != telemetry.sensors[sensor][k]).all()
        assert changed or (time, sensor) in [one[:2] for one in clean.outliers]
    sigma = np.sqrt(np.diag(clean.covariance))
    assert (
        np.abs((compute_error(found, telemetry) - compute_error(clean, telemetry)) / sigma).max()
        < 1.0
    )


def scale_columns(name, factor):
    """Return a function that scales the columns of a quantity in a table."""
    return lambda f: f.assign(**{c: factor * f[c] for c in f if c.startswith(name)})


LOST = "beyond the chi-square gate|does not converge"


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            scale_columns("mag", 1e-9),
            r"mag at .* 4.*e-05 nT \(median\), expected .*Declare unit = 'T' of mag",
        ),
        (scale_columns("mag", 1e-3), r"mag at .* Declare unit = 'uT' of mag"),
        (
            scale_columns("sun", 57.3),
            r"sun at .* a length of 57 .* about 1 -. Declare unit or scale of sun",
        ),
        (scale_columns("gyro", np.radians(1.0)), r"gyro at .*Declare gyro\.unit"),
        (lambda f: scale_columns("sun", np.nan)(f)[:100], "do not determine an attitude"),
        (scale_columns("mag_x", -1.0), LOST),
        (scale_columns("gyro", -1.0), LOST),
    ],
)
def test_invalid_telemetry_raises(scenario, telemetry, change, message):
    with pytest.raises(ValueError, match=message) as caught:
        calibrate(scenario, change(telemetry.to_frame()))
    assert "\n" not in str(caught.value)


def test_divergence_message_states_diverged_estimate(scenario, telemetry):
    report = (
        r"the fit does not converge: \S+ [xyz] is \S+ \S+, \S+ initial 1-sigmas of \S+ \S+ "
        r"from its prior; the last iteration rotates the attitude by \S+ deg at \d+ s"
    )
    with pytest.raises(ValueError, match=report):
        calibrate(scenario, scale_columns("gyro", -1.0)(telemetry.to_frame()))
