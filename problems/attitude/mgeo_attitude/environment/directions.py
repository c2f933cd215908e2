"""Directions that body axes are pointed at, or kept off or on, and that blind sensors.

To add one to be kept off or on is to add an entry of `DIRECTIONS`: scenario files, filter, its
kernel, simulation and reports take it from there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple, Self

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.environment import Course, Environment
from mgeo_attitude.environment.sun_moon import (
    lit_fraction,
    moon_position,
    sun_direction,
    sun_position,
)
from mgeo_attitude.environment.times import instants

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
    def at(cls, course: Course, times: Floats) -> Self:
        """At `times` [s] after the epoch of a scenario, which may be later than its run ends."""
        position, velocity = course.orbit.propagate(course.epoch, times)
        center = sun_position(instants(course.epoch, times))
        lit = lit_fraction(position, center) >= 0.5
        return cls(times, position, velocity, sun_direction(position, center), lit)

    @classmethod
    def row(cls, of: Environment | Place) -> Self:
        """Return the place of the first row of tables."""
        return cls(*(getattr(of, name)[:1] for name in cls._fields))

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


@dataclass(frozen=True)
class Direction:
    """A direction from the satellite.

    Attributes
    ----------
    label : str
        What it is called for people.
    vectors : function of Environment or Place, and epoch
        Unit vectors at its times, GCRS, shape (n, 3); zero where there is nothing to be seen.
    radius : function of Environment or Place, optional
        Apparent radius of a disc [rad], shape (n,), from whose limb angles count; without it they
        count from the direction itself.
    """

    label: str
    vectors: Callable[[Environment | Place, datetime], Floats]
    radius: Callable[[Environment | Place], Floats] | None = None


@dataclass(frozen=True)
class Cone:
    """A cone about a body axis that a direction has to be inside of, or outside.

    Attributes
    ----------
    direction : str
        One of `DIRECTIONS`; empty for what a sensor looks at.
    axis : tuple of three float
        Unit vector, body axes.
    half_angle : float
        [rad]; of a disc it counts from the limb.
    inside : bool
        Whether the direction has to be inside.
    """

    direction: str
    axis: tuple[float, float, float]
    half_angle: float
    inside: bool

    @property
    def disc(self) -> bool:
        """Whether the direction is that of a disc."""
        return bool(self.direction) and DIRECTIONS[self.direction].radius is not None


class Passage(NamedTuple):
    """A direction in n steps of a run, each of which leads to a sample; its first has no step.

    Attributes
    ----------
    before, after : arrays, shape (n, 3)
        Unit vectors at the beginning of the step and at its end; zero where there is nothing to be
        seen. What is seen at one end alone, as the Sun where a shadow begins or ends, counts in the
        whole step.
    radius_before, radius_after : arrays, shape (n,)
        Apparent radius of a disc [rad].
    appears : array of bool, shape (n,)
        Whether it is seen at the end alone: the step before does not judge this one's beginning.
    """

    before: Floats
    after: Floats
    radius_before: Floats
    radius_after: Floats
    appears: Bools

    @classmethod
    def of(cls, vectors: Floats, radius: Floats) -> Passage:
        """Of what is given at samples, shapes (n, 3) and (n,)."""
        before, radius_before = (np.concatenate([v[:1], v[:-1]]) for v in (vectors, radius))
        starts: Bools = np.any(before, axis=-1)
        ends: Bools = np.any(vectors, axis=-1)
        return cls(
            np.where(starts[:, None], before, vectors),
            np.where(ends[:, None], vectors, before),
            radius_before,
            radius,
            ends & ~starts,
        )

    def rows(self, of: slice | Ints) -> Passage:
        """Some of its steps."""
        before, after, radius_before, radius_after, appears = self
        return Passage(before[of], after[of], radius_before[of], radius_after[of], appears[of])

    def seen(self, attitude: Floats) -> Passage:
        """The same in body axes of the samples, for attitudes, GCRS to body, shape (n, 3, 3)."""
        before, after = (np.einsum("kij,kj->ki", attitude, v) for v in (self.before, self.after))
        return self._replace(before=before, after=after)


def _sun(at: Environment | Place, epoch: datetime) -> Floats:
    """While it shines."""
    return at.sun * at.sunlit[:, None]


def _nadir(at: Environment | Place, epoch: datetime) -> Floats:
    return _unit(-at.position)


def _earth_radius(at: Environment | Place) -> Floats:
    """Of a sphere without an atmosphere, as it casts the shadow."""
    distance = np.linalg.norm(at.position, axis=1)
    return np.asarray(np.arcsin(EARTH_RADIUS / distance))


def _moon(at: Environment | Place, epoch: datetime) -> Floats:
    """From the satellite, whether the Earth hides it or not."""
    moon = moon_position(instants(epoch, at.times))
    return _unit(moon - at.position)


def _velocity(at: Environment | Place, epoch: datetime) -> Floats:
    """Relative to GCRS."""
    return _unit(at.velocity)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


#: Directions by the ``reference`` that names them in a scenario file.
DIRECTIONS: dict[str, Direction] = {
    "sun": Direction("Sun", _sun),
    "earth": Direction("Earth", _nadir, _earth_radius),
    "nadir": Direction("nadir", _nadir),
    "moon": Direction("Moon", _moon),
    "velocity": Direction("velocity", _velocity),
}


def directions(names: tuple[str, ...], environment: Environment, epoch: datetime) -> Floats:
    """Some of `DIRECTIONS` along a run, shape (n, m, 3)."""
    vectors = [DIRECTIONS[name].vectors(environment, epoch) for name in names]
    return np.stack(vectors, axis=1) if names else np.zeros((len(environment.times), 0, 3))


def radii(names: tuple[str, ...], environment: Environment) -> Floats:
    """Their apparent radii [rad], zero for what is no disc; shape (n, m)."""
    found = np.zeros((len(environment.times), len(names)))
    for index, name in enumerate(names):
        radius = DIRECTIONS[name].radius
        if radius is not None:
            found[:, index] = radius(environment)
    return found
