"""Scenarios: what a study depends on, from code, presets or TOML files."""

from .limits import KeepOut, Wheels
from .orbit import Orbit, TLEOrbit
from .scenario import Scenario
from .settings import (
    Convergence,
    InitialUncertainty,
    ManeuverLimits,
    RequiredSigma,
    TraceWeights,
    state_blocks,
)
from .tables import KeyProblem
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
    "state_blocks",
]
