"""3-vectors with components of any scalar type: numbers, arrays, or symbols for code generation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Vec3:
    """Vector whose three components are numbers, arrays or symbols of generated code.

    The components may have any type with ``+``, ``-`` and ``*``. Sensor error models use this
    class, so that the same code evaluates numbers and generates the source of the filter step from
    symbols.
    """

    x: Any
    y: Any
    z: Any

    __array_ufunc__ = None  # NumPy then delegates array * Vec3 to `__rmul__`.

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
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


def dot(a: Vec3, b: Vec3) -> Any:
    return a.x * b.x + a.y * b.y + a.z * b.z


def unit_vector(direction: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the unit vector along a nonzero direction, as a tuple of three floats."""
    length = math.hypot(*direction)
    x, y, z = (component / length for component in direction)
    return (x, y, z)


def componentwise_product(a: Vec3, b: Vec3) -> Vec3:
    return Vec3(a.x * b.x, a.y * b.y, a.z * b.z)


def shear(a: Vec3, b: Vec3) -> Vec3:
    """Return the cross product of a and b with all signs positive.

    The result is (a_y b_z + a_z b_y, a_z b_x + a_x b_z, a_x b_y + a_y b_x). The result is N(a) b,
    where N(a) is the symmetric counterpart of the cross-product matrix [a×].
    """
    return Vec3(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)


def choose(value: Any, bound: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where `value` is at least `bound`, and `no` elsewhere.

    The arguments are numbers, arrays or symbols of generated code.
    """
    if isinstance(value, float | np.ndarray):
        return np.where(value >= bound, yes, no)
    return value.choose(bound, yes, no)


def maximum(a: Any, b: Any) -> Any:
    """Return the element-wise maximum of a and b.

    The arguments are numbers, arrays or symbols of generated code.
    """
    return choose(a, b, a, b)
