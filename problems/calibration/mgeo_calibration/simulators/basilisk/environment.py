"""Orbit, magnetic field and eclipses of the Basilisk simulation, from precomputed tables.

Basilisk takes Sun and Earth from ephemeris files and the field from a coefficient file, and
downloads both. This module provides the data of `mgeo_attitude.environment` instead.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from Basilisk.architecture import messaging, sysModel
from Basilisk.simulation import eclipse, gravityEffector, magneticFieldWMM, spacecraft
from mgeo_attitude.environment.constants import EARTH_MU
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.field import FIELD_RADIUS, load_gauss_coefficients
from mgeo_attitude.environment.frames import gcrs_to_itrs
from mgeo_attitude.environment.sun_moon import sun_position
from mgeo_attitude.environment.times import compute_julian_dates

#: Degree of Basilisk's field model. The next degree of IGRF contributes about 1 nT in low orbits.
FIELD_DEGREE = 12

#: Astronomical unit of Basilisk [m].
BASILISK_AU = 149597870.693e3


def format_field_coefficients(date: datetime) -> str:
    """Format the IGRF-14 coefficients at a date in the file format of the World Magnetic Model,
    without secular variation.
    """
    result = load_gauss_coefficients(date)
    year = date.year + (date.timetuple().tm_yday - 1) / 365.25
    lines = [f"    {year:.1f}            IGRF-14        {date:%m/%d/%Y}"]
    for n in range(1, FIELD_DEGREE + 1):
        for m in range(n + 1):
            g, h = result[n, m].real, result[n, m].imag
            lines.append(f"{n:3d}{m:3d}{g:11.4f}{h:11.4f}{0:11.4f}{0:11.4f}")
    return "\n".join([*lines, "9" * 48, "9" * 48, ""])


class EnvironmentMessages(sysModel.SysModel):
    """Basilisk module that publishes precomputed positions of the Sun, the Earth and the satellite.

    Attributes
    ----------
    earth, sun : message
        Positions relative to the Earth's center in GCRS.
    unit_sun : message
        Sun at one astronomical unit from the satellite, so that a coarse Sun sensor reports a unit
        vector.
    satellite_state : message
        Position and velocity of the satellite.
    """

    def __init__(self, environment: Environment, epoch: datetime, step_ns: int) -> None:
        super().__init__()
        self.ModelTag = "surroundings"
        at = compute_julian_dates(epoch, environment.times)
        self._step_ns = step_ns
        self._sun, self._to_itrs = sun_position(at), gcrs_to_itrs(at)
        self._environment = environment
        self.earth, self.sun, self.unit_sun = (messaging.SpicePlanetStateMsg() for _ in range(3))
        self.satellite_state = messaging.TransRefMsg()

    def Reset(self, nanoseconds: int) -> None:
        self.UpdateState(nanoseconds)

    def UpdateState(self, nanoseconds: int) -> None:
        k = min(round(nanoseconds / self._step_ns), len(self._sun) - 1)
        tables = self._environment
        near = tables.position[k] + BASILISK_AU * tables.sun[k]
        orientation = {"computeOrient": 1, "J20002Pfix": self._to_itrs[k].tolist()}
        self._write(self.earth, nanoseconds, PlanetName="earth", **orientation)
        self._write(self.sun, nanoseconds, PlanetName="sun", PositionVector=self._sun[k].tolist())
        self._write(self.unit_sun, nanoseconds, PlanetName="sun", PositionVector=near.tolist())
        place = messaging.TransRefMsgPayload()
        place.r_RN_N, place.v_RN_N = tables.position[k].tolist(), tables.velocity[k].tolist()
        self.satellite_state.write(place, nanoseconds, self.moduleID)

    def _write(self, message: Any, nanoseconds: int, **values: Any) -> None:
        payload = messaging.SpicePlanetStateMsgPayload()
        for name, value in values.items():
            setattr(payload, name, value)
        message.write(payload, nanoseconds, self.moduleID)


def build_central_body(messages: EnvironmentMessages) -> Any:
    """Build the gravity bodies for `Spacecraft.gravField`: the Earth as a point mass."""
    earth = gravityEffector.GravBodyData()
    earth.planetName, earth.mu, earth.isCentralBody = "earth", EARTH_MU, True
    earth.planetBodyInMsg.subscribeTo(messages.earth)
    return spacecraft.GravBodyVector([earth])


def build_field_model(satellite: Any, messages: EnvironmentMessages, coefficients: Path) -> Any:
    """Build Basilisk's magnetic field module from a file of spherical-harmonic coefficients.

    The file must exist until the model is initialized.
    """
    model = magneticFieldWMM.MagneticFieldWMM()
    model.ModelTag, model.planetRadius = "field", FIELD_RADIUS
    model.addSpacecraftToModel(satellite.scStateOutMsg)
    model.planetPosInMsg.subscribeTo(messages.earth)
    model.configureWMMFile(str(coefficients))
    return model


def build_eclipse_model(satellite: Any, messages: EnvironmentMessages) -> Any:
    """Build Basilisk's eclipse module, which publishes the illumination factor of the satellite."""
    model = eclipse.Eclipse()
    model.ModelTag = "eclipse"
    model.addSpacecraftToModel(satellite.scStateOutMsg)
    model.addPlanetToModel(messages.earth)
    model.sunInMsg.subscribeTo(messages.sun)
    return model


def compute_middle_time(environment: Environment, epoch: datetime) -> datetime:
    """Return the time in the middle of a run, at which `Environment` evaluates the field model."""
    times = environment.times
    return epoch + timedelta(seconds=0.5 * float(times[0] + times[-1]))
