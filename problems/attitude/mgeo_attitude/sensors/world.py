"""Errors of what is outside the satellite: of the field, of the orbit, of light from the Earth.

Each is one 3-vector of the error state, whatever the number of sensors that see it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.sun_moon import above_limb, earthlight
from mgeo_attitude.sensors.errors import GaussMarkov, check_considered
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import ARCMIN, NonNegative, Seconds, Triple, Unit

#: Unit of the field inside the filter [nT], so that every state is of order one or less.
FIELD_UNIT_NT = 50_000.0
NT = Unit("nT", "nt", FIELD_UNIT_NT)

#: Unit of errors of the position inside the filter [m].
POSITION_UNIT = 1000.0

#: How many 1-sigmas of the orbit's error an eclipse has to be away from what Sun sensors say: an
#: edge is no derivative that a filter could have.
SURE = 3.0


@dataclass(frozen=True)
class World(Settings):
    """What field, orbit and light from the Earth are beside their models.

    Gauss-Markov processes, all off unless wanted. Those of field and light are in GCRS axes.

    Examples
    --------
    >>> from mgeo_attitude import World
    >>> list(World(field_error_nt=150.0, orbit_error_m=(2000.0, 200.0, 200.0)).states())
    ['field_error', 'orbit_error']
    """

    #: See `Sensor.units`.
    units: ClassVar[Mapping[str, Unit]] = {
        "albedo": ARCMIN,
        "field_error": NT,
        "orbit_error": Unit("m", "m", POSITION_UNIT),
    }

    field_error_nt: Annotated[float, Unit("nT")] = Field(default=0.0, ge=0.0)
    """error of the field's model, 1-sigma per axis; 0 leaves the states out"""
    field_error_correlation_time: Seconds = Field(default=300.0, gt=0.0)
    """correlation time of the error of the field's model along the orbit"""
    orbit_error_m: Annotated[Triple[NonNegative], Unit("m")] = (0.0, 0.0, 0.0)
    """error of the position at which the model is asked, 1-sigma along track, across and radial;
    zeros leave the states out. What sees the Sun is not used within 3-sigma of an eclipse's edge"""
    orbit_error_axes: Literal["orbital", "inertial"] = "orbital"
    """axes in which it varies, and has these 1-sigmas: along, across and radial, or GCRS"""
    orbit_error_correlation_time: Seconds = Field(default=20000.0, gt=0.0)
    """correlation time of the error of the position"""
    earth_albedo: float = Field(default=0.0, ge=0.0, le=1.0)
    """share of sunlight that the Earth throws back, as a matt sphere, onto Sun sensors that see it;
    0 leaves that out"""
    albedo: float = Field(default=0.0, ge=0.0)
    """error of the unit vector by light from the Earth beside that, 1-sigma per axis; 0 leaves the
    states out"""
    albedo_correlation_time: Seconds = Field(default=600.0, gt=0.0)
    """correlation time of the error by light from the Earth"""
    considered: tuple[str, ...] = ()
    """its states that are not estimated, but whose uncertainty counts (Schmidt-Kalman)"""

    def __post_init__(self) -> None:
        size = self.orbit_error_m
        expect(all(size) == any(size), "orbit_error_m", size, "three numbers > 0 m, or all zero")
        check_considered(self.considered, self.states())

    def states(self) -> dict[str, GaussMarkov]:
        """Error states that it adds, 3-vectors; see `Sensor.states`."""
        along, across, radial = (sigma / POSITION_UNIT for sigma in self.orbit_error_m)
        field = self.field_error_nt / FIELD_UNIT_NT
        found = {
            "albedo": GaussMarkov(self.albedo, self.albedo_correlation_time),
            "field_error": GaussMarkov(field, self.field_error_correlation_time),
            "orbit_error": GaussMarkov((along, across, radial), self.orbit_error_correlation_time),
        }
        return {state: process for state, process in found.items() if np.any(process.sigma)}

    @property
    def has_orbit_error(self) -> bool:
        """Whether the orbit is another than is believed, and with it where the Sun shines."""
        return any(self.orbit_error_m)

    def around(self, environment: Environment) -> Environment:
        """An environment as sensors know it: where the Sun is sure to shine, and light beside it.

        With an orbit error the Sun is sure to shine where it does after `SURE` times its 1-sigma,
        and light from the Earth is its mean.
        """
        changes: dict[str, Any] = {}
        if self.has_orbit_error and environment.shadow:
            changes["sunlit"] = environment.sunlit & self._surely_lit(environment)
        if self.earth_albedo:
            light = earthlight(environment.position, environment.sun)
            changes["earthlight"] = self.earth_albedo * light
        return dataclasses.replace(environment, **changes) if changes else environment

    def _surely_lit(self, environment: Environment) -> Bools:
        """Where no likely error of the orbit brings the satellite into the Earth's shadow."""
        here, sun = environment.position, environment.sun
        angle = above_limb(here, sun)
        axes = np.broadcast_to(np.eye(3), (len(here), 3, 3))
        off = self.by_orbit_error(axes, environment) * np.array(self.orbit_error_m)
        moved = [above_limb(here + off[:, :, k], sun) - angle for k in range(3)]
        sure: Bools = angle > SURE * np.linalg.norm(moved, axis=0)
        return sure

    def displaced(self, environment: Environment, orbit_error: Floats) -> Environment:
        """The same where the satellite is with errors of the orbit, shape (n, 3), as states.

        Of it the position and where the Sun shines are there; field and Sun are left as they are.
        """
        axes = np.broadcast_to(np.eye(3), (len(orbit_error), 3, 3))
        off = np.einsum("kij,kj->ki", self.by_orbit_error(axes, environment), orbit_error)
        there = environment.position + POSITION_UNIT * off
        lit = above_limb(there, environment.sun) > 0.0 if environment.shadow else environment.sunlit
        return dataclasses.replace(environment, position=there, sunlit=lit)

    def by_orbit_error(self, gradient: Floats, environment: Environment) -> Floats:
        """The derivative by the orbit error's state of what has a `gradient` by the position.

        Both of shape (n, 3, 3), GCRS in rows, and `gradient` in columns.
        """
        if self.orbit_error_axes == "inertial":
            return gradient
        radial = environment.position / np.linalg.norm(environment.position, axis=1)[:, None]
        across = np.cross(environment.position, environment.velocity)
        across /= np.linalg.norm(across, axis=1)[:, None]
        axes = np.stack([np.cross(across, radial), across, radial], axis=2)
        found: Floats = gradient @ axes
        return found
