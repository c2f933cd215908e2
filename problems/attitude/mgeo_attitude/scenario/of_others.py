"""Orbits and errors that a scenario is said by, which are of other rooms."""

from mgeo_attitude.environment.element_set import MeanElements, TLEOrbit
from mgeo_attitude.environment.ephemeris import EphemerisOrbit
from mgeo_attitude.environment.orbit import Orbit, OrbitFile
from mgeo_attitude.fields.quantity import KeyProblem

__all__ = ["EphemerisOrbit", "KeyProblem", "MeanElements", "Orbit", "OrbitFile", "TLEOrbit"]
