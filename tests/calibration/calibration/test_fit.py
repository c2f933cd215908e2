"""From telemetry to estimates: any attitude, gaps, rates, outliers; and what is refused."""

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
from .flights import (
    check_claimed,
    error,
    flown,
    normalized,
    short,
    with_outliers,
)


def test_steps_where_rates_are_missing():
    """By hand: one sample each second, but those of 4 and 5 s; another row at 3.25 s."""
    at = np.array([0.0, 1.0, 2.0, 3.0, 6.0, 7.0])
    rates = np.column_stack([[0.0, 1.0, 1.0, 1.0, 3.0, 3.0]] * 3)
    times = np.array([0.0, 1.0, 2.0, 3.0, 3.25, 6.0, 7.0, 7.5])
    gyro, change, variance, breaks = compute_step_rates(times, at, rates, 1.0)
    # from 3.25 to 6 s the sample of 6 s says 3 of the last second; before it half way, 2
    np.testing.assert_allclose(gyro[:, 0], [1, 1, 1, 2, (1.75 * 2 + 1 * 3) / 2.75, 3, 3])
    # a guess that is off by 1 for two seconds turns the attitude by 2: variance 4, in two parts
    np.testing.assert_allclose(variance, [0, 0, 0, 0.25 * 2, 1.75 * 2, 0, 0])
    assert not breaks.any()
    assert not change[[3, 4, 6]].any()  # of a guess, and beyond the last sample
    at[4:] += 20.0
    times[5:] += 20.0
    assert np.flatnonzero(compute_step_rates(times, at, rates, 1.0)[3]).tolist() == [3, 4]


def test_a_first_attitude_whatever_it_is(scenario):
    for seed in range(4):
        telemetry = flown(scenario, seed)
        data = build_batch(scenario, telemetry)
        zero = np.zeros((len(data.times), data.suite.n_states))
        attitude, where = estimate_initial_attitude(data, zero)
        k = where.start
        row = int(np.searchsorted(telemetry.times, data.times[k]))
        turn = Rotation.from_matrix(telemetry.truth.attitude[row] @ attitude[k])
        # biases of 1.1 (Sun) and 2.5 deg (field), misalignments of 1 deg, 1-sigma per axis; an
        # angle between the vectors of 60 deg and less
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
def test_any_suite(name):
    suite = SUITES[name]
    of = dataclasses.replace(
        Scenario.paper(),
        gyro=suite.gyro,
        sensors=suite.sensors,
        environment_errors=suite.environment_errors,
    )
    of = short(of, 1500.0)
    telemetry = flown(of, 7)
    found = calibrate(of, telemetry)
    check_claimed([normalized(found, telemetry)], 0.998)


def test_a_silent_gyro_parts_the_batch(scenario, telemetry):
    gyro = telemetry.gyro_deg_s.copy()
    gyro[(telemetry.times > 300.0) & (telemetry.times < 520.0)] = np.nan  # over a change of rates
    found = calibrate(scenario, dataclasses.replace(telemetry, gyro_deg_s=gyro))
    check_claimed([normalized(found, telemetry)], 0.998)
    assert not ((found.history.times > 300.0) & (found.history.times < 520.0)).any()


def test_outliers_are_found_and_listed(scenario, telemetry):
    wrong, counts = with_outliers(telemetry, 0.01, np.random.default_rng(1))
    found = calibrate(scenario, wrong)
    clean = calibrate(scenario, telemetry)
    assert found.is_consistent
    for test in found.tests:
        # a turn by less than a few 1-sigmas of noise is none
        assert 0.8 * counts[test.sensor] <= test.n_outliers <= counts[test.sensor] + 1
    for time, sensor, square in found.outliers:
        k = int(np.searchsorted(telemetry.times, time))
        assert square > chi2.isf(1e-5, 3)
        changed = (wrong.sensors[sensor][k] != telemetry.sensors[sensor][k]).all()
        assert changed or (time, sensor) in [one[:2] for one in clean.outliers]
    sigma = np.sqrt(np.diag(clean.covariance))
    assert np.abs((error(found, telemetry) - error(clean, telemetry)) / sigma).max() < 1.0


def scaled(name, factor):
    """A table in which the columns of a name are so many times as large."""
    return lambda f: f.assign(**{c: factor * f[c] for c in f if c.startswith(name)})


LOST = "beyond the chi-square gate|does not converge"


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            scaled("mag", 1e-9),
            r"mag at .* 4.*e-05 nT \(median\), expected .*declare unit = 'T' of mag",
        ),
        (scaled("mag", 1e-3), r"mag at .* declare unit = 'uT' of mag"),
        (
            scaled("sun", 57.3),
            r"sun at .* a length of 57 .* about 1 -; declare unit or scale of sun",
        ),
        (scaled("gyro", np.radians(1.0)), r"gyro at .*declare gyro\.unit"),
        (lambda f: scaled("sun", np.nan)(f)[:100], "do not determine an attitude"),
        (scaled("mag_x", -1.0), LOST),
        (scaled("gyro", -1.0), LOST),
    ],
)
def test_what_is_refused(scenario, telemetry, change, message):
    with pytest.raises(ValueError, match=message) as caught:
        calibrate(scenario, change(telemetry.to_frame()))
    assert "\n" not in str(caught.value)


def test_a_fit_that_does_not_converge_reports_what_diverged(scenario, telemetry):
    report = (
        r"the fit does not converge: \S+ [xyz] is \S+ \S+, \S+ prior sigmas of \S+ \S+ "
        r"from its prior; the last iteration rotates the attitude by \S+ deg at \d+ s"
    )
    with pytest.raises(ValueError, match=report):
        calibrate(scenario, scaled("gyro", -1.0)(telemetry.to_frame()))
