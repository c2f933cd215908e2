"""Violation of path constraints: extreme angles between directions and body axes, with a margin.

A path constraint keeps a body axis away from a direction (keep-out) or close to it (keep-in).
Within a step at constant rate the angle is extreme where the slope of its cosine is zero. In body
axes at the end of the step, the body axis a at an angle θ before the end was

    a(θ) = n (n · a) + cos θ (a - n (n · a)) - sin θ (n × a)

with the unit rotation axis n. The direction s moves in a straight line. For a fixed direction the
slope of the cosine a · s is a multiple of sin(θ - θ₀), so that its zero follows from its values at
both ends. The motion of the direction changes the slope so little that the same formula applies.
See docs/theory.md, path limits.

The attitude in a step is controlled with the estimates from before the step. The margin therefore
uses the covariance predicted for the end of the step, before the measurements there; equation (14)
of docs/theory.md. The arc tangent and the eigenvalues use only ``+ - * /`` and roots, which the
kernel runs in vector registers. Scalars are kernel symbols, or arrays of one number per step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import DIRECTIONS, Cone, DirectionMotion, SatelliteState
from mgeo_attitude.filter.layout import PathMonitor
from mgeo_attitude.geometry.vector import Vec3, choose, cross, dot, maximum
from mgeo_attitude.scenario.constraints import PathConstraint

#: Sine of the angle below which axis and direction count as parallel, without a common normal.
_PARALLEL_SINE = 1e-6

#: Number of terms of the arc-tangent series; the next term is below 1e-17 of the angle.
_N_TERMS = 12
#: Squared slope that counts as zero.
_MIN_SQUARE = 1e-280


class StepRotation(NamedTuple):
    """Rotation of the body in a step: unit axis, angle [rad], sine and cosine of the angle."""

    axis: Vec3
    angle: Any
    sine: Any
    cosine: Any

    @classmethod
    def from_rotation_vectors(cls, rotation_vectors: Floats) -> StepRotation:
        """Return the rotations of n steps from rotation vectors, shape (n, 3) [rad]."""
        angle = np.linalg.norm(rotation_vectors, axis=1)
        axis = Vec3(*(rotation_vectors.T / np.where(angle > 0.0, angle, 1.0)))
        return cls(axis, angle, np.sin(angle), np.cos(angle))


class ExtremePoint(NamedTuple):
    """Point of a step at which the angle between an axis and a direction is extreme.

    Attributes
    ----------
    rotation : Turn
        Rotation of the body in the step.
    cosine, sine : scalars
        Of the rotation angle that remains from the point to the end of the step.
    remaining_fraction : scalar
        Share of the step that remains.
    """

    rotation: StepRotation
    cosine: Any
    sine: Any
    remaining_fraction: Any

    def rotate_to_end(self, v: Vec3) -> Vec3:
        """Rotate a body-fixed vector from the attitude at the point to the end of the step."""
        n = self.rotation.axis
        along = (1.0 - self.cosine) * dot(n, v)
        rotated: Vec3 = along * n + self.cosine * v - self.sine * cross(n, v)
        return rotated

    def interpolate_direction(self, v: Vec3, change: Vec3) -> Vec3:
        """Return the direction at the point, in body axes at the end of the step.

        Parameters
        ----------
        v, change : Vec3
            Direction at the end of the step, and its change in the step. The interpolated chord is
            corrected to the arc.
        """
        bulge = (
            0.5 * self.remaining_fraction * (1.0 - self.remaining_fraction) * dot(change, change)
        )
        direction: Vec3 = (1.0 + bulge) * (v - self.remaining_fraction * change)
        return direction


def find_extreme_point(
    axis: Vec3, keep_in: bool, rotation: StepRotation, v: Vec3, change: Vec3, appears: Any
) -> ExtremePoint:
    """Return the point of a step with the smallest angle to an axis, or the largest if `keep_in`.

    If there is no extreme within the step, the point is the end of the step; the start is the end
    of the step before. In a step in which the direction appears, the point is the worse of both
    ends.

    Parameters
    ----------
    axis : Vec3
        Body axis.
    keep_in : bool
        Whether the direction must stay inside the cone about the axis.
    rotation : Turn
        Rotation of the body, by less than 180 degrees.
    v, change : Vec3
        Direction at the end of the step, and its change in the step, body axes at the end.
    appears : symbol or array
        1 for a direction that appears in the step, with zero change; else 0.
    """
    along, normal = dot(rotation.axis, axis), cross(rotation.axis, axis)

    def parts(u: Vec3) -> tuple[Any, Any, Any]:
        fixed = along * dot(rotation.axis, u)
        return fixed, dot(axis, u) - fixed, dot(normal, u)

    _, q, r = parts(v)
    # A positive value means that the angle at the start is smaller than at the end.
    nearer = q * (rotation.cosine - 1.0) - r * rotation.sine
    p_moved, q_moved, r_moved = parts(change)
    last = rotation.angle * r + p_moved + q_moved
    turned = (q - q_moved) * rotation.sine + (r - r_moved) * rotation.cosine
    first = rotation.angle * turned + p_moved + q_moved * rotation.cosine - r_moved * rotation.sine
    if keep_in:
        first, last, nearer = -first, -last, -nearer
    start_is_extreme = appears * nearer
    x, y = first - last * rotation.cosine, -last * rotation.sine
    square = x * x + y * y
    scale = 1.0 / np.sqrt(choose(square, _MIN_SQUARE, square, 1.0))
    fall = first - last
    # A slope of zero at both ends, as for a body at rest, has no extreme within the step.
    within = first
    for other in (-last, square - _MIN_SQUARE):
        within = choose(other, within, within, other)
    share = -last * (1.0 / choose(within, 0.0, fall, 1.0))
    return ExtremePoint(
        rotation,
        choose(within, 0.0, x * scale, choose(start_is_extreme, _MIN_SQUARE, rotation.cosine, 1.0)),
        choose(within, 0.0, y * scale, choose(start_is_extreme, _MIN_SQUARE, rotation.sine, 0.0)),
        choose(within, 0.0, share, choose(start_is_extreme, _MIN_SQUARE, 1.0, 0.0)),
    )


def compute_violation(
    cone: Cone,
    sigmas: float,
    rotation_vectors: Floats,
    passage: DirectionMotion,
    covariance: Floats,
) -> Floats:
    """Return the margin minus the smallest angle of a direction and an axis, per step [rad].

    For a keep-in constraint, return the margin plus the largest angle. The attitude error is
    constant in inertial axes throughout a step. The margin is the larger of the margins at the
    extreme angle and at the end of the step.

    Parameters
    ----------
    cone : Cone
        Axis and kind of the constraint.
    sigmas : float
        Margin, in 1-sigmas of the angle.
    rotation_vectors : array, shape (n, 3)
        Rotation vectors of the body [rad].
    passage : Passage
        Motion of the direction, in body axes at the end of each step.
    covariance : array, shape (n, 3, 3)
        Covariance of the attitude error [rad²], body axes at the end.

    Returns
    -------
    array, shape (n,)
        -inf in a step in which the direction is not visible.
    """
    before, after, radius_before, radius_after, appears = passage
    axis, v, moved = Vec3(*cone.axis), Vec3(*after.T), Vec3(*(after - before).T)
    extreme = find_extreme_point(
        axis,
        cone.keep_in,
        StepRotation.from_rotation_vectors(rotation_vectors),
        v,
        moved,
        appears.astype(float),
    )
    radius = radius_after - extreme.remaining_fraction * (radius_after - radius_before)
    at_extreme, P = (
        (extreme.rotate_to_end(axis), extreme.interpolate_direction(v, moved)),
        np.moveaxis(covariance, 0, -1),
    )
    margin_excess: Floats = build_violation(
        at_extreme, (axis, v), sigmas or None, radius, P, cone.keep_in, -np.inf
    )
    return margin_excess


def compute_violation_on_orbit(
    cone: Cone,
    sigmas: float,
    states: SatelliteState,
    epoch: datetime,
    attitude: Floats,
    rotation_vectors: Floats,
    covariance: Floats,
) -> Floats:
    """Return `excess` in the steps that lead to n places of an orbit.

    Parameters
    ----------
    cone, sigmas
        See `excess`.
    states : Place
        Places of the orbit.
    epoch : datetime
        Time from which the times of the places count.
    attitude : array, shape (n, 3, 3)
        GCRS-to-body matrices at the places.
    rotation_vectors : array, shape (n, 3)
        Rotation vectors since the place before [rad], body axes; zero for the first place.
    covariance : array, shape (n, 3, 3)
        Covariance of the attitude error [rad²], body axes.
    """
    direction = DIRECTIONS[cone.direction]
    vectors = direction.vectors(states, epoch)
    radius = np.zeros(len(vectors)) if direction.radius is None else direction.radius(states)
    passage = DirectionMotion.from_samples(vectors, radius).rotate_to_body(attitude)
    return compute_violation(cone, sigmas, rotation_vectors, passage, covariance)


def list_cone_constants(constraints: Sequence[PathConstraint]) -> Floats:
    """Return the axis of each path constraint, followed by its margin [sigmas] if it has one."""
    values: list[float] = []
    for limit in constraints:
        values.extend(limit.build_cone().axis)
        if PathMonitor.from_constraint(limit).has_margin:
            values.append(limit.attitude_sigmas)
    return np.array(values)


def build_violation(
    extreme_pair: tuple[Vec3, Vec3],
    end_pair: tuple[Vec3, Vec3],
    sigmas: Any,
    radius: Any,
    P: Any,
    keep_in: bool,
    running_maximum: Any,
) -> Any:
    """Return `excess` over symbols or arrays, or `running_maximum` if that is larger.

    To first order only a rotation about the common normal of axis and direction changes the angle.
    If axis and direction are parallel, the margin uses the most uncertain rotation across the
    direction.

    Parameters
    ----------
    extreme_pair, end_pair : pairs of Vec3
        Axis and direction at the extreme angle and at the end of the step, body axes at the end.
        Unit vectors; a direction that is not visible is zero, and the result is then `running_maximum`.
    sigmas : symbol or float, optional
        Margin, in 1-sigmas of the angle.
    radius : symbol or array, optional
        Apparent radius [rad] of a disc from whose limb the angle is measured.
    P : Triangle or array, shape (3, 3, n)
        Covariance whose first three states are the attitude error.
    keep_in : bool
        Whether the direction must stay inside the cone.
    running_maximum : symbol or float
        Largest value so far.
    """
    normal, cosine = cross(*extreme_pair), dot(*extreme_pair)
    square = dot(normal, normal)
    margin: Any = 0.0
    if sigmas is not None:
        extreme_variance, last = (
            _compute_variance(normal, P),
            _compute_variance(cross(*end_pair), P),
        )
        variance = maximum(
            choose(
                square,
                _PARALLEL_SINE**2,
                extreme_variance,
                _compute_max_variance(extreme_pair[1], P),
            ),
            last,
        )
        margin = sigmas * np.sqrt(variance)
    angle = angle_from_sine_cosine(np.sqrt(square), cosine)
    if radius is not None:
        angle = angle - radius
    violation = margin + angle if keep_in else margin - angle
    length = cosine * cosine + square
    return choose(length, 0.5, maximum(violation, running_maximum), running_maximum)


def angle_from_sine_cosine(sine: Any, cosine: Any) -> Any:
    """Return the angle in [0, π] with a nonnegative sine and a cosine, without an arc tangent."""
    tangent = sine * (1.0 / (1.0 + maximum(cosine, -cosine)))
    # The tangent of half the angle becomes that of a quarter and an eighth, which is at most 0.2.
    for _ in range(2):
        tangent = tangent * (1.0 / (1.0 + np.sqrt(1.0 + tangent * tangent)))
    square, series = tangent * tangent, 0.0
    for n in reversed(range(_N_TERMS)):
        series = series * square + (-1.0) ** n / (2 * n + 1)
    angle = 8.0 * tangent * series
    return choose(cosine, 0.0, angle, math.pi - angle)


def _compute_variance(normal: Vec3, P: Any) -> Any:
    """Return the variance of a rotation about a normal, which need not be a unit vector."""
    square = dot(normal, normal)
    form = dot(normal, Vec3(*(dot(row, normal) for row in _list_rows(P))))
    return form * (1.0 / choose(square, _PARALLEL_SINE**2, square, _PARALLEL_SINE**2))


def _compute_max_variance(direction: Vec3, P: Any) -> Any:
    """Return the largest variance of a rotation about any axis across a direction.

    The 2 x 2 covariance across the direction enters by its two invariants.
    """
    x, y, z = _list_rows(P)
    cofactors = Vec3(
        *(dot(direction, column) for column in (cross(y, z), cross(z, x), cross(x, y)))
    )
    along = dot(direction, Vec3(*(dot(row, direction) for row in (x, y, z))))
    half = 0.5 * (x.x + y.y + z.z - along)
    discriminant = half * half - dot(direction, cofactors)
    return half + np.sqrt(choose(discriminant, 0.0, discriminant, 0.0))


def _list_rows(P: Any) -> list[Vec3]:
    return [Vec3(*(P[i, j] for j in range(3))) for i in range(3)]
