"""Monitored angles of path constraints: extreme angles between directions and body axes, with a
margin.

A path constraint keeps a body axis away from a direction (keep-out) or close to a direction
(keep-in). Within a step at constant rate the angle is extreme where the derivative of its cosine is
zero. In body axes at the end of the step, the body axis a was, at a rotation angle θ before the
end,

    a(θ) = n (n · a) + cos θ (a - n (n · a)) - sin θ (n × a)

with the unit rotation axis n. The direction s moves in a straight line. For a fixed direction, the
derivative of the cosine a · s is a multiple of sin(θ - θ₀), so that its zero follows from its
values at both ends of the step. The motion of the direction changes the derivative so little that
the same formula applies. See docs/explanation/maneuvers-and-constraints.md.

The attitude in a step is controlled with the estimates before the step. The margin therefore uses
the covariance predicted for the end of the step, before the measurements at the end, equation (3)
of docs/explanation/maneuvers-and-constraints.md. The arc tangent and the eigenvalues use only
``+ - * /`` and roots, which the compiled filter executes in vector registers. Scalars are symbols
of generated code, or arrays with one value per step.
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

#: Sine of the angle below which axis and direction are treated as parallel.
_PARALLEL_SINE = 1e-6

#: Number of terms of the arc-tangent series; the next term is below 1e-17 of the angle.
_N_TERMS = 12
#: Squared derivative that is treated as zero.
_MIN_SQUARE = 1e-280


class StepRotation(NamedTuple):
    """Rotation of the body in a filter step, as a unit axis and an angle [rad]."""

    axis: Vec3
    angle: Any
    sine: Any
    cosine: Any

    @classmethod
    def from_rotation_vectors(cls, rotation_vectors: Floats) -> StepRotation:
        angle = np.linalg.norm(rotation_vectors, axis=1)
        axis = Vec3(*(rotation_vectors.T / np.where(angle > 0.0, angle, 1.0)))
        return cls(axis, angle, np.sin(angle), np.cos(angle))


class ExtremePoint(NamedTuple):
    """Point in a filter step at which a body axis is closest to, or farthest from, a direction.

    Attributes
    ----------
    rotation : StepRotation
        Rotation of the body in the step.
    cosine, sine : scalars
        Cosine and sine of the rotation angle from the point to the end of the step.
    remaining_fraction : scalar
        Fraction of the step from the point to the end.
    """

    rotation: StepRotation
    cosine: Any
    sine: Any
    remaining_fraction: Any

    def rotate_to_end(self, v: Vec3) -> Vec3:
        """Return a body-fixed vector at the extreme point, in body axes at the end of the step."""
        n = self.rotation.axis
        along = (1.0 - self.cosine) * dot(n, v)
        rotated: Vec3 = along * n + self.cosine * v - self.sine * cross(n, v)
        return rotated

    def interpolate_direction(self, v: Vec3, change: Vec3) -> Vec3:
        """Return a reference direction at the extreme point, in body axes at the end of the step.

        Parameters
        ----------
        v, change : Vec3
            Direction at the end of the step, and change of the direction in the step. The
            interpolated chord is corrected to the arc.
        """
        bulge = (
            0.5 * self.remaining_fraction * (1.0 - self.remaining_fraction) * dot(change, change)
        )
        direction: Vec3 = (1.0 + bulge) * (v - self.remaining_fraction * change)
        return direction


def find_extreme_point(
    axis: Vec3, keep_in: bool, rotation: StepRotation, v: Vec3, change: Vec3, appears: Any
) -> ExtremePoint:
    """Find the point in a filter step at which a body axis is closest to a direction.

    If `keep_in` is true, the function finds the point at which the body axis is farthest from the
    direction. If there is no extreme within the step, the point is the end of the step, since the
    start is the end of the step before. In a step in which the direction appears, the point is the
    worse of both ends.

    Parameters
    ----------
    axis : Vec3
        Body axis.
    keep_in : bool
        Whether the direction must stay inside the cone about the axis.
    rotation : StepRotation
        Rotation of the body, by less than 180 degrees.
    v, change : Vec3
        Direction at the end of the step, and change of the direction in the step, in body axes at
        the end.
    appears : symbol or array
        1 for a direction that appears in the step, with zero change; 0 otherwise.
    """
    along, normal = dot(rotation.axis, axis), cross(rotation.axis, axis)

    def decompose(u: Vec3) -> tuple[Any, Any, Any]:
        fixed = along * dot(rotation.axis, u)
        return fixed, dot(axis, u) - fixed, dot(normal, u)

    _, q, r = decompose(v)
    # A positive value means that the angle at the start is smaller than the angle at the end.
    start_gain = q * (rotation.cosine - 1.0) - r * rotation.sine
    p_moved, q_moved, r_moved = decompose(change)
    last = rotation.angle * r + p_moved + q_moved
    start_derivative = (q - q_moved) * rotation.sine + (r - r_moved) * rotation.cosine
    first = (
        rotation.angle * start_derivative
        + p_moved
        + q_moved * rotation.cosine
        - r_moved * rotation.sine
    )
    if keep_in:
        first, last, start_gain = -first, -last, -start_gain
    start_is_extreme = appears * start_gain
    x, y = first - last * rotation.cosine, -last * rotation.sine
    square = x * x + y * y
    scale = 1.0 / np.sqrt(choose(square, _MIN_SQUARE, square, 1.0))
    difference = first - last
    # If the derivative is zero at both ends, as for a body at rest, there is no extreme within the
    # step.
    is_within = first
    for condition in (-last, square - _MIN_SQUARE):
        is_within = choose(condition, is_within, is_within, condition)
    fraction = -last * (1.0 / choose(is_within, 0.0, difference, 1.0))
    return ExtremePoint(
        rotation,
        choose(
            is_within, 0.0, x * scale, choose(start_is_extreme, _MIN_SQUARE, rotation.cosine, 1.0)
        ),
        choose(
            is_within, 0.0, y * scale, choose(start_is_extreme, _MIN_SQUARE, rotation.sine, 0.0)
        ),
        choose(is_within, 0.0, fraction, choose(start_is_extreme, _MIN_SQUARE, 1.0, 0.0)),
    )


def compute_monitored_angle(
    cone: Cone,
    sigmas: float,
    rotation_vectors: Floats,
    motion: DirectionMotion,
    covariance: Floats,
) -> Floats:
    """Compute the angle [rad] that a path constraint limits in each filter step.

    A keep-in constraint monitors the largest angle between body axis and direction in the step,
    plus the margin for the attitude uncertainty. Its upper bound is the half-angle of the cone. A
    keep-out constraint monitors the margin minus the smallest angle. Its upper bound is minus the
    half-angle.

    The attitude error is constant in inertial axes throughout a step. The margin is the larger of
    the margins at the extreme angle and at the end of the step.

    Parameters
    ----------
    cone : Cone
        Body axis, and whether the cone must contain the direction.
    sigmas : float
        Margin as a multiple of the 1-sigma of the angle.
    rotation_vectors : array, shape (n, 3)
        Rotation vectors of the body in each step [rad].
    motion : DirectionMotion
        Motion of the direction, in body axes at the end of each step.
    covariance : array, shape (n, 3, 3)
        Covariance of the attitude error [rad²], body axes at the end of each step.

    Returns
    -------
    array, shape (n,)
        Monitored angles [rad]; -inf in a step in which the direction is not visible.
    """
    start, end, start_radius, end_radius, appears = motion
    axis, v, change = Vec3(*cone.axis), Vec3(*end.T), Vec3(*(end - start).T)
    extreme = find_extreme_point(
        axis,
        cone.keep_in,
        StepRotation.from_rotation_vectors(rotation_vectors),
        v,
        change,
        appears.astype(float),
    )
    radius = end_radius - extreme.remaining_fraction * (end_radius - start_radius)
    at_extreme, P = (
        (extreme.rotate_to_end(axis), extreme.interpolate_direction(v, change)),
        np.moveaxis(covariance, 0, -1),
    )
    monitored_angle: Floats = build_monitored_angle(
        at_extreme, (axis, v), sigmas or None, radius, P, cone.keep_in, -np.inf
    )
    return monitored_angle


def compute_monitored_angle_on_orbit(
    cone: Cone,
    sigmas: float,
    states: SatelliteState,
    epoch: datetime,
    attitude: Floats,
    rotation_vectors: Floats,
    covariance: Floats,
) -> Floats:
    """Compute the angle [rad] that a path constraint limits, for given attitudes on an orbit.

    `compute_monitored_angle` defines the monitored angle.

    Parameters
    ----------
    cone, sigmas
        See `compute_monitored_angle`.
    states : SatelliteState
        States of satellite and Sun at the n instants.
    epoch : datetime
        Epoch of the times of the states.
    attitude : array, shape (n, 3, 3)
        GCRS-to-body matrices at the instants.
    rotation_vectors : array, shape (n, 3)
        Rotation vectors since the previous instant [rad], body axes; zero for the first instant.
    covariance : array, shape (n, 3, 3)
        Covariance of the attitude error [rad²], body axes.
    """
    direction = DIRECTIONS[cone.direction]
    vectors = direction.vectors(states, epoch)
    radius = np.zeros(len(vectors)) if direction.radius is None else direction.radius(states)
    motion = DirectionMotion.from_samples(vectors, radius).rotate_to_body(attitude)
    return compute_monitored_angle(cone, sigmas, rotation_vectors, motion, covariance)


def list_cone_constants(constraints: Sequence[PathConstraint]) -> Floats:
    """Return the body axis and the attitude-error margin of each path constraint as one flat array.

    The one-dimensional array contains the body axis of each constraint, followed by its margin in
    1-sigmas if there is one.
    """
    values: list[float] = []
    for constraint in constraints:
        values.extend(constraint.build_cone().axis)
        if PathMonitor.from_constraint(constraint).has_margin:
            values.append(constraint.attitude_sigmas)
    return np.array(values)


def build_monitored_angle(
    extreme_pair: tuple[Vec3, Vec3],
    end_pair: tuple[Vec3, Vec3],
    sigmas: Any,
    radius: Any,
    P: Any,
    keep_in: bool,
    running_maximum: Any,
) -> Any:
    """Return the largest value so far of the angle that a path constraint limits.

    The function accepts numbers, arrays and symbols of generated code. `compute_monitored_angle`
    defines the monitored angle.

    To first order, only a rotation about the common normal of axis and direction changes the angle.
    If axis and direction are parallel, the margin uses the most uncertain rotation about an axis
    perpendicular to the direction.

    Parameters
    ----------
    extreme_pair, end_pair : pairs of Vec3
        Axis and direction at the extreme angle and at the end of the step, as unit vectors in body
        axes at the end. A direction that is not visible is zero, and the result is then
        `running_maximum`.
    sigmas : symbol or float, optional
        Margin as a multiple of the 1-sigma of the angle.
    radius : symbol or array, optional
        Apparent radius [rad] of a disc from whose limb the angle is measured.
    P : Triangle or array, shape (3, 3, n)
        Covariance in which the first three states are the attitude error.
    keep_in : bool
        Whether the direction must stay inside the cone.
    running_maximum : symbol or float
        Largest monitored angle of the previous steps.
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
    monitored_angle = margin + angle if keep_in else margin - angle
    length = cosine * cosine + square
    return choose(length, 0.5, maximum(monitored_angle, running_maximum), running_maximum)


