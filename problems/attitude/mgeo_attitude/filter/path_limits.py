"""Angles between directions and body axes that must stay off or on them, less a margin.

Within a step of constant rate a direction is nearest to a body axis, or farthest from it, where the
slope of their cosine is zero. In body axes of the end of the step the body axis a was, an angle θ
before it, at

    a(θ) = n (n · a) + cos θ (a - n (n · a)) - sin θ (n × a)

with the unit axis n of the turn, and the direction moved straight from where it was to where it is.
The slope of the cosine a · s, per step, is for a fixed direction a multiple of sin(θ - θ₀), so that
it is known from both ends where it is zero; what the direction moves meanwhile changes it by so
little that the same holds. See docs/theory.md, path limits.

The attitude in a step was flown on what the filter knew until then: the margin is taken from the
covariance as predicted for its end, before the measurements there. Equation (14) of docs/theory.md.
The arc tangent and the eigenvalues are made of nothing but ``+ - * /`` and roots, which the kernel
runs in vector registers; scalars are its symbols, or arrays of one number a step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import DIRECTIONS, Cone, Passage, Place
from mgeo_attitude.filter.layout import Watch
from mgeo_attitude.geometry.vector import Vec3, choose, cross, dot, maximum
from mgeo_attitude.scenario.limits import PathLimit

#: Sine of the angle below which both are parallel: no single turn changes the angle then.
_PARALLEL = 1e-6

#: Terms of the arc tangent's series; the next one is below 1e-17 of the angle.
_TERMS = 12
#: Below this the square of a slope is zero.
_TINY = 1e-280


class Turn(NamedTuple):
    """What the body turns by in a step: unit axis and angle, with its sine and cosine."""

    axis: Vec3
    angle: Any
    sine: Any
    cosine: Any

    @classmethod
    def of(cls, turn: Floats) -> Turn:
        """Return the turns of n steps, rotation vectors of shape (n, 3) [rad]."""
        angle = np.linalg.norm(turn, axis=1)
        axis = Vec3(*(turn.T / np.where(angle > 0.0, angle, 1.0)))
        return cls(axis, angle, np.sin(angle), np.cos(angle))


class Nearest(NamedTuple):
    """How much there is to turn from the nearest place on, and which share of the step is left."""

    turn: Turn
    cosine: Any
    sine: Any
    share: Any

    def back(self, v: Vec3) -> Vec3:
        """A body axis as it then is, in body axes of the end."""
        n = self.turn.axis
        along = (1.0 - self.cosine) * dot(n, v)
        turned: Vec3 = along * n + self.cosine * v - self.sine * cross(n, v)
        return turned

    def seen(self, v: Vec3, moved: Vec3) -> Vec3:
        """The direction, in body axes of the end: from the chord to the arc."""
        bulge = 0.5 * self.share * (1.0 - self.share) * dot(moved, moved)
        direction: Vec3 = (1.0 + bulge) * (v - self.share * moved)
        return direction


def nearest(axis: Vec3, inside: bool, turn: Turn, v: Vec3, moved: Vec3, appears: Any) -> Nearest:
    """Where a direction is nearest to an axis or, to keep `inside`, farthest from it.

    Where that is not within the step, its end is taken: the beginning is the end of another one,
    unless the direction appears in this one. Then the worse of both ends is taken.

    Parameters
    ----------
    turn : Turn
        By less than half a turn.
    v, moved : Vec3
        The direction at the end of the step, and by how much it moved in it, body axes of the end.
    appears : symbol or array
        1 for a direction that appears in the step, and then has not moved; else 0.
    """
    along, normal = dot(turn.axis, axis), cross(turn.axis, axis)

    def parts(u: Vec3) -> tuple[Any, Any, Any]:
        fixed = along * dot(turn.axis, u)
        return fixed, dot(axis, u) - fixed, dot(normal, u)

    _, q, r = parts(v)
    nearer = q * (turn.cosine - 1.0) - r * turn.sine  # at the beginning than at the end
    p_moved, q_moved, r_moved = parts(moved)
    last = turn.angle * r + p_moved + q_moved
    turned = (q - q_moved) * turn.sine + (r - r_moved) * turn.cosine
    first = turn.angle * turned + p_moved + q_moved * turn.cosine - r_moved * turn.sine
    if inside:
        first, last, nearer = -first, -last, -nearer
    begins = appears * nearer
    x, y = first - last * turn.cosine, -last * turn.sine
    square = x * x + y * y
    scale = 1.0 / np.sqrt(choose(square, _TINY, square, 1.0))
    fall = first - last
    # what is zero at both ends, as of a body at rest, has no extreme within
    within = first
    for other in (-last, square - _TINY):
        within = choose(other, within, within, other)
    share = -last * (1.0 / choose(within, 0.0, fall, 1.0))
    return Nearest(
        turn,
        choose(within, 0.0, x * scale, choose(begins, _TINY, turn.cosine, 1.0)),
        choose(within, 0.0, y * scale, choose(begins, _TINY, turn.sine, 0.0)),
        choose(within, 0.0, share, choose(begins, _TINY, 1.0, 0.0)),
    )


def excess(cone: Cone, sigmas: float, turn: Floats, passage: Passage, covariance: Floats) -> Floats:
    """Margin less the least angle of a direction and an axis in each of n steps [rad], shape (n,).

    To keep inside, margin and the greatest angle. What is unknown of the attitude is the same
    throughout the step, in inertial axes. What of the angle depends on it changes as the direction
    passes: the margin is the greater of those at the nearest place and at the end.

    Parameters
    ----------
    sigmas : float
        Margin, in 1-sigmas of the angle.
    turn, passage
        What the body turns by, shape (n, 3) [rad], and the direction, in body axes of the end of
        each step. Where there is nothing to be seen the excess is -inf.
    covariance : array, shape (n, 3, 3)
        Of the attitude error, body axes of the end [rad²].
    """
    before, after, radius_before, radius_after, appears = passage
    axis, v, moved = Vec3(*cone.axis), Vec3(*after.T), Vec3(*(after - before).T)
    there = nearest(axis, cone.inside, Turn.of(turn), v, moved, appears.astype(float))
    radius = radius_after - there.share * (radius_after - radius_before)
    here, P = (there.back(axis), there.seen(v, moved)), np.moveaxis(covariance, 0, -1)
    found: Floats = excess_code(here, (axis, v), sigmas or None, radius, P, cone.inside, -np.inf)
    return found


def excess_along(
    cone: Cone,
    sigmas: float,
    at: Place,
    epoch: datetime,
    attitude: Floats,
    turn: Floats,
    covariance: Floats,
) -> Floats:
    """The `excess` in steps to places of an orbit, shape (n,).

    Parameters
    ----------
    attitude : array, shape (n, 3, 3)
        GCRS to body at the places.
    turn : array, shape (n, 3)
        What the body turned by since the place before [rad], body axes; zero for the first.
    """
    direction = DIRECTIONS[cone.direction]
    vectors = direction.vectors(at, epoch)
    radius = np.zeros(len(vectors)) if direction.radius is None else direction.radius(at)
    passage = Passage.of(vectors, radius).seen(attitude)
    return excess(cone, sigmas, turn, passage, covariance)


def cone_constants(limits: Sequence[PathLimit]) -> Floats:
    """What the kernel needs of path limits: of each its axis, and the margin if there is one."""
    values: list[float] = []
    for limit in limits:
        values.extend(limit.cone().axis)
        if Watch.of(limit).margin:
            values.append(limit.attitude_sigmas)
    return np.array(values)


def excess_code(
    there: tuple[Vec3, Vec3],
    end: tuple[Vec3, Vec3],
    sigmas: Any,
    radius: Any,
    P: Any,
    inside: bool,
    until_now: Any,
) -> Any:
    """The `excess` over symbols or arrays, no less than what it was until now.

    What changes the angle is a turn about the normal of both, and about no other direction to first
    order. Where axis and direction are parallel, the least known turn across the axis counts.

    Parameters
    ----------
    there, end : pairs of Vec3
        Axis and direction, body axes of the end, where they are nearest and at the end; unit
        vectors, or zero of a direction that is not seen: the result is then `until_now`.
    sigmas : symbol or float, optional
        Margin, in 1-sigmas of the angle.
    radius : symbol or array, optional
        Apparent radius of the disc from whose limb the angle counts.
    P : Triangle or array, shape (3, 3, n)
        Covariance, whose first three states are the attitude error.
    """
    normal, cosine = cross(*there), dot(*there)
    square = dot(normal, normal)
    margin: Any = 0.0
    if sigmas is not None:
        here, last = _variance(normal, P), _variance(cross(*end), P)
        variance = maximum(choose(square, _PARALLEL**2, here, _largest(there[1], P)), last)
        margin = sigmas * np.sqrt(variance)
    angle = arc(np.sqrt(square), cosine)
    if radius is not None:
        angle = angle - radius
    found = margin + angle if inside else margin - angle
    length = cosine * cosine + square
    return choose(length, 0.5, maximum(found, until_now), until_now)


def arc(sine: Any, cosine: Any) -> Any:
    """The angle in [0, π] of a sine >= 0 and a cosine, the arc tangent of their quotient."""
    tangent = sine * (1.0 / (1.0 + maximum(cosine, -cosine)))
    # that of half the angle from the nearer pole; then of a quarter and an eighth, at most 0.2
    for _ in range(2):
        tangent = tangent * (1.0 / (1.0 + np.sqrt(1.0 + tangent * tangent)))
    square, series = tangent * tangent, 0.0
    for n in reversed(range(_TERMS)):
        series = series * square + (-1.0) ** n / (2 * n + 1)
    angle = 8.0 * tangent * series
    return choose(cosine, 0.0, angle, math.pi - angle)


def _variance(normal: Vec3, P: Any) -> Any:
    """Of a turn about a vector of any length; nearly zero where that has hardly one."""
    square = dot(normal, normal)
    form = dot(normal, Vec3(*(dot(row, normal) for row in _rows(P))))
    return form * (1.0 / choose(square, _PARALLEL**2, square, _PARALLEL**2))


def _largest(direction: Vec3, P: Any) -> Any:
    """Variance of the least known turn across a direction, from both invariants of P there."""
    x, y, z = _rows(P)
    cofactors = Vec3(
        *(dot(direction, column) for column in (cross(y, z), cross(z, x), cross(x, y)))
    )
    along = dot(direction, Vec3(*(dot(row, direction) for row in (x, y, z))))
    half = 0.5 * (x.x + y.y + z.z - along)
    apart = half * half - dot(direction, cofactors)
    return half + np.sqrt(choose(apart, 0.0, apart, 0.0))


def _rows(P: Any) -> list[Vec3]:
    """Of the attitude error."""
    return [Vec3(*(P[i, j] for j in range(3))) for i in range(3)]
