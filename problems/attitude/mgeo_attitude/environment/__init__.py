"""Orbit, Sun, geomagnetic field and shadow of a run, all in GCRS."""

from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.tle import SGP4Error

__all__ = ["Environment", "SGP4Error"]
