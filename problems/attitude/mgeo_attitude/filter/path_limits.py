"""Angles between directions and body axes that must stay off or on them, less a margin.

The attitude at a sample was flown on what the filter knew until then: the margin is taken from the
covariance as predicted, before the measurements of that sample. Equation (14) of docs/theory.md.
It is here twice, in NumPy and as straight-line code of the kernel, written apart: over symbols, in
a frame of the axis, and with an arc tangent from nothing but ``+ - * /`` and roots, which run in
vector registers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import DIRECTIONS, Cone
from mgeo_attitude.filter.layout import Watch
from mgeo_attitude.filter.symbols import Symbol
from mgeo_attitude.rotation import across
from mgeo_attitude.scenario.path_limits import PathLimit
from mgeo_attitude.vector import Vec3, dot

if TYPE_CHECKING:
    from mgeo_attitude.environment.pointing import Place

#: Sine of the angle below which both are parallel: no single turn changes the angle then.
_PARALLEL = 1e-6

#: Terms of the arc tangent's series; the next one is below 1e-17 of the angle.
_TERMS = 12


def excess(
    cone: Cone, sigmas: float, direction: Floats, covariance: Floats, radius: ArrayLike = 0.0
) -> Floats:
    """Margin less angle between a direction and an axis or, to keep inside, margin and angle [rad].

    Parameters
    ----------
    cone : Cone
    sigmas : float
        Margin, in 1-sigmas of the angle.
    direction : array, shape (n, 3)
        Unit vectors, body axes; zero where there is nothing to be seen, and the excess is -inf.
    covariance : array, shape (n, 3, 3)
        Of the attitude error, body axes [rad²].
    radius : array, shape (n,)
        Apparent radius of the disc from whose limb the angle counts [rad].

    Returns
    -------
    array, shape (n,)
    """
    axis = np.array(cone.axis)
    sine = np.linalg.norm(np.cross(axis, direction), axis=-1)
    angle = np.arctan2(sine, direction @ axis) - radius
    margin = sigmas * angle_sigma(axis, direction, covariance)
    found: Floats = np.where(
        direction.any(axis=-1), margin + angle if cone.inside else margin - angle, -np.inf
    )
    return found


def excess_at(
    cone: Cone, sigmas: float, at: Place, epoch: datetime, attitude: Floats, covariance: Floats
) -> Floats:
    """The `excess` at places of an orbit, for attitudes, GCRS to body, shape (n, 3, 3)."""
    direction = DIRECTIONS[cone.direction]
    seen = np.einsum("kij,kj->ki", attitude, direction.vectors(at, epoch))
    radius = 0.0 if direction.radius is None else direction.radius(at)
    return excess(cone, sigmas, seen, covariance, radius)


def angle_sigma(axis: Floats, direction: Floats, covariance: Floats) -> Floats:
    """1-sigma of the angle between a direction and an axis [rad], shape (n,); see `excess`.

    A turn about the normal of both changes the angle, and about no other direction to first order.
    Where they are parallel there is no normal: of all turns across the axis the least known counts.
    """
    normal = np.cross(axis, direction)
    sine = np.linalg.norm(normal, axis=-1)
    parallel = sine < _PARALLEL
    unit = normal / np.where(parallel, 1.0, sine)[:, None]
    variance = np.einsum("ki,kij,kj->k", unit, covariance, unit)
    across = np.eye(3) - np.outer(axis, axis)
    variance[parallel] = np.linalg.eigvalsh(across @ covariance[parallel] @ across)[:, -1]
    sigma: Floats = np.sqrt(variance)
    return sigma


def cone_constants(limits: Sequence[PathLimit]) -> Floats:
    """What the kernel needs of path limits, one after the other.

    Of one with a margin or of any that is not `plain` a right-handed frame, row by row, whose first
    vector is the axis of the cone; then the margin, if there is one. Of others the axis.
    """
    values: list[float] = []
    for limit in limits:
        watch, axis = Watch.of(limit), np.array(limit.cone().axis)
        values.extend(axis)
        if not watch.plain:
            values.extend(across(axis).ravel())
        if watch.margin:
            values.append(limit.attitude_sigmas)
    return np.array(values)


def excess_code(
    frame: Sequence[Vec3],
    sigmas: Symbol | None,
    direction: Vec3,
    radius: Symbol | None,
    P: Any,
    inside: bool,
    dark: Symbol,
) -> Symbol:
    """The kernel's `excess`.

    Parameters
    ----------
    frame : three Vec3
        See `cone_constants`.
    sigmas : Symbol, optional
        Margin, in 1-sigmas of the angle.
    direction : Vec3
        Unit vector, body axes, or zero: the result is then `dark`.
    radius : Symbol, optional
        Apparent radius of the disc from whose limb the angle counts.
    P : Triangle
        Covariance, whose first three states are the attitude error.
    """
    axis, one, two = frame
    c, a, b = (dot(v, direction) for v in (axis, one, two))
    square = a * a + b * b
    margin: Any = 0.0
    if sigmas is not None:
        p, q, r = (_form(x, P, y) for x, y in ((one, one), (one, two), (two, two)))
        # the normal of axis and direction is (a two - b one) / sine
        safe = square.choose(_PARALLEL**2, square, _PARALLEL**2)
        normal = (b * b * p - 2.0 * (a * b * q) + a * a * r) * (1.0 / safe)
        half = 0.5 * (p - r)
        largest = 0.5 * (p + r) + np.sqrt(half * half + q * q)
        variance = square.choose(_PARALLEL**2, normal, largest)
        margin = sigmas * np.sqrt(variance)
    angle = arc(np.sqrt(square), c)
    if radius is not None:
        angle = angle - radius
    seen: Symbol = (c * c + square).choose(0.5, margin + angle if inside else margin - angle, dark)
    return seen


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
