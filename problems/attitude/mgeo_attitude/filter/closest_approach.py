"""Where within a step of constant rate a direction is nearest to a body axis, or farthest from it.

In body axes of the end of the step the body axis a was, an angle θ before it, at

    a(θ) = n (n · a) + cos θ (a - n (n · a)) - sin θ (n × a)

with the unit axis n of the turn, and the direction moved straight from where it was to where it is.
The slope of the cosine a · s, per step, is for a fixed direction a multiple of sin(θ - θ₀), so that
it is known from both ends where it is zero; what the direction moves meanwhile changes it by so
little that the same holds. See docs/theory.md, path limits. Scalars are symbols of the kernel, or
arrays of one number a step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.vector import Vec3, choose, cross, dot

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
