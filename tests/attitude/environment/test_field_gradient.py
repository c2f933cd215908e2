"""Gradients of the field, of a dipole and of IGRF, against differences of fields."""

import dataclasses
from datetime import UTC, datetime

import numpy as np
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.field import dipole_gradient, field_gradient, geomagnetic_field

RADIUS, STEP = 7.13e6, 100.0
DATE = datetime(2018, 6, 5, tzinfo=UTC)


def places(n):
    vectors = np.random.default_rng(0).standard_normal((n, 3))
    return RADIUS * vectors / np.linalg.norm(vectors, axis=1)[:, None]


def differences(field, position):
    """Central differences of a field: columns belong to the position's components."""
    columns = [
        (field(position + STEP * axis) - field(position - STEP * axis)) / (2.0 * STEP)
        for axis in np.eye(3)
    ]
    return np.stack(columns, axis=-1)


def dipole(position):
    """Of a moment that is tilted, [nT]."""
    moment = 3e4 * 6.371e6**3 * np.array([0.17, -0.05, -0.98])
    r = np.linalg.norm(position, axis=1)[:, None]
    n = position / r
    return (3.0 * (n @ moment)[:, None] * n - moment) / r**3


def test_of_a_dipole_it_is_exact():
    position = places(20)
    found = dipole_gradient(position, dipole(position))
    expected = differences(dipole, position)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_allclose(found, found.swapaxes(1, 2), rtol=0, atol=1e-17)
    np.testing.assert_allclose(np.trace(found, axis1=1, axis2=2), 0.0, atol=1e-16)


def igrf(position):
    """By ppigrf, which knows nothing of gradients."""
    return geomagnetic_field(position, DATE)


def test_of_igrf_it_is_near():
    """A dipole is 12 % off in the mean square; for a field of one's own nothing better is known."""
    position = places(60)
    expected = differences(igrf, position)
    error = dipole_gradient(position, igrf(position)) - expected
    assert np.sqrt((error**2).sum() / (expected**2).sum()) < 0.2


def test_that_of_igrf_is_exact():
    position = places(60)
    found, expected = field_gradient(position, DATE), differences(igrf, position)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_it_follows_the_position_in_inertial_axes():
    """Of tables of IGRF, and of tables of one's own, of whose field nothing but values is known."""
    scenario = Scenario.cubesat_6u()
    times = np.linspace(0.0, 9000.0, 30)
    here = Environment.from_times(scenario, times)
    expected = differences(
        lambda r: Environment.from_times(scenario, times, r).field, here.position
    )
    limit = 1e-6 * np.abs(expected).max()
    np.testing.assert_allclose(here.field_gradient(), expected, rtol=0, atol=limit)
    own = dataclasses.replace(here, field=dipole(here.position), epoch=None)
    expected = differences(dipole, here.position)
    np.testing.assert_allclose(own.field_gradient(), expected, rtol=0, atol=limit)
