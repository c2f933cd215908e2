"""Finite rotations as 3-vectors.

A vector g represents the rotation by 2 arctan(|g| / 2) about g,

    R(g) = I + ([g×] + ½ [g×]²) / (1 + |g|² / 4).

The vector g is twice the Gibbs vector, as in multiplicative attitude filters (F. L. Markley,
Attitude Error Representations for Kalman Filtering, Journal of Guidance, Control, and Dynamics 26
(2003) 311-317). It equals the rotation vector up to third order, and R(g) needs no square root or
sine.

The functions `rotate`, `cross`, `shear`, `dot` and `normalize`, from which sensor models are built,
accept arrays of vectors, shape (..., 3), and `estimation.taylor.Taylor`. The functions for many
rotations have the matrix axes first, shape (3, 3, ...).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats


def cross(a: Any, b: Any) -> Any:
    following, last = [1, 2, 0], [2, 0, 1]
    return a[..., following] * b[..., last] - a[..., last] * b[..., following]


def shear(a: Any, b: Any) -> Any:
    """Return the cross product of a and b with all signs positive, shape (..., 3).

    The product is (a_y b_z + a_z b_y, a_z b_x + a_x b_z, a_x b_y + a_y b_x).
    """
    following, last = [1, 2, 0], [2, 0, 1]
    return a[..., following] * b[..., last] + a[..., last] * b[..., following]


def dot(a: Any, b: Any) -> Any:
    """Return the dot products of vectors a and b, keeping the last axis, shape (..., 1)."""
    product = a * b
    return product[..., :1] + product[..., 1:2] + product[..., 2:]


def euclidean_norm(v: Any) -> Any:
    """Return the Euclidean norms of vectors, keeping the last axis, shape (..., 1)."""
    square = dot(v, v)
    return np.sqrt(square) if isinstance(square, np.ndarray) else square.sqrt()


def normalize(v: Any) -> Any:
    """Scale vectors, shape (..., 3), to unit length."""
    return v / euclidean_norm(v)


def rotate(g: Any, v: Any) -> Any:
    """Rotate vectors v by rotations g, each of which is twice a Gibbs vector.

    If g is a function, return g(v).
    """
    if callable(g):
        return g(v)
    once = cross(g, v)
    return v + (once + 0.5 * cross(g, once)) / (1.0 + 0.25 * dot(g, g))


def unrotate(g: Floats, v: Floats) -> Floats:
    """Rotate vectors v by the inverses of rotations g, each of which is twice a Gibbs vector."""
    rotated: Floats = rotate(-g, v)
    return rotated


def perpendicular_axes(axis: Floats) -> Floats:
    """Return two unit vectors, shape (2, 3), that form a right-handed frame with `axis`."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(axis, first)])


def build_frame(axis: Floats) -> Floats:
    """Build a right-handed frame whose z axis is `axis`.

    The rows of the result, shape (3, 3), are the axes. The x and y axes are arbitrary.
    """
    y, minus_x = perpendicular_axes(axis)
    return np.array([-minus_x, y, axis])


def tangent_vectors(v: Floats) -> tuple[Floats, Floats]:
    """Return two unit vectors t and u perpendicular to each unit vector v, with t × u = v.

    Both arrays have the shape (..., 3). Source: T. Duff et al., Building an orthonormal basis,
    revisited, Journal of Computer Graphics Techniques 6 (2017) 1-8.
    """
    x, y, z = np.moveaxis(v, -1, 0)
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    t = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    return t, np.stack([b, sign + y * y * a, -y], axis=-1)


def multiply(A: Floats, B: Floats) -> Floats:
    """Multiply two arrays of matrices that have the matrix axes first.

    The shapes are (i, k, ...) and (k, j, ...).
    """
    product: Floats = np.einsum("ik...,kj...->ij...", A, B)
    return product


def skew(v: Floats) -> Floats:
    """Return the cross-product matrix [v×], shape (3, 3, ...), of vectors v, shape (3, ...)."""
    product = np.zeros((3, *v.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        product[j, i] = v[k]
        product[i, j] = -v[k]
    return product


def rotation_matrix(g: Floats) -> Floats:
    """Return the rotation matrices of vectors g, each of which is twice a Gibbs vector.

    The vectors have the shape (3, ...) and the matrices (3, 3, ...).
    """
    quarter = 0.25 * (g * g).sum(axis=0)
    rotation = skew(g) + 0.5 * g[:, None] * g
    for i in range(3):
        rotation[i, i] += 1.0 - quarter
    rotation /= 1.0 + quarter
    return rotation


def rotation_vector(R: Floats) -> Floats:
    """Return twice the Gibbs vector of each rotation matrix.

    The matrices have the shape (3, 3, ...) and the vectors (3, ...).
    """
    g: Floats = np.stack([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    g *= 2.0 / (1.0 + R[0, 0] + R[1, 1] + R[2, 2])
    return g


def rotation_jacobian(g: Floats) -> Floats:
    """Return the Jacobian of the composed rotation R(g) R(e) with respect to e, at e = 0.

    The Jacobian has the shape (3, 3, ...). Each rotation is represented by twice its Gibbs vector.
    """
    derivative = 0.5 * skew(g) + 0.25 * g[:, None] * g
    for i in range(3):
        derivative[i, i] += 1.0
    return derivative


def exponential_map(phi: Floats) -> Floats:
    """Convert rotation vectors φ [rad] to rotation matrices exp([φ×]).

    The vectors have the shape (3, ...) and the matrices (3, 3, ...).
    """
    half = 0.5 * np.sqrt((phi * phi).sum(axis=0))
    return rotation_matrix(phi * np.sinc(half / np.pi) / np.cos(half))
