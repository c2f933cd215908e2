"""Orbit, Sun, geomagnetic field and shadow of a run, all in GCRS."""

from mgeo_attitude.environment.constants import ASTRONOMICAL_UNIT, EARTH_MU, EARTH_RADIUS
from mgeo_attitude.environment.element_set import SGP4Error
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.sun_moon import lit_fraction, sun_position
from mgeo_attitude.environment.time_frames import Instants, gcrs_to_itrs, instants, rotate

__all__ = [
    "ASTRONOMICAL_UNIT",
    "EARTH_MU",
    "EARTH_RADIUS",
    "Environment",
    "Instants",
    "SGP4Error",
    "gcrs_to_itrs",
    "instants",
    "lit_fraction",
    "rotate",
    "sun_position",
]
