"""Reference directions for pointing laws, path constraints and sensor exclusions.

A new direction for path constraints is an entry of `DIRECTIONS`. Scenario files, filter, simulation
and reports use the entries.
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

#: Sine of the least angle between a target and the reference of the clock angle.
_LEAST_SINE = 1e-3
#: Body z defines the clock angle up to this cosine of its angle to the pointing axis, body x above.
_NEAR_Z = np.sqrt(0.5)


class Place(NamedTuple):
    """State of the satellite and the Sun at n instants.

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
        """Compute the state at `times` [s] after a scenario's epoch, also after its run."""
        position, velocity = course.orbit.propagate(course.epoch, times)
        center = sun_position(instants(course.epoch, times))
        lit = lit_fraction(position, center) >= 0.5
        return cls(times, position, velocity, sun_direction(position, center), lit)

    @classmethod
    def row(cls, of: Environment | Place) -> Self:
        """Return the state in the first row of tables."""
        return cls(*(getattr(of, name)[:1] for name in cls._fields))

    def without_shadow(self) -> Self:
        """Return the state without eclipses."""
        return self._replace(sunlit=np.ones_like(self.sunlit))


def pointed(axis: Floats, target: Floats, toward: Floats, clock: float) -> Floats:
    """Return the attitudes that point a body axis at a target, GCRS to body, shape (n, 3, 3).

    The attitude follows from two vectors in the body and two in space, of which the first pair is
    aligned exactly: H. D. Black, A Passive System for Determining the Attitude of a Satellite, AIAA
    Journal 2 (1964) 1350-1351. The second body vector is z, or x if the axis is within 45 degrees
    of ±z.

    Parameters
    ----------
    axis : array, shape (3,)
        Pointing axis, unit vector in body axes.
    target : array, shape (n, 3)
        Target direction, GCRS, any length.
    toward : array, shape (n, 3)
        Direction closest to the second body vector at a clock angle of zero, GCRS, any length.
    clock : float
        Rotation of the body about `axis` [rad].

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
    """Return right-handed orthonormal axes, row by row, shape (..., 3, 3).

    The first axis is along the first vector, the second in the plane of both vectors.
    """
    one = first / np.linalg.norm(first, axis=-1, keepdims=True)
    normal = np.cross(one, second / np.linalg.norm(second, axis=-1, keepdims=True))
    sine = np.linalg.norm(normal, axis=-1, keepdims=True)
    if (sine < _LEAST_SINE).any():
        raise ValueError("the target is parallel to the reference direction of the clock angle")
    three = normal / sine
    return np.stack([one, np.cross(three, one), three], axis=-2)


@dataclass(frozen=True)
class Direction:
    """A direction from the satellite.

    Attributes
    ----------
    label : str
        Name for display.
    vectors : function of Environment or Place, and epoch
        Return unit vectors, GCRS, shape (n, 3); zero where the direction is not visible.
    radius : function of Environment or Place, optional
        Return the apparent radius of a disc [rad], shape (n,). Angles are measured from the limb of
        a disc, or from the direction itself without a radius.
    """

    label: str
    vectors: Callable[[Environment | Place, datetime], Floats]
    radius: Callable[[Environment | Place], Floats] | None = None


@dataclass(frozen=True)
class Cone:
    """A cone about a body axis that must contain or exclude a direction.

    Attributes
    ----------
    direction : str
        Key of `DIRECTIONS`; empty for the reference vector of a sensor.
    axis : tuple of three float
        Unit vector, body axes.
    half_angle : float
        [rad], measured from the limb of a disc.
    inside : bool
        Whether the cone must contain the direction.
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
    """A direction during n steps of a run.

    Each step leads to a sample. The first sample has no step before it.

    Attributes
    ----------
    before, after : arrays, shape (n, 3)
        Unit vectors at the start and at the end of each step; zero if not visible. A direction that
        is visible at one end only, such as the Sun at the edge of an eclipse, counts for the whole
        step.
    radius_before, radius_after : arrays, shape (n,)
        Apparent radius of a disc [rad].
    appears : array of bool, shape (n,)
        Whether the direction is visible at the end of the step only, so that the previous step does
        not evaluate the start.
    """

    before: Floats
    after: Floats
    radius_before: Floats
    radius_after: Floats
    appears: Bools

    @classmethod
    def of(cls, vectors: Floats, radius: Floats) -> Passage:
        """Return the passage for directions, shape (n, 3), and radii, shape (n,), at samples."""
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
        """Return a selection of the steps."""
        before, after, radius_before, radius_after, appears = self
        return Passage(before[of], after[of], radius_before[of], radius_after[of], appears[of])

    def seen(self, attitude: Floats) -> Passage:
        """Rotate the passage to body axes by the attitudes at the samples, shape (n, 3, 3)."""
        before, after = (np.einsum("kij,kj->ki", attitude, v) for v in (self.before, self.after))
        return self._replace(before=before, after=after)


def _sun(at: Environment | Place, epoch: datetime) -> Floats:
    return at.sun * at.sunlit[:, None]


def _nadir(at: Environment | Place, epoch: datetime) -> Floats:
    return _unit(-at.position)


def _earth_radius(at: Environment | Place) -> Floats:
    distance = np.linalg.norm(at.position, axis=1)
    return np.asarray(np.arcsin(EARTH_RADIUS / distance))


def _moon(at: Environment | Place, epoch: datetime) -> Floats:
    """Return the direction of the Moon, even where the Earth hides it."""
    moon = moon_position(instants(epoch, at.times))
    return _unit(moon - at.position)


def _velocity(at: Environment | Place, epoch: datetime) -> Floats:
    return _unit(at.velocity)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


#: Directions by the value of ``reference`` in a scenario file.
DIRECTIONS: dict[str, Direction] = {
    "sun": Direction("Sun", _sun),
    "earth": Direction("Earth", _nadir, _earth_radius),
    "nadir": Direction("nadir", _nadir),
    "moon": Direction("Moon", _moon),
    "velocity": Direction("velocity", _velocity),
}


def directions(names: tuple[str, ...], environment: Environment, epoch: datetime) -> Floats:
    """Return the unit vectors of several `DIRECTIONS` along a run, shape (n, m, 3)."""
    vectors = [DIRECTIONS[name].vectors(environment, epoch) for name in names]
    return np.stack(vectors, axis=1) if names else np.zeros((len(environment.times), 0, 3))


def radii(names: tuple[str, ...], environment: Environment) -> Floats:
    """Return the apparent radii of several `DIRECTIONS` [rad], shape (n, m)."""
    result = np.zeros((len(environment.times), len(names)))
    for index, name in enumerate(names):
        radius = DIRECTIONS[name].radius
        if radius is not None:
            result[:, index] = radius(environment)
    return result
