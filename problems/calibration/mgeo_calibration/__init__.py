"""Simulation, telemetry, estimation, calibration and verification of attitude maneuver plans."""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo_calibration.calibration.calibrate import calibrate
    from mgeo_calibration.calibration.calibration import Calibration
    from mgeo_calibration.calibration.diagnosis import CalibrationError
    from mgeo_calibration.calibration.magnetometer_calibration import calibrate_magnetometers
    from mgeo_calibration.simulation.filter import FilterSettings
    from mgeo_calibration.simulation.monte_carlo import MonteCarloResult, evaluate_consistency
    from mgeo_calibration.simulation.simulate import simulate
    from mgeo_calibration.simulators.kinematic import simulate_telemetry
    from mgeo_calibration.telemetry.mapping import TelemetryMapping
    from mgeo_calibration.telemetry.reading import read_telemetry
    from mgeo_calibration.telemetry.telemetry import Telemetry
    from mgeo_calibration.verification import Verification, verify

__all__ = [
    "Calibration",
    "CalibrationError",
    "FilterSettings",
    "MonteCarloResult",
    "Telemetry",
    "TelemetryMapping",
    "Verification",
    "calibrate",
    "calibrate_magnetometers",
    "evaluate_consistency",
    "read_telemetry",
    "simulate",
    "simulate_telemetry",
    "verify",
]

#: Module of each public name. Names are imported at their first use, so that the command line
#: starts quickly.
_MODULES = {
    "Calibration": "mgeo_calibration.calibration.calibration",
    "CalibrationError": "mgeo_calibration.calibration.diagnosis",
    "FilterSettings": "mgeo_calibration.simulation.filter",
    "MonteCarloResult": "mgeo_calibration.simulation.monte_carlo",
    "Telemetry": "mgeo_calibration.telemetry.telemetry",
    "TelemetryMapping": "mgeo_calibration.telemetry.mapping",
    "Verification": "mgeo_calibration.verification",
    "calibrate": "mgeo_calibration.calibration.calibrate",
    "calibrate_magnetometers": "mgeo_calibration.calibration.magnetometer_calibration",
    "evaluate_consistency": "mgeo_calibration.simulation.monte_carlo",
    "read_telemetry": "mgeo_calibration.telemetry.reading",
    "simulate": "mgeo_calibration.simulation.simulate",
    "simulate_telemetry": "mgeo_calibration.simulators.kinematic",
    "verify": "mgeo_calibration.verification",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return version("mgeo-calibration")
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
