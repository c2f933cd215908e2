"""Finite rotations by 3-vectors.

A vector g stands for the rotation by 2 arctan(|g| / 2) about g,

    R(g) = I + ([g×] + ½ [g×]²) / (1 + |g|² / 4).

It is twice the Gibbs vector: a rotation vector but for terms of third order, without a root or a
sine, and what multiplicative attitude filters use (F. L. Markley, Attitude Error Representations
for Kalman Filtering, Journal of Guidance, Control, and Dynamics 26 (2003) 311-317).

Sensors are written with `rotate`, `cross` and `dot`, for arrays of vectors, shape (..., 3), and for
`estimation.taylor.Taylor`. Many rotations at once are matrices of arrays, shape (3, 3, ...).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: The even permutations of three axes.
CYCLES = ((0, 1, 2), (1, 2, 0), (2, 0, 1))

_NEXT, _AFTER_NEXT = np.array([1, 2, 0]), np.array([2, 0, 1])


def cross(a: Any, b: Any) -> Any:
    """Cross product a × b."""
    return a[..., _NEXT] * b[..., _AFTER_NEXT] - a[..., _AFTER_NEXT] * b[..., _NEXT]


def dot(a: Any, b: Any) -> Any:
    """Scalar product a · b, shape (..., 1)."""
    product = a * b
    return product[..., [0]] + product[..., [1]] + product[..., [2]]


def rotate(g: Any, v: Any) -> Any:
    """R(g) v; g may be anything that knows how to `rotate` a vector."""
    if not isinstance(g, np.ndarray):
        return g.rotate(v)
    once = cross(g, v)
    return v + (once + 0.5 * cross(g, once)) / (1.0 + 0.25 * dot(g, g))


def unrotate(g: Floats, v: Floats) -> Floats:
    """R(g)ᵀ v."""
    turned: Floats = rotate(-g, v)
    return turned


def multiply(A: Floats, B: Floats) -> Floats:
    """A B for matrices of arrays, shapes (i, k, r) and (k, j, r)."""
    product: Floats = np.einsum("ikr,kjr->ijr", A, B)
    return product


def skew(v: Floats) -> Floats:
    """[v×] of v, shape (3, ...)."""
    matrices = np.zeros((3, *v.shape))
    for i, j, k in CYCLES:
        matrices[k, j], matrices[j, k] = v[i], -v[i]
    return matrices


def matrix(g: Floats) -> Floats:
    """R(g) of g, shape (3, ...)."""
    quarter = 0.25 * (g * g).sum(axis=0)
    turned = skew(g) + 0.5 * g[:, None] * g
    for i in range(3):
        turned[i, i] += 1.0 - quarter
    turned /= 1.0 + quarter
    return turned


def vector(R: Floats) -> Floats:
    """The g of R(g) = R."""
    g: Floats = np.array([R[k, j] - R[j, k] for _, j, k in CYCLES])
    g *= 2.0 / (1.0 + R[0, 0] + R[1, 1] + R[2, 2])
    return g


def exponential(phi: Floats) -> Floats:
    """exp([φ×]), the rotation by |φ| about φ, shape (3, ...), by Rodrigues' formula."""
    square = (phi * phi).sum(axis=0)
    turns = np.sqrt(square) / np.pi
    c = 0.5 * np.sinc(0.5 * turns) ** 2
    turned: Floats = np.sinc(turns) * skew(phi) + c * phi[:, None] * phi
    for i in range(3):
        turned[i, i] += 1.0 - c * square
    return turned
