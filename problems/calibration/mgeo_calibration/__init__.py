"""What comes after a plan: flights, telemetry, estimation, calibration, verification."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo_calibration.calibration import (
        Calibration,
        CannotCalibrate,
        StrengthCalibration,
        calibrate,
        calibrate_alone,
    )
    from mgeo_calibration.flight import fly
    from mgeo_calibration.simulation import (
        Estimator,
        MonteCarlo,
        consistency,
        simulate,
        simulate_calibrations,
    )
    from mgeo_calibration.telemetry import Telemetry, TelemetryMapping, read_telemetry
    from mgeo_calibration.verification import Verification, verify

__version__: str

__all__ = [
    "Calibration",
    "CannotCalibrate",
    "Estimator",
    "MonteCarlo",
    "StrengthCalibration",
    "Telemetry",
    "TelemetryMapping",
    "Verification",
    "calibrate",
    "calibrate_alone",
    "consistency",
    "fly",
    "read_telemetry",
    "simulate",
    "simulate_calibrations",
    "verify",
]

_HOMES = {
    "mgeo_calibration.calibration": (
        "Calibration",
        "CannotCalibrate",
        "StrengthCalibration",
        "calibrate",
        "calibrate_alone",
    ),
    "mgeo_calibration.flight": ("fly",),
    "mgeo_calibration.simulation": (
        "Estimator",
        "MonteCarlo",
        "consistency",
        "simulate",
        "simulate_calibrations",
    ),
    "mgeo_calibration.telemetry": (
        "Telemetry",
        "TelemetryMapping",
        "read_telemetry",
    ),
    "mgeo_calibration.verification": (
        "Verification",
        "verify",
    ),
}


def __getattr__(name: str) -> Any:
    # filters and statistics take seconds to import
    if name == "__version__":
        return import_module("importlib.metadata").version("mgeo-calibration")
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(home), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
