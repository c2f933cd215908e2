"""Circles on the map of directions."""

import numpy as np
import pytest
from mgeo_attitude.view.figures.curves import MAP_HALF_SIZE, project_circle, project_directions


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 0, 1), (-1, 0.2, 0.1), (-1, 0, 0)])
@pytest.mark.parametrize("degrees", [10.0, 60.0, 120.0])
def test_directions_at_angular_radius_lie_on_circle(axis, degrees):
    """Random directions at the angular radius are projected onto the map."""
    across, up = project_circle(axis, np.radians(degrees))
    unit = np.array(axis) / np.linalg.norm(axis)
    vectors = np.random.default_rng(1).standard_normal((4000, 3))
    perpendicular = vectors - (vectors @ unit)[:, None] * unit
    perpendicular /= np.linalg.norm(perpendicular, axis=1)[:, None]
    edge = np.cos(np.radians(degrees)) * unit + np.sin(np.radians(degrees)) * perpendicular
    points = np.array(project_directions(edge), dtype=float)
    line = np.array([across, up])[:, ~np.isnan(across)]
    nearest = np.linalg.norm(points[:, :, None] - line[:, None, :], axis=0).min(axis=1)
    assert nearest.max() < 0.04 * MAP_HALF_SIZE[0]  # The line has a point every 2.5 degrees.
    lengths = np.hypot(np.diff(across), np.diff(up))
    assert np.nanmax(lengths) < 0.08 * MAP_HALF_SIZE[0]  # No segment crosses the map.
