"""Reference directions for pointing laws, path constraints and sensor exclusions.

A new direction for path constraints is an entry of `DIRECTIONS`, which scenario files, filter,
simulation and reports use.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple, Self

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.environment import Environment, OrbitSource
from mgeo_attitude.environment.sun_moon import (
    moon_position,
    sun_direction,
    sun_position,
    visible_sun_fraction,
)
from mgeo_attitude.environment.times import compute_julian_dates

#: Sine of the smallest allowed angle between a target and the reference of the clock angle.
_MIN_SINE = 1e-3
#: Cosine of the angle between the pointing axis and ±z above which the clock angle refers to body x
#: instead of body z.
_MAX_Z_COSINE = np.sqrt(0.5)


class SatelliteState(NamedTuple):
    """Satellite position, satellite velocity and Sun direction at n instants.

    Attributes
    ----------
    times : array, shape (n,)
        Times after the epoch [s].
    position, velocity : arrays, shape (n, 3)
        Position [m] and velocity [m/s] of the satellite, GCRS.
    sun : array, shape (n, 3)
        Unit vectors from the satellite to the Sun, GCRS.
    sunlit : array of bool, shape (n,)
        Whether the satellite is in sunlight.
    """

    times: Floats
    position: Floats
    velocity: Floats
    sun: Floats
    sunlit: Bools

    @classmethod
    def from_times(cls, source: OrbitSource, times: Floats) -> Self:
        """Compute the satellite state at given times [s] after the epoch of a scenario.

        Times after the end of the scenario are allowed.
        """
        position, velocity = source.orbit.propagate(source.epoch, times)
        sun = sun_position(compute_julian_dates(source.epoch, times))
        sunlit = visible_sun_fraction(position, sun) >= 0.5
        return cls(times, position, velocity, sun_direction(position, sun), sunlit)

    @classmethod
    def from_first_instant(cls, source: Environment | SatelliteState) -> Self:
        """Build a satellite state from the first sample of an environment or of another state."""
        return cls(*(getattr(source, name)[:1] for name in cls._fields))

    def without_eclipses(self) -> Self:
        """Return a copy in which the satellite is always in sunlight."""
        return self._replace(sunlit=np.ones_like(self.sunlit))


def compute_pointing_attitudes(
    axis: Floats, target: Floats, clock_reference: Floats, clock_angle: float
) -> Floats:
    """Compute attitudes that point a body axis at n target directions. A clock angle sets the
    rotation about this axis.

    The attitude follows from two vectors in the body and two vectors in space, of which the first
    pair is aligned exactly (TRIAD method): H. D. Black, A Passive System for Determining the
    Attitude of a Satellite, AIAA Journal 2 (1964) 1350-1351. The second body vector is z, or x if
    the axis is within 45 degrees of ±z.

    Parameters
    ----------
    axis : array, shape (3,)
        Pointing axis, unit vector in body axes.
    target : array, shape (n, 3)
        Target direction, GCRS, any length.
    clock_reference : array, shape (n, 3)
        Direction closest to the second body vector at a clock angle of zero, GCRS, any length.
    clock_angle : float
        Rotation of the body about `axis` [rad].

    Returns
    -------
    array, shape (n, 3, 3)
        GCRS-to-body matrices.

    Raises
    ------
    ValueError
        If `target` and `clock_reference` are parallel within 0.06 degrees.
    """
    from scipy.spatial.transform import Rotation

    second = np.eye(3)[0 if abs(axis[2]) > _MAX_Z_COSINE else 2]
    clock_rotation = Rotation.from_rotvec(-clock_angle * axis).as_matrix()
    attitude: Floats = (
        clock_rotation @ _build_triads(axis, second).T @ _build_triads(target, clock_reference)
    )
    return attitude


def _build_triads(first: Floats, second: Floats) -> Floats:
    """Build a right-handed orthonormal triad from each pair of vectors.

    The rows of each matrix, shape (..., 3, 3), are the axes of a triad. The first axis is along the
    first vector, and the second axis is in the plane of both vectors.
    """
    x = first / np.linalg.norm(first, axis=-1, keepdims=True)
    normal = np.cross(x, second / np.linalg.norm(second, axis=-1, keepdims=True))
    sine = np.linalg.norm(normal, axis=-1, keepdims=True)
    if (sine < _MIN_SINE).any():
        raise ValueError("the target is parallel to the reference direction of the clock angle")
    z = normal / sine
    return np.stack([x, np.cross(z, x), z], axis=-2)


@dataclass(frozen=True)
class Direction:
    """Reference direction for pointing and constraints, such as the Sun, the nadir or the velocity.

    Attributes
    ----------
    label : str
        Name for display.
    vectors : function of Environment or SatelliteState, and epoch
        Function that returns unit vectors, GCRS, shape (n, 3); zero where the direction is not
        visible.
    radius : function of Environment or SatelliteState, optional
        Function that returns the apparent radius of a disc [rad], shape (n,). Angles are measured
        from the limb of a disc. Without a radius, angles are measured from the direction.
    """

    label: str
    vectors: Callable[[Environment | SatelliteState, datetime], Floats]
    radius: Callable[[Environment | SatelliteState], Floats] | None = None


@dataclass(frozen=True)
class Cone:
    """Keep-in or keep-out cone about a body axis, for a reference direction such as the Sun.

    Attributes
    ----------
    direction : str
        Key of `DIRECTIONS`; empty for the reference vector of a sensor.
    axis : tuple of three float
        Axis of the cone, a unit vector in body axes.
    half_angle : float
        Half-angle of the cone [rad]. The angle of a disc is measured from its limb.
    keep_in : bool
        Whether the cone must contain the direction.
    """

    direction: str
    axis: tuple[float, float, float]
    half_angle: float
    keep_in: bool

    @property
    def is_disc(self) -> bool:
        """True if angles are measured from the limb of the reference object, such as the Earth."""
        return bool(self.direction) and DIRECTIONS[self.direction].radius is not None


class DirectionMotion(NamedTuple):
    """Motion of a reference direction, such as the Sun, during each of n filter steps.

    Each step ends at a sample. The first sample has no step, so that its start equals its end.

    Attributes
    ----------
    start, end : arrays, shape (n, 3)
        Unit vectors at the start and at the end of each step; zero if not visible. A direction that
        is visible at one end only, such as the Sun at the edge of an eclipse, is treated as visible
        during the whole step.
    start_radius, end_radius : arrays, shape (n,)
        Apparent radius of a disc [rad].
    appears : array of bool, shape (n,)
        Whether the direction is visible at the end of the step only. The start of the step is then
        not the visible end of the previous step.
    """

    start: Floats
    end: Floats
    start_radius: Floats
    end_radius: Floats
    appears: Bools

    @classmethod
    def from_samples(cls, vectors: Floats, radius: Floats) -> DirectionMotion:
        """Build the motion from unit vectors, shape (n, 3), and apparent radii, shape (n,), at n
        samples.
        """
        start, start_radius = (np.concatenate([v[:1], v[:-1]]) for v in (vectors, radius))
        visible_at_start: Bools = np.any(start, axis=-1)
        visible_at_end: Bools = np.any(vectors, axis=-1)
        return cls(
            np.where(visible_at_start[:, None], start, vectors),
            np.where(visible_at_end[:, None], vectors, start),
            start_radius,
            radius,
            visible_at_end & ~visible_at_start,
        )

    def select_steps(self, steps: slice | Ints) -> DirectionMotion:
        start, end, start_radius, end_radius, appears = self
        return DirectionMotion(
            start[steps], end[steps], start_radius[steps], end_radius[steps], appears[steps]
        )

    def rotate_to_body(self, attitude: Floats) -> DirectionMotion:
        """Return a copy with the unit vectors rotated from GCRS to body axes.

        The attitude consists of one GCRS-to-body matrix per step, shape (n, 3, 3).
        """
        start, end = (np.einsum("kij,kj->ki", attitude, v) for v in (self.start, self.end))
        return self._replace(start=start, end=end)


def _compute_sun_direction(at: Environment | SatelliteState, epoch: datetime) -> Floats:
    return at.sun * at.sunlit[:, None]


def _compute_nadir(at: Environment | SatelliteState, epoch: datetime) -> Floats:
    return _normalize(-at.position)


def _compute_earth_radius(at: Environment | SatelliteState) -> Floats:
    distance = np.linalg.norm(at.position, axis=1)
    return np.asarray(np.arcsin(EARTH_RADIUS / distance))


def _compute_moon_direction(at: Environment | SatelliteState, epoch: datetime) -> Floats:
    """Return the unit vectors from the satellite to the Moon, ignoring occultation by the Earth."""
    moon = moon_position(compute_julian_dates(epoch, at.times))
    return _normalize(moon - at.position)


def _compute_velocity_direction(at: Environment | SatelliteState, epoch: datetime) -> Floats:
    return _normalize(at.velocity)


def _normalize(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


#: Directions by the value of ``reference`` in a scenario file.
DIRECTIONS: dict[str, Direction] = {
    "sun": Direction("Sun", _compute_sun_direction),
    "earth": Direction("Earth", _compute_nadir, _compute_earth_radius),
    "nadir": Direction("nadir", _compute_nadir),
    "moon": Direction("Moon", _compute_moon_direction),
    "velocity": Direction("velocity", _compute_velocity_direction),
}


def compute_directions(names: tuple[str, ...], environment: Environment, epoch: datetime) -> Floats:
    """Return unit vectors along named directions, such as the Sun, at each time of an environment.

    The names are keys of `DIRECTIONS`. The unit vectors are in GCRS, shape (n_times, n_names, 3).
    """
    vectors = [DIRECTIONS[name].vectors(environment, epoch) for name in names]
    return np.stack(vectors, axis=1) if names else np.zeros((len(environment.times), 0, 3))


def compute_radii(names: tuple[str, ...], environment: Environment) -> Floats:
    """Return apparent radii [rad] of named objects, such as the Earth, at each time of an
    environment.

    The names are keys of `DIRECTIONS`. The result has shape (n_times, n_names). It is 0 for an
    object that is not treated as a disc.
    """
    result = np.zeros((len(environment.times), len(names)))
    for index, name in enumerate(names):
        radius = DIRECTIONS[name].radius
        if radius is not None:
            result[:, index] = radius(environment)
    return result
