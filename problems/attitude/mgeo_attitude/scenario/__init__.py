"""Scenarios: what a study depends on, from code, presets or TOML files."""

from mgeo_attitude.environment.ephemeris import EphemerisOrbit
from mgeo_attitude.environment.ephemeris_file import EphemerisFile
from mgeo_attitude.environment.orbit import Orbit
from mgeo_attitude.environment.tle import TLEOrbit
from mgeo_attitude.fields import KeyProblem
from mgeo_attitude.scenario.flight import FlightErrors
from mgeo_attitude.scenario.initial import InitialConditions
from mgeo_attitude.scenario.limits import KeepOut, Wheels
from mgeo_attitude.scenario.prior import Prior
from mgeo_attitude.scenario.scenario import Scenario, scenario_schema
from mgeo_attitude.scenario.settings import (
    Convergence,
    ManeuverLimits,
    RequiredSigma,
    TraceWeights,
)
from mgeo_attitude.scenario.toml import ScenarioFileError

__all__ = [
    "Convergence",
    "EphemerisFile",
    "EphemerisOrbit",
    "FlightErrors",
    "InitialConditions",
    "KeepOut",
    "KeyProblem",
    "ManeuverLimits",
    "Orbit",
    "Prior",
    "RequiredSigma",
    "Scenario",
    "ScenarioFileError",
    "TLEOrbit",
    "TraceWeights",
    "Wheels",
    "scenario_schema",
]
