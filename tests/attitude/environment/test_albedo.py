"""Albedo of the Earth compared with closed forms of a Lambert sphere and a sum over its surface."""

import numpy as np
import pytest
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.sun_moon import albedo_vector

UP = np.array([0.0, 0.0, 1.0])


def sun_at(zenith):
    """Return unit vectors at zenith angles [rad]."""
    zenith = np.atleast_1d(zenith)
    return np.stack([np.sin(zenith), np.zeros_like(zenith), np.cos(zenith)], axis=1)


def test_distant_albedo_equals_lambert_phase_function():
    """Geometric albedo 2/3, (sin α + (π - α) cos α) / π: Lester, McCall & Tatum (1979), eq. 4."""
    alpha, r = np.radians([0.0, 30.0, 60.0, 90.0, 120.0, 150.0]), 1e5 * EARTH_RADIUS
    albedo = albedo_vector(np.tile(r * UP, (6, 1)), sun_at(alpha))
    expected = 2.0 / 3.0 * (np.sin(alpha) + (np.pi - alpha) * np.cos(alpha)) / np.pi * 1e-10
    np.testing.assert_allclose(-albedo[:, 2], expected, rtol=2e-3)
    np.testing.assert_allclose(albedo[:, :2], 0.0, atol=1e-14)


@pytest.mark.parametrize("height", [400e3, 20_000e3])
def test_albedo_in_orbit_equals_sum_over_surface_cells(height):
    """The surface has 600 x 1200 cells, as in the method of Bhanderi and Bak."""
    zenith = np.radians([0.0, 20.0, 60.0, 85.0, 95.0, 110.0, 150.0, 180.0])
    edge = np.arccos(EARTH_RADIUS / (EARTH_RADIUS + height))
    arc = edge * (np.arange(600) + 0.5) / 600
    around = 2.0 * np.pi * (np.arange(1200) + 0.5) / 1200
    n = np.stack(
        np.broadcast_arrays(
            np.sin(arc)[:, None] * np.cos(around),
            np.sin(arc)[:, None] * np.sin(around),
            np.cos(arc)[:, None],
        ),
        axis=-1,
    ).reshape(-1, 3)
    area = EARTH_RADIUS**2 * np.repeat(np.sin(arc), 1200) * edge / 600 * 2.0 * np.pi / 1200
    to_cell = EARTH_RADIUS * n - (EARTH_RADIUS + height) * UP
    distance = np.linalg.norm(to_cell, axis=1)
    leaving = np.maximum(-np.einsum("ni,ni->n", n, to_cell) / distance, 0.0)
    expected = [
        (area / np.pi * np.maximum(n @ sun, 0.0) * leaving / distance**3) @ to_cell
        for sun in sun_at(zenith)
    ]
    albedo = albedo_vector(np.tile((EARTH_RADIUS + height) * UP, (8, 1)), sun_at(zenith))
    np.testing.assert_allclose(albedo, expected, rtol=0, atol=2e-4)
    assert np.abs(albedo).max() > 0.02
