"""Finite rotations by a 3-vector, with nothing but ``+ - * /``, so over any scalar.

A vector g stands for the rotation by 2 arctan(|g| / 2) about g,

    R(g) = I + ([g×] + ½ [g×]²) / (1 + |g|² / 4).

It is twice the Gibbs vector: a rotation vector but for terms of third order, without a root or a
sine, and what multiplicative attitude filters use (F. L. Markley, Attitude Error Representations
for Kalman Filtering, Journal of Guidance, Control, and Dynamics 26 (2003) 311-317).
"""

from __future__ import annotations

from dataclasses import dataclass

from .vector import Vec3, cross, dot


@dataclass(frozen=True)
class Matrix:
    """A rotation by its matrix's rows."""

    x: Vec3
    y: Vec3
    z: Vec3


#: One rotation, or two whose product is meant: the last one turns first.
Turns = Vec3 | Matrix | tuple[Vec3 | Matrix, ...]


def rotate(g: Turns, v: Vec3) -> Vec3:
    """R(g) v."""
    if isinstance(g, tuple):
        for turn in reversed(g):
            v = rotate(turn, v)
        return v
    if isinstance(g, Matrix):
        return Vec3(dot(g.x, v), dot(g.y, v), dot(g.z, v))
    once = cross(g, v)
    twice = cross(g, once)
    k = 1.0 / (1.0 + 0.25 * dot(g, g))
    return Vec3(
        v.x + k * (once.x + 0.5 * twice.x),
        v.y + k * (once.y + 0.5 * twice.y),
        v.z + k * (once.z + 0.5 * twice.z),
    )


def unrotate(g: Vec3, v: Vec3) -> Vec3:
    """R(g)ᵀ v."""
    return rotate(-g, v)
