"""Scenarios: what a study depends on, from code, presets or TOML files."""

from .orbit import Orbit, TLEOrbit
from .scenario import Scenario
from .settings import Convergence, InitialUncertainty, ManeuverLimits, TraceWeights, state_blocks
from .tables import KeyProblem
from .toml import ScenarioFileError

__all__ = [
    "Convergence",
    "InitialUncertainty",
    "KeyProblem",
    "ManeuverLimits",
    "Orbit",
    "Scenario",
    "ScenarioFileError",
    "TLEOrbit",
    "TraceWeights",
    "state_blocks",
]
