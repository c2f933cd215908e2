"""Scenarios: all inputs of a maneuver optimization, from Python, presets or TOML files."""

from mgeo_attitude.environment.element_set import MeanElements, TLEOrbit
from mgeo_attitude.environment.ephemeris import EphemerisOrbit
from mgeo_attitude.environment.orbit import Orbit, OrbitFile
from mgeo_attitude.scenario.actuators import Magnetorquers, Wheels
from mgeo_attitude.scenario.constraints import ManeuverBounds, PathConstraint, Window
from mgeo_attitude.scenario.criteria import (
    Convergence,
    MonteCarloSettings,
    RequiredSigma,
    TraceWeights,
)
from mgeo_attitude.scenario.housekeeping import HousekeepingChannel
from mgeo_attitude.scenario.initial_conditions import InitialConditions
from mgeo_attitude.scenario.prior import Prior
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.schema import build_scenario_schema
from mgeo_attitude.scenario.toml import ScenarioFileError
from mgeo_attitude.settings.errors import InvalidKey

__all__ = [
    "Convergence",
    "EphemerisOrbit",
    "HousekeepingChannel",
    "InitialConditions",
    "InvalidKey",
    "Magnetorquers",
    "ManeuverBounds",
    "MeanElements",
    "MonteCarloSettings",
    "Orbit",
    "OrbitFile",
    "PathConstraint",
    "Prior",
    "RequiredSigma",
    "Scenario",
    "ScenarioFileError",
    "TLEOrbit",
    "TraceWeights",
    "Wheels",
    "Window",
    "build_scenario_schema",
]
