"""Attitudes that point a body axis at a direction, and what orbits and the Sun give to point at."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.sun_moon import lit_fraction, sun_direction, sun_position
from mgeo_attitude.environment.time_frames import instants

if TYPE_CHECKING:
    from mgeo_attitude.environment.environment import Course, Environment

#: Sine of the least angle between a target and what the clock angle is counted from.
_LEAST_SINE = 1e-3
#: Body z gives the clock angle up to this cosine of its angle to the pointing axis, then body x.
_NEAR_Z = np.sqrt(0.5)


class Place(NamedTuple):
    """Where a satellite is at n instants, as an `Environment` has it.

    Attributes
    ----------
    times : array, shape (n,)
        [s] after the epoch.
    position, velocity : arrays, shape (n, 3)
        [m], [m/s], GCRS.
    sun : array, shape (n, 3)
        Unit vectors to the Sun, GCRS.
    sunlit : array of bool, shape (n,)
    """

    times: Floats
    position: Floats
    velocity: Floats
    sun: Floats
    sunlit: Bools

    @classmethod
    def at(cls, course: Course, times: Floats, *, sun: bool = True) -> Self:
        """At `times` [s] after the epoch of a scenario, which may be later than its run ends.

        Without the Sun, whose place takes longest, that is NaN and nothing is sunlit.
        """
        position, velocity = course.orbit.propagate(course.epoch, times)
        if not sun:
            nowhere = np.full_like(position, np.nan)
            return cls(times, position, velocity, nowhere, np.zeros(len(times), dtype=bool))
        center = sun_position(instants(course.epoch, times))
        lit = lit_fraction(position, center) >= 0.5
        return cls(times, position, velocity, sun_direction(position, center), lit)

    @classmethod
    def first_of(cls, environment: Environment, row: int = 0) -> Self:
        """That of the first row of its tables, or of another one."""
        return cls(*(getattr(environment, name)[row : row + 1] for name in cls._fields))

    def row(self, number: int) -> Self:
        """One of them."""
        return type(self)(*(getattr(self, name)[number : number + 1] for name in self._fields))

    def without_shadow(self) -> Self:
        """The same with the Sun shining always."""
        return self._replace(sunlit=np.ones_like(self.sunlit))


def pointed(axis: Floats, target: Floats, toward: Floats, clock: float) -> Floats:
    """Attitudes at which a body axis points at a target, GCRS to body, shape (n, 3, 3).

    Two vectors of the body, of which the first is exactly where it should be, and two in space:
    H. D. Black, A Passive System for Determining the Attitude of a Satellite, AIAA Journal 2 (1964)
    1350-1351. Body z, or x if the axis is within 45 degrees of ±z, is the second one.

    Parameters
    ----------
    axis : array, shape (3,)
        Unit vector, body axes.
    target : array, shape (n, 3)
        What it points at, GCRS, any length.
    toward : array, shape (n, 3)
        What the second body axis is nearest to at no clock angle, GCRS, any length.
    clock : float
        Angle by which the body is then turned about `axis` [rad].

    Raises
    ------
    ValueError
        If `target` and `toward` are parallel within 0.06 degrees.
    """
    from scipy.spatial.transform import Rotation

    second = np.eye(3)[0 if abs(axis[2]) > _NEAR_Z else 2]
    turn = Rotation.from_rotvec(-clock * axis).as_matrix()
    attitude: Floats = turn @ _triads(axis, second).T @ _triads(target, toward)
    return attitude


def _triads(first: Floats, second: Floats) -> Floats:
    """Right-handed unit vectors, row by row, shape (..., 3, 3): the first vector's, and the part
    of the second that is across it."""
    one = first / np.linalg.norm(first, axis=-1, keepdims=True)
    normal = np.cross(one, second / np.linalg.norm(second, axis=-1, keepdims=True))
    sine = np.linalg.norm(normal, axis=-1, keepdims=True)
    if (sine < _LEAST_SINE).any():
        raise ValueError("the target is parallel to what the clock angle is counted from")
    three = normal / sine
    return np.stack([one, np.cross(three, one), three], axis=-2)
