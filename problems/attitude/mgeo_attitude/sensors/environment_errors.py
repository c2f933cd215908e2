"""Environment model errors: geomagnetic field, orbit and albedo.

Each error is one 3-vector of the error state, shared by all sensors.
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
from mgeo_attitude.environment.sun_moon import albedo_vector, sun_limb_angle
from mgeo_attitude.sensors.error_models import GaussMarkov, check_considered
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import ARCMIN, NonNegative, Seconds, Triple, Unit

#: Unit of the field inside the filter [nT], so that every state is of order one or less.
FIELD_UNIT_NT = 50_000.0
NT = Unit("nT", "nt", FIELD_UNIT_NT)

#: Unit of errors of the position inside the filter [m].
POSITION_UNIT = 1000.0

#: Margin between a Sun measurement and an eclipse, in 1-sigmas of the orbit error: the edge of the
#: shadow has no derivative that a filter could use.
ECLIPSE_MARGIN_SIGMAS = 3.0


@dataclass(frozen=True)
class EnvironmentErrors(Settings):
    """Errors of the models of field, orbit and albedo as Gauss-Markov processes, off by default.

    The errors of field and albedo are in GCRS axes.

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
    """error of the field model, 1-sigma per axis; 0 omits the states"""
    field_error_correlation_time: Seconds = Field(default=300.0, gt=0.0)
    """correlation time of the field model error along the orbit"""
    orbit_error_m: Annotated[Triple[NonNegative], Unit("m")] = (0.0, 0.0, 0.0)
    """error of the position used by the models, 1-sigma along track, across track and radial; zeros
    omit the states. Sun measurements within 3-sigma of an eclipse's edge are not used"""
    orbit_error_axes: Literal["orbital", "inertial"] = "orbital"
    """axes of the position error: along track, across track and radial, or GCRS"""
    orbit_error_correlation_time: Seconds = Field(default=20000.0, gt=0.0)
    """correlation time of the position error"""
    earth_albedo: float = Field(default=0.0, ge=0.0, le=1.0)
    """reflectivity of the Earth as a Lambert sphere, for the albedo on Sun sensors; 0 omits the
    albedo"""
    albedo: float = Field(default=0.0, ge=0.0)
    """error of the albedo model as an error of the Sun's unit vector, 1-sigma per axis; 0 omits the
    states"""
    albedo_correlation_time: Seconds = Field(default=600.0, gt=0.0)
    """correlation time of the albedo error"""
    considered: tuple[str, ...] = ()
    """error states of the environment models that the filter considers but does not estimate
    (Schmidt-Kalman)"""

    def __post_init__(self) -> None:
        size = self.orbit_error_m
        expect(all(size) == any(size), "orbit_error_m", size, "three numbers > 0 m, or all zero")
        check_considered(self.considered, self.states())

    def states(self) -> dict[str, GaussMarkov]:
        """Return the error states of the environment models; see `Sensor.states`."""
        along, across, radial = (sigma / POSITION_UNIT for sigma in self.orbit_error_m)
        field = self.field_error_nt / FIELD_UNIT_NT
        states = {
            "albedo": GaussMarkov(self.albedo, self.albedo_correlation_time),
            "field_error": GaussMarkov(field, self.field_error_correlation_time),
            "orbit_error": GaussMarkov((along, across, radial), self.orbit_error_correlation_time),
        }
        return {state: process for state, process in states.items() if np.any(process.sigma)}

    @property
    def has_orbit_error(self) -> bool:
        """Whether the position is uncertain, and with it the time of eclipses."""
        return any(self.orbit_error_m)

    def apply_to_environment(self, environment: Environment) -> Environment:
        """Return the environment as the sensor models use it.

        With an orbit error, samples within `ECLIPSE_MARGIN_SIGMAS` 1-sigmas of an eclipse count as eclipse. With a
        reflectivity of the Earth, the mean albedo is added.
        """
        changes: dict[str, Any] = {}
        if self.has_orbit_error and environment.has_eclipses:
            changes["sunlit"] = environment.sunlit & self._sunlight_mask(environment)
        if self.earth_albedo:
            light = albedo_vector(environment.position, environment.sun)
            changes["albedo"] = self.earth_albedo * light
        return dataclasses.replace(environment, **changes) if changes else environment

    def _sunlight_mask(self, environment: Environment) -> Bools:
        """Return a mask of the samples that no likely orbit error moves into the Earth's shadow."""
        here, sun = environment.position, environment.sun
        angle = sun_limb_angle(here, sun)
        axes = np.broadcast_to(np.eye(3), (len(here), 3, 3))
        off = self.convert_position_gradient(axes, environment) * np.array(self.orbit_error_m)
        moved = [sun_limb_angle(here + off[:, :, k], sun) - angle for k in range(3)]
        sure: Bools = angle > ECLIPSE_MARGIN_SIGMAS * np.linalg.norm(moved, axis=0)
        return sure

    def displace_position(self, environment: Environment, orbit_error: Floats) -> Environment:
        """Return the environment at the true position.

        Position and eclipses change; field and Sun direction do not.

        Parameters
        ----------
        environment : Environment
        orbit_error : array, shape (n, 3)
            Orbit error at each sample, in units of the filter's state.
        """
        axes = np.broadcast_to(np.eye(3), (len(orbit_error), 3, 3))
        off = np.einsum(
            "kij,kj->ki", self.convert_position_gradient(axes, environment), orbit_error
        )
        there = environment.position + POSITION_UNIT * off
        lit = (
            sun_limb_angle(there, environment.sun) > 0.0
            if environment.has_eclipses
            else environment.sunlit
        )
        return dataclasses.replace(environment, position=there, sunlit=lit)

    def convert_position_gradient(self, gradient: Floats, environment: Environment) -> Floats:
        """Convert a derivative by position to a derivative by the orbit error state.

        Parameters
        ----------
        gradient : array, shape (n, 3, 3)
            Derivative with respect to the position; columns along GCRS axes.
        environment : Environment

        Returns
        -------
        array, shape (n, 3, 3)
            Columns along the axes of the orbit error.
        """
        if self.orbit_error_axes == "inertial":
            return gradient
        radial = environment.position / np.linalg.norm(environment.position, axis=1)[:, None]
        across = np.cross(environment.position, environment.velocity)
        across /= np.linalg.norm(across, axis=1)[:, None]
        axes = np.stack([np.cross(across, radial), across, radial], axis=2)
        derivative: Floats = gradient @ axes
        return derivative
