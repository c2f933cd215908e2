"""Gradients of a dipole field and of IGRF, compared with differences of the field."""

import dataclasses
from datetime import UTC, datetime

import numpy as np
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.field import dipole_gradient, field_gradient, geomagnetic_field

RADIUS, STEP = 7.13e6, 100.0
DATE = datetime(2018, 6, 5, tzinfo=UTC)


def draw_positions(n):
    vectors = np.random.default_rng(0).standard_normal((n, 3))
    return RADIUS * vectors / np.linalg.norm(vectors, axis=1)[:, None]


def compute_differences(field, position):
    """Return central differences of a field, with one column per component of the position."""
    columns = [
        (field(position + STEP * axis) - field(position - STEP * axis)) / (2.0 * STEP)
        for axis in np.eye(3)
    ]
    return np.stack(columns, axis=-1)


def compute_dipole_field(position):
    """Return the field of a tilted dipole [nT]."""
    moment = 3e4 * 6.371e6**3 * np.array([0.17, -0.05, -0.98])
    r = np.linalg.norm(position, axis=1)[:, None]
    n = position / r
    return (3.0 * (n @ moment)[:, None] * n - moment) / r**3


def test_dipole_gradient_is_exact_for_dipole_field():
    position = draw_positions(20)
    gradient = dipole_gradient(position, compute_dipole_field(position))
    expected = compute_differences(compute_dipole_field, position)
    np.testing.assert_allclose(gradient, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_allclose(gradient, gradient.swapaxes(1, 2), rtol=0, atol=1e-17)
    np.testing.assert_allclose(np.trace(gradient, axis1=1, axis2=2), 0.0, atol=1e-16)


def compute_igrf_field(position):
    return geomagnetic_field(position, DATE)


def test_dipole_gradient_approximates_igrf():
    """The gradient of a dipole differs by 12 % (root mean square)."""
    position = draw_positions(60)
    expected = compute_differences(compute_igrf_field, position)
    error = dipole_gradient(position, compute_igrf_field(position)) - expected
    assert np.sqrt((error**2).sum() / (expected**2).sum()) < 0.2


def test_field_gradient_equals_differences_of_igrf():
    position = draw_positions(60)
    actual, expected = (
        field_gradient(position, DATE),
        compute_differences(compute_igrf_field, position),
    )
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_environment_gradient_is_derivative_in_inertial_axes():
    """Both the field of IGRF and a user-defined field are tested."""
    scenario = Scenario.cubesat_6u()
    times = np.linspace(0.0, 9000.0, 30)
    environment = Environment.from_times(scenario, times)
    expected = compute_differences(
        lambda r: Environment.from_times(scenario, times, r).field, environment.position
    )
    tolerance = 1e-6 * np.abs(expected).max()
    np.testing.assert_allclose(environment.field_gradient(), expected, rtol=0, atol=tolerance)
    user_defined = dataclasses.replace(
        environment, field=compute_dipole_field(environment.position), epoch=None
    )
    expected = compute_differences(compute_dipole_field, environment.position)
    np.testing.assert_allclose(user_defined.field_gradient(), expected, rtol=0, atol=tolerance)
