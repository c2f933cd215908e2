"""Scenarios: what a study depends on, from code, presets or TOML files."""

from ..environment.orbit import Orbit
from ..environment.tle import TLEOrbit
from ..fields import KeyProblem
from .limits import KeepOut, Wheels
from .scenario import Scenario
from .schema import scenario_schema
from .settings import (
    Convergence,
    InitialUncertainty,
    ManeuverLimits,
    RequiredSigma,
    TraceWeights,
    state_blocks,
)
from .toml import ScenarioFileError

__all__ = [
    "Convergence",
    "InitialUncertainty",
    "KeepOut",
    "KeyProblem",
    "ManeuverLimits",
    "Orbit",
    "RequiredSigma",
    "Scenario",
    "ScenarioFileError",
    "TLEOrbit",
    "TraceWeights",
    "Wheels",
    "scenario_schema",
    "state_blocks",
]
