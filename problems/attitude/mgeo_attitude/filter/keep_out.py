"""How near the Sun comes to body axes that must stay off it, with a margin for the attitude.

The attitude at a sample was flown on what the filter knew until then: the margin is taken from the
covariance as predicted, before the measurements of that sample. Equation (14) of docs/theory.md.
It is here twice, in NumPy and as straight-line code of the kernel, written apart: over symbols, in
a frame of the axis, and with an arc tangent from nothing but ``+ - * /`` and roots, which run in
vector registers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._typing import Floats
from ..vector import Vec3, dot
from .symbols import Symbol

#: Sine of the angle below which Sun and axis are parallel: no single turn changes the angle then.
_PARALLEL = 1e-6

#: Terms of the arc tangent's series; the next one is below 1e-17 of the angle.
_TERMS = 12


def sun_clearance(axis: Floats, sigmas: float, sun: Floats, covariance: Floats) -> Floats:
    """Angle between the Sun and an axis, less so many of its 1-sigmas [rad], shape (n,).

    Parameters
    ----------
    axis : array, shape (3,)
        Unit vector, body axes.
    sigmas : float
        Margin, in 1-sigmas of the angle.
    sun : array, shape (n, 3)
        Unit vector to the Sun, body axes; zero where it does not shine, and there is no angle:
        infinity.
    covariance : array, shape (n, 3, 3)
        Of the attitude error, body axes [rad²].
    """
    sine = np.linalg.norm(np.cross(axis, sun), axis=-1)
    angle = np.arctan2(sine, sun @ axis)
    clearance: Floats = np.where(
        sun.any(axis=-1), angle - sigmas * angle_sigma(axis, sun, covariance), np.inf
    )
    return clearance


def angle_sigma(axis: Floats, sun: Floats, covariance: Floats) -> Floats:
    """1-sigma of the angle between the Sun and an axis [rad], shape (n,); see `sun_clearance`.

    A turn about the normal of both changes the angle, and about no other direction to first order.
    Where they are parallel there is no normal: of all turns across the axis the least known counts.
    """
    normal = np.cross(axis, sun)
    sine = np.linalg.norm(normal, axis=-1)
    parallel = sine < _PARALLEL
    unit = normal / np.where(parallel, 1.0, sine)[:, None]
    variance = np.einsum("ki,kij,kj->k", unit, covariance, unit)
    across = np.eye(3) - np.outer(axis, axis)
    variance[parallel] = np.linalg.eigvalsh(across @ covariance[parallel] @ across)[:, -1]
    sigma: Floats = np.sqrt(variance)
    return sigma


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
    safe = square.choose(_PARALLEL**2, square, _PARALLEL**2)
    across = (b * b * p - 2.0 * (a * b * q) + a * a * r) * (1.0 / safe)
    half = 0.5 * (p - r)
    largest = 0.5 * (p + r) + np.sqrt(half * half + q * q)
    variance = square.choose(_PARALLEL**2, across, largest)
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
