"""Orbit, Sun, geomagnetic field and shadow of a run, all in GCRS."""

from .environment import Environment
from .tle import SGP4Error

__all__ = ["Environment", "SGP4Error"]
