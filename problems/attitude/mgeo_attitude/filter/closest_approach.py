"""Where within a step of constant rate a direction is nearest to a body axis, or farthest from it.

In body axes of the end of the step the body axis a was, an angle θ before it, at

    a(θ) = n (n · a) + cos θ (a - n (n · a)) - sin θ (n × a)

with the unit axis n of the turn, and the direction moved straight from where it was to where it is.
The slope of the cosine a · s, per step, is for a fixed direction a multiple of sin(θ - θ₀), so that
it is known from both ends where it is zero; what the direction moves meanwhile changes it by so
little that the same holds. See docs/theory.md, path limits. It is here twice, in NumPy and as code
of the kernel, as in `path_limits`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import Cone, Passage
from mgeo_attitude.filter.symbols import Symbol
from mgeo_attitude.geometry.rotation import exponential
from mgeo_attitude.geometry.vector import Vec3, cross, dot

#: Below this the square of a slope is zero.
_TINY = 1e-280


class Nearest(NamedTuple):
    """A direction as it is nearest to an axis within each of n steps, or at its end.

    Attributes
    ----------
    seen : array, shape (n, 3)
        Unit vectors, body axes of that time; zero where there is nothing to be seen.
    radius : array, shape (n,)
        Apparent radius of the disc [rad].
    back : array, shape (n, 3, 3)
        From body axes of the end of the step to those of that time.
    """

    seen: Floats
    radius: Floats
    back: Floats


def nearest(cone: Cone, turn: Floats, passage: Passage) -> Nearest:
    """Where a direction is nearest to the axis of a cone or, to keep inside, farthest from it.

    Where that is not within the step, its end is taken: the beginning is the end of another one,
    unless the direction appears in this one. Then the worse of both ends is taken.

    Parameters
    ----------
    turn : array, shape (n, 3)
        What the body turns by in each step, body axes, by less than half a turn [rad].
    passage : Passage
        In body axes of the end of each step.
    """
    before, after, radius_before, radius_after, appears = passage
    axis, sign = np.array(cone.axis), -1.0 if cone.inside else 1.0
    angle, moved = np.linalg.norm(turn, axis=1), after - before
    started = np.einsum("ijk,i->kj", exponential(turn.T), axis)
    first, last = (
        sign * np.einsum("ki,ki->k", np.cross(turn, a), v) + sign * np.einsum("ki,ki->k", a, moved)
        for a, v in ((started, before), (np.broadcast_to(axis, turn.shape), after))
    )
    within = (first > 0.0) & (last < 0.0)
    left = np.arctan2(-last * np.sin(angle), first - last * np.cos(angle))
    at_first, at_last = np.einsum("ki,ki->k", started, before), after @ axis
    begins = appears & ~within & (sign * at_first > sign * at_last)
    theta = np.where(within, left, np.where(begins, angle, 0.0))
    theta = theta / np.where(angle > 0.0, angle, 1.0)
    share = np.where(within, last, begins) / np.where(within, last - first, 1.0)
    back = np.moveaxis(exponential((theta[:, None] * turn).T), -1, 0)
    seen = np.einsum("kij,kj->ki", back, after - share[:, None] * moved)
    length = np.linalg.norm(seen, axis=1, keepdims=True)
    radius = radius_after - share * (radius_after - radius_before)
    return Nearest(seen / np.where(length > 0.0, length, 1.0), radius, back)


@dataclass(frozen=True)
class Turn:
    """What the body turns by in a step, as code: unit axis and angle, with its sine and cosine."""

    axis: Vec3
    angle: Symbol
    sine: Symbol
    cosine: Symbol


class NearestCode(NamedTuple):
    """The kernel's `nearest`: how much there is to turn, and which share of the step is left."""

    turn: Turn
    cosine: Symbol
    sine: Symbol
    share: Symbol

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


def nearest_code(
    axis: Vec3, inside: bool, turn: Turn, v: Vec3, moved: Vec3, appears: Symbol
) -> NearestCode:
    """As code, of a direction v in body axes of the end that has `moved` in the step.

    One that `appears` in it, 1 or 0, has not moved.
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
    scale = 1.0 / np.sqrt(square.choose(_TINY, square, 1.0))
    fall = first - last
    # what is zero at both ends, as of a body at rest, has no extreme within
    within = _least(first, -last, square - _TINY)
    share = -last * (1.0 / within.choose(0.0, fall, 1.0))
    return NearestCode(
        turn,
        within.choose(0.0, x * scale, begins.choose(_TINY, turn.cosine, 1.0)),
        within.choose(0.0, y * scale, begins.choose(_TINY, turn.sine, 0.0)),
        within.choose(0.0, share, begins.choose(_TINY, 1.0, 0.0)),
    )


def _least(first: Symbol, *others: Symbol) -> Symbol:
    for other in others:
        first = other.choose(first, first, other)
    return first
