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
from .symbols import Symbol

Floats = NDArray[np.float64]

#: Terms of the arc tangent's series; the next one is below 1e-17 of the angle.
_TERMS = 12


def cone_constants(axes: Floats, sigmas: Floats) -> Floats:
    """What the kernel needs of keep-out cones, one after the other.

    Of a cone with a margin a right-handed frame, row by row, whose first vector is the axis, and
    the margin; of others the axis.

    Parameters
    ----------
    axes : array, shape (n, 3)
    sigmas : array, shape (n,)
    """
    values: list[float] = []
    for axis, k in zip(axes, sigmas, strict=True):
        values.extend(axis)
        if k > 0.0:
            first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
            first /= np.linalg.norm(first)
            values.extend([*first, *np.cross(axis, first), k])
    return np.array(values)


def sun_excess(frame: Sequence[Vec3], sigmas: Symbol, sun: Vec3, P: Any, dark: Symbol) -> Symbol:
    """Margin less angle between the Sun and an axis; `dark` where the Sun does not shine.

    Parameters
    ----------
    frame : three Vec3
        See `cone_constants`.
    sigmas : Symbol
        Margin, in 1-sigmas of the angle.
    sun : Vec3
        Unit vector to the Sun or zero, body axes.
    P : Triangle
        Covariance, whose first three states are the attitude error.
    """
    axis, one, two = frame
    c, a, b = (dot(v, sun) for v in (axis, one, two))
    square = a * a + b * b
    p, q, r = (_form(x, P, y) for x, y in ((one, one), (one, two), (two, two)))
    # the normal of axis and Sun is (a two - b one) / sine
    safe = square.choose(PARALLEL**2, square, PARALLEL**2)
    across = (b * b * p - 2.0 * (a * b * q) + a * a * r) * (1.0 / safe)
    half = 0.5 * (p - r)
    largest = 0.5 * (p + r) + np.sqrt(half * half + q * q)
    variance = square.choose(PARALLEL**2, across, largest)
    excess = sigmas * np.sqrt(variance) - arc(np.sqrt(square), c)
    result: Symbol = (c * c + square).choose(0.5, excess, dark)
    return result


def arc(sine: Symbol, cosine: Symbol) -> Symbol:
    """The angle in [0, π] of a sine >= 0 and a cosine, the arc tangent of their quotient."""
    tangent: Any = sine * (1.0 / (1.0 + cosine.maximum(-cosine)))
    # that of half the angle from the nearer pole; then of a quarter and an eighth, at most 0.2
    for _ in range(2):
        tangent = tangent * (1.0 / (1.0 + np.sqrt(1.0 + tangent * tangent)))
    square, series = tangent * tangent, 0.0
    for n in reversed(range(_TERMS)):
        series = series * square + (-1.0) ** n / (2 * n + 1)
    angle = 8.0 * tangent * series
    return cosine.choose(0.0, angle, math.pi - angle)


def _form(x: Vec3, P: Any, y: Vec3) -> Any:
    """xᵀ P y over the attitude error."""
    return dot(x, Vec3(*(dot(Vec3(*(P[i, j] for j in range(3))), y) for i in range(3))))
