"""Directions of path constraints: Moon, limb of the Earth, and unit vectors."""

from __future__ import annotations

import dataclasses

import erfa
import numpy as np
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.constants import ASTRONOMICAL_UNIT, DAY, EARTH_RADIUS
from mgeo_attitude.environment.directions import DIRECTIONS, compute_directions, compute_radii
from mgeo_attitude.environment.sun_moon import moon_position, sun_position
from mgeo_attitude.environment.times import JulianDates

SHORT = dataclasses.replace(Scenario.cubesat_6u(), duration=3000.0, step=50.0)
NAMES = tuple(DIRECTIONS)


def test_moon_position_equals_example_of_meeus() -> None:
    """Example 47.a of Astronomical Algorithms: 1992 April 12, 0h TD, mean ecliptic of date.

    Meeus' longitude contains the light time of 1.2 s, in which the Moon moves by 0.0002 deg.
    """
    day = np.array([0.0])
    moon = moon_position(JulianDates(2448724.5, ut=day, tt=day))[0]
    x, y, z = erfa.ecm06(2448724.5, 0.0) @ moon
    longitude, latitude = (
        np.degrees(np.arctan2(y, x)),
        np.degrees(np.arcsin(z / np.hypot(x, np.hypot(y, z)))),
    )
    assert abs(longitude - 133.162655) < 3e-4
    assert abs(latitude + 3.229126) < 1e-4
    assert abs(np.linalg.norm(moon) - 368_409.7e3) < 1e3


def test_moon_position_equals_sofa() -> None:
    day = np.array([43999.9])
    moon = moon_position(JulianDates(2400000.5, ut=day, tt=day))[0] / ASTRONOMICAL_UNIT
    published = [-0.002601295959971044, 0.0006139750944302742, 0.00026407945282298289]
    np.testing.assert_allclose(moon, published, rtol=0.0, atol=1e-14)


def test_moon_shadow_axis_agrees_with_published_eclipse() -> None:
    """Total eclipse of 8 April 2024, greatest at 18:17:18 UT1: gamma is 0.3431 (NASA).

    Gamma is the distance of the shadow axis from the Earth's center in Earth radii. A value of
    0.001 is 6 km of the Moon's position, of which aberration is half.
    """
    seconds = np.array([18.0 * 3600.0 + 17.0 * 60.0 + 18.0])
    at = JulianDates(2460408.5, ut=seconds / DAY, tt=(seconds + 69.2) / DAY)
    sun, moon = sun_position(at)[0], moon_position(at)[0]
    axis = (moon - sun) / np.linalg.norm(moon - sun)
    gamma = np.linalg.norm(moon - (moon @ axis) * axis) / 6_378_137.0
    assert abs(gamma - 0.3431) < 1e-3


def test_directions_are_unit_vectors_to_named_objects() -> None:
    environment = Environment.from_scenario(SHORT)
    directions = dict(
        zip(
            NAMES,
            np.moveaxis(compute_directions(NAMES, environment, SHORT.epoch), 1, 0),
            strict=True,
        )
    )
    lengths = {name: np.linalg.norm(v, axis=1) for name, v in directions.items()}
    for name in set(NAMES) - {"sun"}:
        np.testing.assert_allclose(lengths[name], 1.0, rtol=1e-15)
    np.testing.assert_array_equal(lengths["sun"] > 0.5, environment.sunlit)
    assert set(environment.sunlit.tolist()) == {True, False}
    np.testing.assert_array_equal(directions["nadir"], directions["earth"])
    # In a nearly circular orbit, the velocity is perpendicular to nadir.
    assert np.abs(np.einsum("ni,ni->n", directions["nadir"], directions["velocity"])).max() < 0.01
    momentum = np.cross(environment.position, environment.velocity)
    for name in ("nadir", "velocity"):
        assert (
            np.abs(np.einsum("ni,ni->n", directions[name], momentum)).max()
            < 1e-3 * np.abs(momentum).max()
        )


def test_lines_of_sight_to_limb_are_tangent_to_earth() -> None:
    environment = Environment.from_scenario(SHORT)
    nadir = compute_directions(("nadir",), environment, SHORT.epoch)[:, 0]
    radius = compute_radii(("sun", "earth", "nadir"), environment)
    assert (radius[:, [0, 2]] == 0.0).all()
    across = np.cross(nadir, environment.sun)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    sight = np.cos(radius[:, [1]]) * nadir + np.sin(radius[:, [1]]) * across
    nearest = np.linalg.norm(np.cross(environment.position, sight), axis=1)
    np.testing.assert_allclose(nearest, EARTH_RADIUS, rtol=1e-12)
