"""The angle of `keep_out.sun_clearance` as straight-line code of the kernel, over symbols.

Written apart from its NumPy twin: in a frame of the axis, and with an arc tangent from nothing but
``+ - * /`` and roots, which run in vector registers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..vector import Vec3, dot
from .keep_out import PARALLEL
from .symbols import Symbol, SymbolArithmetic, SymbolTriangle

Floats = NDArray[np.float64]

#: Terms of the arc tangent's series; the next one is below 1e-17 of the angle.
_TERMS = 12


def cone_frame(axis: Floats) -> Floats:
    """A unit vector and two that make it a right-handed frame, shape (3, 3), in rows."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return np.array([axis, first, np.cross(axis, first)])


def cone_constants(axes: Floats, sigmas: Floats) -> Floats:
    """What the kernel needs of keep-out cones, one after the other.

    Of a cone with a margin the `cone_frame`, row by row, and the margin; of others the axis.

    Parameters
    ----------
    axes : array, shape (n, 3)
    sigmas : array, shape (n,)
    """
    parts: list[Floats] = [np.empty(0)]
    for axis, k in zip(axes, sigmas, strict=True):
        parts.append(np.append(cone_frame(axis), k) if k > 0.0 else axis)
    return np.concatenate(parts)


def sun_excess(
    frame: Sequence[Vec3],
    sigmas: Symbol,
    sun: Vec3,
    P: SymbolTriangle,
    dark: Symbol,
    ops: SymbolArithmetic,
) -> Any:
    """Margin less angle between the Sun and an axis; `dark` where the Sun does not shine.

    Parameters
    ----------
    frame : three Vec3
        See `cone_frame`.
    sigmas : Symbol
        Margin, in 1-sigmas of the angle.
    sun : Vec3
        Unit vector to the Sun or zero, body axes.
    P : SymbolTriangle
        Covariance, whose first three states are the attitude error.
    """
    axis, one, two = frame
    c, a, b = (ops.keep(dot(v, sun)) for v in (axis, one, two))
    square = ops.keep(a * a + b * b)
    p, q, r = (ops.keep(_form(x, P, y)) for x, y in ((one, one), (one, two), (two, two)))
    # the normal of axis and Sun is (a two - b one) / sine
    safe = ops.keep(ops.maximum(square, Symbol(repr(PARALLEL**2))))
    across = ops.keep((b * b * p - 2.0 * (a * b * q) + a * a * r) * ops.keep(1.0 / safe))
    half = ops.keep(0.5 * (p - r))
    largest = ops.keep(0.5 * (p + r) + ops.sqrt(half * half + q * q))
    variance = ops.keep(ops.choose(square, Symbol(repr(PARALLEL**2)), across, largest))
    excess = ops.keep(sigmas * ops.sqrt(variance) - arc(ops.keep(ops.sqrt(square)), c, ops))
    return ops.choose(c * c + square, Symbol("0.5"), excess, dark)


def arc(sine: Any, cosine: Any, ops: SymbolArithmetic) -> Any:
    """The angle in [0, π] of a sine >= 0 and a cosine, the arc tangent of their quotient."""
    tangent = ops.keep(sine * ops.keep(1.0 / (1.0 + ops.maximum(cosine, -cosine))))
    # that of half the angle from the nearer pole; then of a quarter and an eighth, at most 0.2
    for _ in range(2):
        root = ops.sqrt(1.0 + tangent * tangent)
        tangent = ops.keep(tangent * ops.keep(1.0 / (1.0 + root)))
    square = ops.keep(tangent * tangent)
    series: Any = 0.0
    for n in reversed(range(_TERMS)):
        series = ops.keep(series * square + (-1.0) ** n / (2 * n + 1))
    angle = ops.keep(8.0 * tangent * series)
    return ops.keep(ops.choose(cosine, Symbol("0.0"), angle, math.pi - angle))


def _form(x: Vec3, P: SymbolTriangle, y: Vec3) -> Any:
    """xᵀ P y over the attitude error."""
    return dot(x, Vec3(*(dot(Vec3(*(P[i, j] for j in range(3))), y) for i in range(3))))
