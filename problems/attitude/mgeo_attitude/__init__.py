"""Attitude maneuvers that make sensor errors observable, as a pymoo problem."""

from importlib import import_module
from typing import Any

import lazy_loader

_getattr, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

#: Names that were here before mgeo-calibration had them.
_MOVED = {
    *("Calibration", "Estimator", "MonteCarlo", "Telemetry", "TelemetryMapping", "calibrate"),
    *("consistency", "fly", "read_telemetry", "simulate", "simulate_calibrations"),
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("mgeo-attitude")
    if name in _MOVED:
        return import_module("mgeo_attitude.aliases").moved(name)
    return _getattr(name)
