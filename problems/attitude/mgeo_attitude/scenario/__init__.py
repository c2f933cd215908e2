"""Scenarios: what a study depends on, from code, presets or TOML files."""

from mgeo_attitude.scenario.actuators import Coils, Wheels
from mgeo_attitude.scenario.channels import Channel
from mgeo_attitude.scenario.initial import InitialConditions
from mgeo_attitude.scenario.of_others import (
    EphemerisOrbit,
    KeyProblem,
    MeanElements,
    Orbit,
    OrbitFile,
    TLEOrbit,
)
from mgeo_attitude.scenario.prior import Prior
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.schema import scenario_schema
from mgeo_attitude.scenario.settings import (
    Convergence,
    ManeuverLimits,
    PathLimit,
    RequiredSigma,
    TraceWeights,
)
from mgeo_attitude.scenario.toml import ScenarioFileError
from mgeo_attitude.scenario.windows import Contact, FlightErrors, Window

__all__ = [
    "Channel",
    "Coils",
    "Contact",
    "Convergence",
    "EphemerisOrbit",
    "FlightErrors",
    "InitialConditions",
    "KeyProblem",
    "ManeuverLimits",
    "MeanElements",
    "Orbit",
    "OrbitFile",
    "PathLimit",
    "Prior",
    "RequiredSigma",
    "Scenario",
    "ScenarioFileError",
    "TLEOrbit",
    "TraceWeights",
    "Wheels",
    "Window",
    "scenario_schema",
]
