"""Errors of the environment models: geomagnetic field, orbit and albedo.

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

#: Unit of the geomagnetic field in the filter [nT], so that every state is of order one or less.
FIELD_UNIT_NT = 50_000.0
NT = Unit("nT", "nt", FIELD_UNIT_NT)

#: Unit of position errors in the filter [m].
POSITION_UNIT = 1000.0

#: Margin between a Sun measurement and an eclipse, in 1-sigmas of the orbit error. A filter cannot
#: linearize the edge of the shadow, so that measurements near the edge are not used.
ECLIPSE_MARGIN_SIGMAS = 3.0


@dataclass(frozen=True)
class EnvironmentErrors(Settings):
    """Errors of the geomagnetic field model, the orbit and the albedo model.

    Each error is modeled as a Gauss-Markov process. All errors are off by default. The errors of
    field and albedo are in GCRS axes.

    Examples
    --------
    >>> from mgeo_attitude import EnvironmentErrors
    >>> errors = EnvironmentErrors(field_error_nt=150.0, orbit_error_m=(2000.0, 200.0, 200.0))
    >>> list(errors.states())
    ['field_error', 'orbit_error']
    """

    #: See `Sensor.units`.
    units: ClassVar[Mapping[str, Unit]] = {
        "albedo": ARCMIN,
        "field_error": NT,
        "orbit_error": Unit("m", "m", POSITION_UNIT),
    }

    field_error_nt: Annotated[float, Unit("nT")] = Field(default=0.0, ge=0.0)
    """error of the geomagnetic field model, 1-sigma per axis; 0 to model no error"""
    field_error_correlation_time: Seconds = Field(default=300.0, gt=0.0)
    """correlation time of the field model error along the orbit"""
    orbit_error_m: Annotated[Triple[NonNegative], Unit("m")] = (0.0, 0.0, 0.0)
    """error of the satellite position in the environment models, 1-sigma along orbit_error_axes;
    three zeros to model no error. Sun measurements within 3-sigma of the edge of an eclipse are not
    used"""
    orbit_error_axes: Literal["orbital", "inertial"] = "orbital"
    """axes of the position error: 'orbital' for along track, across track and radial, 'inertial'
    for GCRS"""
    orbit_error_correlation_time: Seconds = Field(default=20000.0, gt=0.0)
    """correlation time of the position error"""
    earth_albedo: float = Field(default=0.0, ge=0.0, le=1.0)
    """reflectivity of the Earth, modeled as a Lambert sphere, for the mean albedo on Sun sensors
    and photodiodes; 0 for no albedo"""
    albedo: float = Field(default=0.0, ge=0.0)
    """error of the albedo model, as an error of the measured Sun vector relative to direct
    sunlight, 1-sigma per axis; 0 to model no error"""
    albedo_correlation_time: Seconds = Field(default=600.0, gt=0.0)
    """correlation time of the albedo error"""
    considered: tuple[str, ...] = ()
    """errors that the filter considers but does not estimate (Schmidt-Kalman filter):
    'field_error', 'orbit_error' or 'albedo'"""

    def __post_init__(self) -> None:
        size = self.orbit_error_m
        expect(all(size) == any(size), "orbit_error_m", size, "three numbers > 0 m, or all zero")
        check_considered(self.considered, self.states())

    def states(self) -> dict[str, GaussMarkov]:
        """Return the Gauss-Markov process of each modeled environment error, keyed by name.

        An error is modeled if its 1-sigma is nonzero. The names are ``albedo``, ``field_error`` and
        ``orbit_error``, in this order. The units are those of the filter's state; see `units`.
        """
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
        """True if an orbit error is modeled.

        An orbit error also makes the times of eclipses uncertain.
        """
        return any(self.orbit_error_m)

    def apply_to_environment(self, environment: Environment) -> Environment:
        """Return a copy of an environment with eclipse margins and the mean albedo.

        A sample counts as eclipsed if an orbit error of `ECLIPSE_MARGIN_SIGMAS` standard deviations
        can place it in an eclipse. The albedo is included if `earth_albedo` is nonzero.
        """
        changes: dict[str, Any] = {}
        if self.has_orbit_error and environment.has_eclipses:
            changes["sunlit"] = environment.sunlit & self._sunlight_mask(environment)
        if self.earth_albedo:
            albedo = albedo_vector(environment.position, environment.sun)
            changes["albedo"] = self.earth_albedo * albedo
        return dataclasses.replace(environment, **changes) if changes else environment

    def _sunlight_mask(self, environment: Environment) -> Bools:
        """Return True at samples that are sunlit for every orbit error within the eclipse margin.

        The margin is `ECLIPSE_MARGIN_SIGMAS` standard deviations of the orbit error.
        """
        position, sun = environment.position, environment.sun
        angle = sun_limb_angle(position, sun)
        axes = np.broadcast_to(np.eye(3), (len(position), 3, 3))
        offset = self.convert_position_gradient(axes, environment) * np.array(self.orbit_error_m)
        angle_change = [sun_limb_angle(position + offset[:, :, k], sun) - angle for k in range(3)]
        sunlit: Bools = angle > ECLIPSE_MARGIN_SIGMAS * np.linalg.norm(angle_change, axis=0)
        return sunlit

    def displace_position(self, environment: Environment, orbit_error: Floats) -> Environment:
        """Return a copy of an environment with the satellite displaced by an orbit error.

        Position and eclipses change; field and Sun direction do not.

        Parameters
        ----------
        environment : Environment
            Environment at the nominal position.
        orbit_error : array, shape (n, 3)
            Orbit error at each sample, in units of the filter's state.

        Returns
        -------
        Environment
        """
        axes = np.broadcast_to(np.eye(3), (len(orbit_error), 3, 3))
        offset = np.einsum(
            "kij,kj->ki", self.convert_position_gradient(axes, environment), orbit_error
        )
        position = environment.position + POSITION_UNIT * offset
        sunlit = (
            sun_limb_angle(position, environment.sun) > 0.0
            if environment.has_eclipses
            else environment.sunlit
        )
        return dataclasses.replace(environment, position=position, sunlit=sunlit)

    def convert_position_gradient(self, gradient: Floats, environment: Environment) -> Floats:
        """Convert a derivative with respect to position from GCRS axes to orbit-error axes.

        Parameters
        ----------
        gradient : array, shape (n, 3, 3)
            Derivative with respect to the position; columns along GCRS axes.
        environment : Environment
            Position and velocity at each sample.

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
