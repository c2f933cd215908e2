"""Sensors of two angles: what a sample tells, and when there is one."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    Environment,
    FilterModel,
    Gyro,
    HorizonSensor,
    Magnetometer,
    Scenario,
    Suite,
    TwoAxisSunSensor,
)
from mgeo_attitude.filter.history import can_measure
from mgeo_attitude.geometry.rotation import skew, tangent_vectors
from mgeo_attitude.sensors.environment_errors import POSITION_UNIT
from scipy.spatial.transform import Rotation

V = Rotation.random(20, random_state=1).as_matrix()[:, 0]


def scenario(*sensors, **changes):
    return dataclasses.replace(Scenario.paper(), sensors=sensors, duration=3000.0, **changes)


def test_tangents_are_a_right_handed_frame_with_every_vector():
    """Also with those along an axis, and nearly so."""
    v = np.vstack([V, np.eye(3), -np.eye(3), [[1e-9, -1e-9, -1.0]]])
    v /= np.linalg.norm(v, axis=1)[:, None]
    frames = np.stack([*tangent_vectors(v), v], axis=1)
    np.testing.assert_allclose(
        frames @ frames.swapaxes(1, 2), np.tile(np.eye(3), (27, 1, 1)), atol=1e-15
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, rtol=1e-14)


@pytest.mark.parametrize("kind", [TwoAxisSunSensor, HorizonSensor])
def test_a_sample_tells_nothing_along_the_direction(kind):
    """(I - v vᵀ) / r² about a turn of the body, against one of the mount, and about the bias."""
    sensor = kind(noise_deg=0.3)
    r = np.array(sensor.noise_sigmas())
    assert r.shape == (2,)
    H = Suite(Gyro(), (sensor,)).measurement_matrix(sensor, V, gradient=tangent_vectors(V))
    information = np.einsum("kmi,kmj->kij", H / r[0], H / r[0])
    across = (np.eye(3) - V[:, :, None] * V[:, None]) / r[0] ** 2
    attitude, mount, bias = (slice(i, i + 3) for i in (0, 6, 9))
    np.testing.assert_allclose(
        information[:, attitude, attitude], across, rtol=0, atol=1e-9 / r[0] ** 2
    )
    np.testing.assert_allclose(information[:, attitude, mount], -across, atol=1e-9 / r[0] ** 2)
    np.testing.assert_allclose(information[:, bias, bias], across, atol=1e-9 / r[0] ** 2)
    turned = skew(V.T).transpose(2, 1, 0) / r[0] ** 2
    np.testing.assert_allclose(information[:, attitude, bias], turned, atol=1e-9 / r[0] ** 2)


def test_nadir_is_another_where_the_satellite_is_not_as_believed():
    """Against the position itself, moved by 100 m along each axis of GCRS."""
    of = scenario(HorizonSensor(), Magnetometer())
    environment, sensor = Environment.from_scenario(of), HorizonSensor()
    for axis, column in zip(np.eye(3), sensor.position_gradient(environment).T, strict=True):
        r = environment.position + 0.1 * POSITION_UNIT * axis
        moved = -r / np.linalg.norm(r, axis=1)[:, None] - sensor.inertial_vector(environment)
        np.testing.assert_allclose(0.1 * column.T, moved, rtol=0, atol=1e-9)


def test_a_horizon_sensor_looks_at_the_earth_where_it_is_made_for():
    of = scenario(HorizonSensor(), Magnetometer())
    environment = Environment.from_scenario(of)
    altitude = 1e-3 * (np.linalg.norm(environment.position, axis=1) - 6378136.3)
    low, high = np.quantile(altitude, [0.2, 0.7])
    sensor = HorizonSensor(lowest_altitude_km=low, highest_altitude_km=high)
    np.testing.assert_array_equal(
        sensor.find_available_samples(environment), (altitude >= low) & (altitude <= high)
    )
    assert HorizonSensor().find_available_samples(environment) is None
    nadir = sensor.inertial_vector(environment)
    np.testing.assert_allclose(np.cross(nadir, environment.position) / 7e6, 0.0, atol=1e-12)
    assert (np.einsum("ij,ij->i", nadir, environment.position) < 0.0).all()


def test_the_sun_and_an_earth_out_of_sight_blind_it():
    sensor = HorizonSensor(boresight=(0.0, 0.0, 2.0), half_angle_deg=60.0, sun_exclusion_deg=50.0)
    model = FilterModel.from_scenario(scenario(sensor, Magnetometer(), eclipse=True))
    attitude = Rotation.random(len(model.times), random_state=4).as_matrix()
    seen = can_measure(model, 0, attitude, np.zeros((model.n_steps, 3)))
    z = attitude[:, 2]
    sun, _ = model.select_direction("sun")
    to_sun = np.degrees(np.arccos(np.einsum("ki,ki->k", z, sun)))
    to_nadir = np.degrees(np.arccos(np.einsum("ki,ki->k", z, model.references[:, 0])))
    dark = ~sun.any(axis=1)
    assert 0 < dark.sum() < len(dark)
    np.testing.assert_array_equal(seen, (to_nadir <= 60.0) & (dark | (to_sun > 50.0)))
