"""Direction sensors with two angles: information of a measurement, and availability."""

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


def test_tangent_vectors_complete_right_handed_frame():
    # Vectors along an axis, and nearly along an axis, are included.
    v = np.vstack([V, np.eye(3), -np.eye(3), [[1e-9, -1e-9, -1.0]]])
    v /= np.linalg.norm(v, axis=1)[:, None]
    frames = np.stack([*tangent_vectors(v), v], axis=1)
    np.testing.assert_allclose(
        frames @ frames.swapaxes(1, 2), np.tile(np.eye(3), (27, 1, 1)), atol=1e-15
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, rtol=1e-14)


@pytest.mark.parametrize("kind", [TwoAxisSunSensor, HorizonSensor])
def test_measurement_has_no_information_along_direction(kind):
    """The information is (I - v vᵀ) / r² about attitude, misalignment and bias."""
    sensor = kind(noise_deg=0.3)
    r = np.array(sensor.noise_sigmas())
    assert r.shape == (2,)
    H = Suite(Gyro(), (sensor,)).measurement_matrix(sensor, V, auxiliary_vectors=tangent_vectors(V))
    information = np.einsum("kmi,kmj->kij", H / r[0], H / r[0])
    projection = (np.eye(3) - V[:, :, None] * V[:, None]) / r[0] ** 2
    attitude, mount, bias = (slice(i, i + 3) for i in (0, 6, 9))
    np.testing.assert_allclose(
        information[:, attitude, attitude], projection, rtol=0, atol=1e-9 / r[0] ** 2
    )
    np.testing.assert_allclose(information[:, attitude, mount], -projection, atol=1e-9 / r[0] ** 2)
    np.testing.assert_allclose(information[:, bias, bias], projection, atol=1e-9 / r[0] ** 2)
    cross_information = skew(V.T).transpose(2, 1, 0) / r[0] ** 2
    np.testing.assert_allclose(
        information[:, attitude, bias], cross_information, atol=1e-9 / r[0] ** 2
    )


def test_position_gradient_is_change_of_nadir_with_position():
    """The position is changed by 100 m along each axis of GCRS."""
    modified = scenario(HorizonSensor(), Magnetometer())
    environment, sensor = Environment.from_scenario(modified), HorizonSensor()
    for axis, column in zip(np.eye(3), sensor.position_gradient(environment).T, strict=True):
        r = environment.position + 0.1 * POSITION_UNIT * axis
        change = -r / np.linalg.norm(r, axis=1)[:, None] - sensor.inertial_vector(environment)
        np.testing.assert_allclose(0.1 * column.T, change, rtol=0, atol=1e-9)


def test_horizon_sensor_is_available_in_its_altitude_range():
    modified = scenario(HorizonSensor(), Magnetometer())
    environment = Environment.from_scenario(modified)
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


def test_horizon_sensor_needs_earth_in_view_and_sun_outside():
    sensor = HorizonSensor(boresight=(0.0, 0.0, 2.0), half_angle_deg=60.0, sun_exclusion_deg=50.0)
    model = FilterModel.from_scenario(scenario(sensor, Magnetometer(), eclipse=True))
    attitude = Rotation.random(len(model.times), random_state=4).as_matrix()
    is_measured = can_measure(model, 0, attitude, np.zeros((model.n_steps, 3)))
    z = attitude[:, 2]
    sun, _ = model.select_direction("sun")
    to_sun = np.degrees(np.arccos(np.einsum("ki,ki->k", z, sun)))
    to_nadir = np.degrees(np.arccos(np.einsum("ki,ki->k", z, model.references[:, 0])))
    in_eclipse = ~sun.any(axis=1)
    assert 0 < in_eclipse.sum() < len(in_eclipse)
    np.testing.assert_array_equal(is_measured, (to_nadir <= 60.0) & (in_eclipse | (to_sun > 50.0)))