def angle_from_sine_cosine(sine: Any, cosine: Any) -> Any:
    """Compute an angle between 0 and π from its nonnegative sine and its cosine.

    Only ``+ - * /`` and square roots are used.
    """
    tangent = sine * (1.0 / (1.0 + maximum(cosine, -cosine)))
    # The tangent of half the angle is reduced to the tangents of a quarter and of an eighth of the
    # angle, which is at most 0.2.
    for _ in range(2):
        tangent = tangent * (1.0 / (1.0 + np.sqrt(1.0 + tangent * tangent)))
    square, series = tangent * tangent, 0.0
    for n in reversed(range(_N_TERMS)):
        series = series * square + (-1.0) ** n / (2 * n + 1)
    angle = 8.0 * tangent * series
    return choose(cosine, 0.0, angle, math.pi - angle)


def _compute_variance(normal: Vec3, P: Any) -> Any:
    """Return the attitude-error variance about an axis, which need not be a unit vector."""
    square = dot(normal, normal)
    quadratic_form = dot(normal, Vec3(*(dot(row, normal) for row in _list_rows(P))))
    return quadratic_form * (1.0 / choose(square, _PARALLEL_SINE**2, square, _PARALLEL_SINE**2))


def _compute_max_variance(direction: Vec3, P: Any) -> Any:
    """Return the largest attitude-error variance about any axis perpendicular to a direction.

    The value is the larger eigenvalue of the 2 x 2 covariance perpendicular to the direction, from
    its trace and determinant.
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
