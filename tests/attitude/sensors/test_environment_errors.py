"""Environment model errors: shared states, uncertainties and effects on measurements."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    Environment,
    EnvironmentErrors,
    FilterModel,
    Gyro,
    Magnetometer,
    Scenario,
    StarTracker,
    Suite,
    SunSensor,
    evaluate,
    find_validity_violations,
)
from mgeo_attitude.environment.sun_moon import sun_position, visible_sun_fraction
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.scenario import Convergence
from mgeo_attitude.sensors.environment_errors import FIELD_UNIT_NT, POSITION_UNIT
from mgeo_attitude.settings.errors import InvalidValue

ERRORS = EnvironmentErrors(albedo=0.05, field_error_nt=150.0, orbit_error_m=(2000.0, 100.0, 300.0))
PLAN = np.array([[0.5, -0.3, 0.8, 80.0, -0.7, 0.9, 0.1, 60.0, 0.2, 0.4, -0.9, 500.0]])


def build_short_scenario(**changes):
    return dataclasses.replace(
        Scenario.paper(), duration=60.0, convergence=Convergence(window=60.0), **changes
    )


def test_affected_sensors_share_error_states():
    fine = SunSensor(name="fine", includes_albedo=False)
    suite = Suite(
        Gyro(),
        (SunSensor(), fine, Magnetometer(), Magnetometer(name="outer"), StarTracker()),
        ERRORS,
    )
    assert suite.blocks[2:5] == (
        "environment_errors.albedo",
        "environment_errors.field_error",
        "environment_errors.orbit_error",
    )
    v, gradient = np.array([0.3, -0.5, 0.8]), np.random.default_rng(1).standard_normal((3, 3))
    shared = slice(6, 15)
    sun, fine, mag, outer, tracker = (
        suite.measurement_matrix(
            sensor, v, auxiliary_vectors=gradient[: suite.count_auxiliary_vectors(sensor)]
        )
        for sensor in suite.sensors
    )
    zero = np.zeros((3, 3))
    np.testing.assert_array_equal(sun[:, shared], np.hstack([np.eye(3), zero, zero]))
    np.testing.assert_array_equal(mag[:, shared], np.hstack([zero, np.eye(3), gradient.T]))
    np.testing.assert_array_equal(outer[:, shared], mag[:, shared])
    assert not fine[:, shared].any()
    assert not tracker[:, shared].any()
    assert (
        outer[:, -9:-3] != mag[:, -9:-3]
    ).any()  # The constants of each magnetometer are separate states.


@pytest.mark.slow
def test_orbit_error_keeps_its_sigma_per_axis_without_measurements():
    scenario = build_short_scenario(environment_errors=ERRORS)
    model = FilterModel.from_scenario(scenario)
    without_measurements = dataclasses.replace(model, available=np.zeros_like(model.available))
    first = 3 * model.suite.blocks.index("environment_errors.orbit_error")
    variances = evaluate(without_measurements, PLAN, history=True).variances[0][
        :, first : first + 3
    ]
    expected = np.square([2.0, 0.1, 0.3])
    np.testing.assert_allclose(variances, np.tile(expected, (len(variances), 1)), rtol=1e-12)


def test_field_gradient_by_orbit_error_equals_difference_of_igrf():
    scenario = build_short_scenario(environment_errors=ERRORS)
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    rows = model.suite.find_auxiliary_rows(1)
    speed = np.linalg.norm(environment.velocity, axis=1)
    radial = environment.position / np.linalg.norm(environment.position, axis=1)[:, None]
    normal = np.cross(radial, environment.velocity / speed[:, None])
    for column, direction in zip(
        model.references[:, rows].swapaxes(0, 1),
        (environment.velocity / speed[:, None], normal, radial),
        strict=True,
    ):
        offset = 500.0 * direction
        displaced_field = Environment.from_times(
            scenario, environment.times, environment.position + offset
        ).field
        expected = (displaced_field - environment.field) / FIELD_UNIT_NT / (500.0 / POSITION_UNIT)
        scale = np.linalg.norm(expected, axis=1).max()
        np.testing.assert_allclose(column, expected, rtol=0, atol=1e-3 * scale)


def test_orbit_error_beyond_validity_of_field_gradient_is_reported():
    valid, invalid = (
        build_short_scenario(environment_errors=EnvironmentErrors(orbit_error_m=(m, 9.0, 9.0)))
        for m in (30_000.0, 31_000.0)
    )
    (line,) = find_validity_violations(invalid)
    assert line.startswith("environment_errors.orbit_error_m = 31000: ")
    assert find_validity_violations(valid) == ()


def test_sun_measurements_near_uncertain_eclipse_are_not_used():
    """An along-track error is a satellite that is earlier or later on its orbit."""
    errors = EnvironmentErrors(orbit_error_m=(40_000.0, 1.0, 1.0))
    scenario = dataclasses.replace(
        Scenario.cubesat_6u(), duration=4300.0, environment_errors=errors
    )
    nominal, used, without_eclipses = (
        FilterModel.from_scenario(each).available
        for each in (
            dataclasses.replace(scenario, environment_errors=EnvironmentErrors()),
            scenario,
            dataclasses.replace(scenario, eclipse=False),
        )
    )
    max_delay = 3.0 * 40_000.0 / np.linalg.norm(Environment.from_scenario(scenario).velocity[0])
    expected = nominal[:, 0].copy()
    for delay in (-max_delay, max_delay):
        times = np.clip(scenario.times + delay, 0.0, None)
        position, _ = scenario.orbit.propagate(scenario.epoch, times)
        sun = sun_position(compute_julian_dates(scenario.epoch, times))
        expected &= visible_sun_fraction(position, sun) >= 0.5
    # The two edges of the eclipse take 16 s each; one sample per edge may differ.
    assert 25 <= np.sum(nominal[:, 0] & ~expected) <= 40
    assert np.sum(expected != used[:, 0]) <= 2
    assert used[:, 1].all()
    assert without_eclipses.all()


@pytest.mark.slow
def test_albedo_changes_reference_vector_of_coarse_sun_sensor_only():
    paper = Scenario.paper()
    sensors = (SunSensor(), SunSensor(name="fine", includes_albedo=False))
    plain, with_albedo = (
        FilterModel.from_scenario(
            dataclasses.replace(paper, sensors=sensors, environment_errors=errors)
        )
        for errors in (EnvironmentErrors(), EnvironmentErrors(earth_albedo=0.3))
    )
    albedo = with_albedo.references - plain.references
    assert not albedo[:, 1].any()
    assert 0.01 < np.linalg.norm(albedo[:, 0], axis=1).max() < 0.3


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"orbit_error_m": (1.0, 0.0, 0.0)}, "orbit_error_m = .*expected three numbers > 0 m, or"),
        ({"orbit_error_axes": "body"}, "orbit_error_axes = 'body': expected one of 'orbital'"),
        ({"earth_albedo": 30.0}, r"earth_albedo = 30.0: expected a number >= 0 and <= 1"),
        ({"considered": ("albedo",)}, r"considered\[0\] = 'albedo': unknown state"),
    ],
)
def test_invalid_environment_errors_are_rejected(table, message):
    with pytest.raises(InvalidValue, match=message):
        EnvironmentErrors(**table)


def test_sensor_name_environment_errors_is_rejected():
    with pytest.raises(
        InvalidValue, match=r"sensors\[0\].name = 'environment_errors': expected another name"
    ):
        build_short_scenario(sensors=(Magnetometer(name="environment_errors"),))
