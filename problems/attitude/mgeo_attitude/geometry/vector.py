"""Three-vectors over any scalar: numbers for analysis, symbols for code generation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Vec3:
    """A 3-vector whose components only need ``+``, ``-`` and ``*``.

    Error models are written with it, so that one text serves numbers and the symbols from which
    the filter kernel is generated.
    """

    x: Any
    y: Any
    z: Any

    __array_ufunc__ = None  # an array times a vector is the vector's to compute

    def __iter__(self) -> Iterator[Any]:
        return iter((self.x, self.y, self.z))

    def __add__(self, other: Vec3) -> Vec3:
        return Vec3(self.x + other.x, self.y + other.y, self.z + other.z)

    def __sub__(self, other: Vec3) -> Vec3:
        return Vec3(self.x - other.x, self.y - other.y, self.z - other.z)

    def __neg__(self) -> Vec3:
        return Vec3(-self.x, -self.y, -self.z)

    def __rmul__(self, factor: Any) -> Vec3:
        return Vec3(factor * self.x, factor * self.y, factor * self.z)


def cross(a: Vec3, b: Vec3) -> Vec3:
    """Cross product a × b."""
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


def dot(a: Vec3, b: Vec3) -> Any:
    """Scalar product a · b."""
    return a.x * b.x + a.y * b.y + a.z * b.z


def unit(direction: tuple[float, float, float]) -> tuple[float, float, float]:
    """The unit vector along a direction, which is not zero."""
    length = math.hypot(*direction)
    x, y, z = (component / length for component in direction)
    return (x, y, z)


def scale(a: Vec3, b: Vec3) -> Vec3:
    """Component-wise product diag(a) b."""
    return Vec3(a.x * b.x, a.y * b.y, a.z * b.z)


def shear(a: Vec3, b: Vec3) -> Vec3:
    """The cross product with a plus, N(a) b: a symmetric matrix with zeros on the diagonal."""
    return Vec3(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)


def choose(value: Any, bound: Any, yes: Any, no: Any) -> Any:
    """Return one thing where a value reaches a bound, another where it does not."""
    if isinstance(value, float | np.ndarray):
        return np.where(value >= bound, yes, no)
    return value.choose(bound, yes, no)


def maximum(a: Any, b: Any) -> Any:
    """Return the greater of a symbol, or an array, and another number."""
    return choose(a, b, a, b)
