"""Circles on the map of the body's sphere."""

import numpy as np
import pytest
from mgeo_attitude.view.figures.curves import MAP_HALF_SIZE, project_circle, project_directions


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 0, 1), (-1, 0.2, 0.1), (-1, 0, 0)])
@pytest.mark.parametrize("degrees", [10.0, 60.0, 120.0])
def test_a_circle_is_where_directions_are_as_far_from_its_axis(axis, degrees):
    """Directions all over the sphere, on the map: those at this angle lie on the line."""
    across, up = project_circle(axis, np.radians(degrees))
    unit = np.array(axis) / np.linalg.norm(axis)
    turns = np.random.default_rng(1).standard_normal((4000, 3))
    off = turns - (turns @ unit)[:, None] * unit
    off /= np.linalg.norm(off, axis=1)[:, None]
    edge = np.cos(np.radians(degrees)) * unit + np.sin(np.radians(degrees)) * off
    places = np.array(project_directions(edge), dtype=float)
    known = np.array([across, up])[:, ~np.isnan(across)]
    nearest = np.linalg.norm(places[:, :, None] - known[:, None, :], axis=0).min(axis=1)
    assert nearest.max() < 0.04 * MAP_HALF_SIZE[0]  # the line has a point every 2.5 degrees
    strokes = np.hypot(np.diff(across), np.diff(up))
    assert np.nanmax(strokes) < 0.08 * MAP_HALF_SIZE[0]  # none across the map
