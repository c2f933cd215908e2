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
from mgeo_attitude.environment.environment import Environment, OrbitSource
from mgeo_attitude.environment.sun_moon import (
    moon_position,
    sun_direction,
    sun_position,
    visible_sun_fraction,
)
from mgeo_attitude.environment.times import compute_julian_dates

#: Sine of the least angle between a target and the reference of the clock angle.
_MIN_SINE = 1e-3
#: Body z defines the clock angle up to this cosine of its angle to the pointing axis, body x above.
_MAX_Z_COSINE = np.sqrt(0.5)


class SatelliteState(NamedTuple):
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
    def from_times(cls, source: OrbitSource, times: Floats) -> Self:
        """Compute the state at `times` [s] after a scenario's epoch, also after its run."""
        position, velocity = source.orbit.propagate(source.epoch, times)
        center = sun_position(compute_julian_dates(source.epoch, times))
        lit = visible_sun_fraction(position, center) >= 0.5
        return cls(times, position, velocity, sun_direction(position, center), lit)

    @classmethod
    def from_first_row(cls, tables: Environment | SatelliteState) -> Self:
        """Return the state in the first row of tables."""
        return cls(*(getattr(tables, name)[:1] for name in cls._fields))

    def without_eclipses(self) -> Self:
        """Return the state without eclipses."""
        return self._replace(sunlit=np.ones_like(self.sunlit))


def compute_pointing_attitudes(
    axis: Floats, target: Floats, clock_reference: Floats, clock_angle: float
) -> Floats:
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
    clock_reference : array, shape (n, 3)
        Direction closest to the second body vector at a clock angle of zero, GCRS, any length.
    clock_angle : float
        Rotation of the body about `axis` [rad].

    Raises
    ------
    ValueError
        If `target` and `clock_reference` are parallel within 0.06 degrees.
    """
    from scipy.spatial.transform import Rotation

    second = np.eye(3)[0 if abs(axis[2]) > _MAX_Z_COSINE else 2]
    turn = Rotation.from_rotvec(-clock_angle * axis).as_matrix()
    attitude: Floats = turn @ _build_triads(axis, second).T @ _build_triads(target, clock_reference)
    return attitude


def _build_triads(first: Floats, second: Floats) -> Floats:
    """Return right-handed orthonormal axes, row by row, shape (..., 3, 3).

    The first axis is along the first vector, the second in the plane of both vectors.
    """
    one = first / np.linalg.norm(first, axis=-1, keepdims=True)
    normal = np.cross(one, second / np.linalg.norm(second, axis=-1, keepdims=True))
    sine = np.linalg.norm(normal, axis=-1, keepdims=True)
    if (sine < _MIN_SINE).any():
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
    vectors: Callable[[Environment | SatelliteState, datetime], Floats]
    radius: Callable[[Environment | SatelliteState], Floats] | None = None


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
    keep_in : bool
        Whether the cone must contain the direction.
    """

    direction: str
    axis: tuple[float, float, float]
    half_angle: float
    keep_in: bool

    @property
    def is_disc(self) -> bool:
        """Whether the direction is that of a disc."""
        return bool(self.direction) and DIRECTIONS[self.direction].radius is not None


class DirectionMotion(NamedTuple):
    """A direction during n steps of a run.

    Each step leads to a sample. The first sample has no step before it.

    Attributes
    ----------
    start, end : arrays, shape (n, 3)
        Unit vectors at the start and at the end of each step; zero if not visible. A direction that
        is visible at one end only, such as the Sun at the edge of an eclipse, counts for the whole
        step.
    start_radius, end_radius : arrays, shape (n,)
        Apparent radius of a disc [rad].
    appears : array of bool, shape (n,)
        Whether the direction is visible at the end of the step only, so that the previous step does
        not evaluate the start.
    """

    start: Floats
    end: Floats
    start_radius: Floats
    end_radius: Floats
    appears: Bools

    @classmethod
    def from_samples(cls, vectors: Floats, radius: Floats) -> DirectionMotion:
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

    def select_steps(self, steps: slice | Ints) -> DirectionMotion:
        """Return a selection of the steps."""
        before, after, radius_before, radius_after, appears = self
        return DirectionMotion(
            before[steps], after[steps], radius_before[steps], radius_after[steps], appears[steps]
        )

    def rotate_to_body(self, attitude: Floats) -> DirectionMotion:
        """Rotate the passage to body axes by the attitudes at the samples, shape (n, 3, 3)."""
        before, after = (np.einsum("kij,kj->ki", attitude, v) for v in (self.start, self.end))
        return self._replace(start=before, end=after)


def _compute_sun_direction(at: Environment | SatelliteState, epoch: datetime) -> Floats:
    return at.sun * at.sunlit[:, None]


def _compute_nadir(at: Environment | SatelliteState, epoch: datetime) -> Floats:
    return _normalize(-at.position)


def _compute_earth_radius(at: Environment | SatelliteState) -> Floats:
    distance = np.linalg.norm(at.position, axis=1)
    return np.asarray(np.arcsin(EARTH_RADIUS / distance))


def _compute_moon_direction(at: Environment | SatelliteState, epoch: datetime) -> Floats:
    """Return the direction of the Moon, even where the Earth hides it."""
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
    """Return the unit vectors of several `DIRECTIONS` along a run, shape (n, m, 3)."""
    vectors = [DIRECTIONS[name].vectors(environment, epoch) for name in names]
    return np.stack(vectors, axis=1) if names else np.zeros((len(environment.times), 0, 3))


def compute_radii(names: tuple[str, ...], environment: Environment) -> Floats:
    """Return the apparent radii of several `DIRECTIONS` [rad], shape (n, m)."""
    result = np.zeros((len(environment.times), len(names)))
    for index, name in enumerate(names):
        radius = DIRECTIONS[name].radius
        if radius is not None:
            result[:, index] = radius(environment)
    return result
