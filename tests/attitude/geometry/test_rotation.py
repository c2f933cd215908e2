"""Rotations by twice the Gibbs vector, compared with scipy."""

import numpy as np
import pytest
from mgeo_attitude.geometry.rotation import (
    exponential_map,
    multiply,
    rotate,
    rotation_matrix,
    rotation_vector,
    unrotate,
)
from scipy.spatial.transform import Rotation


def as_scipy(g):
    """Return the rotation by 2 arctan(|g| / 2) about g."""
    length = np.linalg.norm(g)
    return Rotation.from_rotvec(2.0 * np.arctan(0.5 * length) * g / length)


@pytest.mark.parametrize("size", [1e-6, 0.1, 1.0, 20.0])
def test_rotate_equals_scipy(size):
    rng = np.random.default_rng(0)
    g, v = size * rng.standard_normal((20, 3)), rng.standard_normal((20, 3))
    turned = np.array([as_scipy(a).apply(b) for a, b in zip(g, v, strict=True)])
    np.testing.assert_allclose(rotate(g, v), turned, rtol=0, atol=1e-14)
    np.testing.assert_allclose(unrotate(g, turned), v, rtol=0, atol=1e-14)
    matrices = rotation_matrix(g.T)
    np.testing.assert_allclose(np.einsum("ijr,rj->ri", matrices, v), turned, rtol=0, atol=1e-14)
    np.testing.assert_allclose(rotation_vector(matrices), g.T, rtol=1e-9)


@pytest.mark.parametrize("size", [0.0, 1e-9, 0.1, 3.0, 100.0])
def test_exponential_map_equals_scipy(size):
    phi = size * np.random.default_rng(1).standard_normal((3, 20))
    expected = Rotation.from_rotvec(phi.T).as_matrix()
    np.testing.assert_allclose(np.moveaxis(exponential_map(phi), -1, 0), expected, atol=1e-14)


def test_product_applies_last_rotation_first():
    a, b = np.random.default_rng(1).standard_normal((2, 3))
    product = multiply(rotation_matrix(a[:, None]), rotation_matrix(b[:, None]))[..., 0]
    np.testing.assert_allclose(product, (as_scipy(a) * as_scipy(b)).as_matrix(), atol=1e-14)
