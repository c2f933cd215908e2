"""Rotations by twice the Gibbs vector against scipy's."""

import numpy as np
import pytest
from mgeo_attitude.rotation import Matrix, rotate, unrotate
from mgeo_attitude.vector import Vec3
from scipy.spatial.transform import Rotation


def as_scipy(g):
    """The rotation by 2 arctan(|g| / 2) about g."""
    length = np.linalg.norm(g)
    return Rotation.from_rotvec(2.0 * np.arctan(0.5 * length) * g / length)


@pytest.mark.parametrize("size", [1e-6, 0.1, 1.0, 20.0])
def test_rotate_is_scipys(size):
    rng = np.random.default_rng(0)
    for _ in range(20):
        g, v = size * rng.standard_normal(3), rng.standard_normal(3)
        turned = as_scipy(g).apply(v)
        np.testing.assert_allclose([*rotate(Vec3(*g), Vec3(*v))], turned, rtol=0, atol=1e-14)
        np.testing.assert_allclose([*unrotate(Vec3(*g), Vec3(*turned))], v, rtol=0, atol=1e-14)


def test_of_several_the_last_one_turns_first():
    rng = np.random.default_rng(1)
    a, b, v = rng.standard_normal((3, 3))
    matrix = Matrix(*(Vec3(*row) for row in as_scipy(a).as_matrix()))
    expected = (as_scipy(a) * as_scipy(b)).apply(v)
    for first in (matrix, Vec3(*a)):
        turned = rotate((first, Vec3(*b)), Vec3(*v))
        np.testing.assert_allclose([*turned], expected, rtol=0, atol=1e-14)
