"""One state per source of error, whoever sees it; and what older files say of it."""

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

WORLD = EnvironmentErrors(albedo=0.05, field_error_nt=150.0, orbit_error_m=(2000.0, 100.0, 300.0))
PLAN = np.array([[0.5, -0.3, 0.8, 80.0, -0.7, 0.9, 0.1, 60.0, 0.2, 0.4, -0.9, 500.0]])


def short(**changes):
    return dataclasses.replace(
        Scenario.paper(), duration=60.0, convergence=Convergence(window=60.0), **changes
    )


def test_all_sensors_that_see_an_error_see_the_same_states():
    fine = SunSensor(name="fine", includes_albedo=False)
    suite = Suite(
        Gyro(),
        (SunSensor(), fine, Magnetometer(), Magnetometer(name="outer"), StarTracker()),
        WORLD,
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
            sensor, v, gradient=gradient[: suite.count_gradient_vectors(sensor)]
        )
        for sensor in suite.sensors
    )
    none = np.zeros((3, 3))
    np.testing.assert_array_equal(sun[:, shared], np.hstack([np.eye(3), none, none]))
    np.testing.assert_array_equal(mag[:, shared], np.hstack([none, np.eye(3), gradient.T]))
    np.testing.assert_array_equal(outer[:, shared], mag[:, shared])
    assert not fine[:, shared].any()
    assert not tracker[:, shared].any()
    assert (outer[:, -9:-3] != mag[:, -9:-3]).any()  # its own constants are its own


@pytest.mark.slow
def test_sigmas_differ_by_axis_and_stay_what_they_are():
    scenario = short(environment_errors=WORLD)
    model = FilterModel.from_scenario(scenario)
    blind = dataclasses.replace(model, available=np.zeros_like(model.available))
    first = 3 * model.suite.blocks.index("environment_errors.orbit_error")
    variances = evaluate(blind, PLAN, history=True).variances[0][:, first : first + 3]
    expected = np.square([2.0, 0.1, 0.3])
    np.testing.assert_allclose(variances, np.tile(expected, (len(variances), 1)), rtol=1e-12)


def test_an_error_along_track_moves_the_field_as_it_is_farther_along():
    """Against IGRF where the satellite is seconds later."""
    scenario = short(environment_errors=WORLD)
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    rows = model.suite.gradient_rows(1)
    speed = np.linalg.norm(environment.velocity, axis=1)
    radial = environment.position / np.linalg.norm(environment.position, axis=1)[:, None]
    normal = np.cross(radial, environment.velocity / speed[:, None])
    for column, direction in zip(
        model.references[:, rows].swapaxes(0, 1),
        (environment.velocity / speed[:, None], normal, radial),
        strict=True,
    ):
        off = 500.0 * direction
        there = Environment.from_times(
            scenario, environment.times, environment.position + off
        ).field
        expected = (there - environment.field) / FIELD_UNIT_NT / (500.0 / POSITION_UNIT)
        size = np.linalg.norm(expected, axis=1).max()
        np.testing.assert_allclose(column, expected, rtol=0, atol=1e-3 * size)


def test_an_orbit_error_for_which_the_gradient_is_too_rough_is_told():
    near, far = (
        short(environment_errors=EnvironmentErrors(orbit_error_m=(m, 9.0, 9.0)))
        for m in (30_000.0, 31_000.0)
    )
    (line,) = find_validity_violations(far)
    assert line.startswith("environment_errors.orbit_error_m = 31000: ")
    assert find_validity_violations(near) == ()


def test_near_an_eclipse_that_may_be_elsewhere_nothing_that_sees_the_sun_is_used():
    """An error along track is a satellite that comes earlier or later; by the disc that is lit."""
    off = EnvironmentErrors(orbit_error_m=(40_000.0, 1.0, 1.0))
    scenario = dataclasses.replace(Scenario.cubesat_6u(), duration=4300.0, environment_errors=off)
    lit, used, always = (
        FilterModel.from_scenario(each).available
        for each in (
            dataclasses.replace(scenario, environment_errors=EnvironmentErrors()),
            scenario,
            dataclasses.replace(scenario, eclipse=False),
        )
    )
    late = 3.0 * 40_000.0 / np.linalg.norm(Environment.from_scenario(scenario).velocity[0])
    expected = lit[:, 0].copy()
    for delay in (-late, late):
        times = np.clip(scenario.times + delay, 0.0, None)
        position, _ = scenario.orbit.propagate(scenario.epoch, times)
        sun = sun_position(compute_julian_dates(scenario.epoch, times))
        expected &= visible_sun_fraction(position, sun) >= 0.5
    assert 25 <= np.sum(lit[:, 0] & ~expected) <= 40  # two edges, 16 s each
    assert np.sum(expected != used[:, 0]) <= 2  # a sample an edge
    assert used[:, 1].all()
    assert always.all()


@pytest.mark.slow
def test_light_from_the_earth_is_in_what_a_coarse_sensor_looks_at():
    whole = Scenario.paper()
    sensors = (SunSensor(), SunSensor(name="fine", includes_albedo=False))
    plain, lit = (
        FilterModel.from_scenario(
            dataclasses.replace(whole, sensors=sensors, environment_errors=world)
        )
        for world in (EnvironmentErrors(), EnvironmentErrors(earth_albedo=0.3))
    )
    added = lit.references - plain.references
    assert not added[:, 1].any()
    assert 0.01 < np.linalg.norm(added[:, 0], axis=1).max() < 0.3


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"orbit_error_m": (1.0, 0.0, 0.0)}, "orbit_error_m = .*expected three numbers > 0 m, or"),
        ({"orbit_error_axes": "body"}, "orbit_error_axes = 'body': expected one of 'orbital'"),
        ({"earth_albedo": 30.0}, r"earth_albedo = 30.0: expected a number >= 0 and <= 1"),
        ({"considered": ("albedo",)}, r"considered\[0\] = 'albedo': unknown state"),
    ],
)
def test_a_world_that_cannot_be_is_refused(table, message):
    with pytest.raises(InvalidValue, match=message):
        EnvironmentErrors(**table)


def test_no_sensor_is_called_the_world():
    with pytest.raises(
        InvalidValue, match=r"sensors\[0\].name = 'environment_errors': expected another name"
    ):
        short(sensors=(Magnetometer(name="environment_errors"),))
