"""Orbit, Sun, geomagnetic field and shadow of a run, all in GCRS."""

from mgeo_attitude.environment.element_set import SGP4Error
from mgeo_attitude.environment.environment import Environment

__all__ = ["Environment", "SGP4Error"]
