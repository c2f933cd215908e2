"""Attitude maneuvers that make sensor errors observable, as a pymoo problem."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo_attitude.bound import LimitCurves, NoLimit, limit
    from mgeo_attitude.calibration import Calibration, calibrate, simulate_calibrations
    from mgeo_attitude.environment.environment import Environment
    from mgeo_attitude.estimation import Estimator, MonteCarlo, consistency, simulate
    from mgeo_attitude.filter.evaluator import Evaluation, evaluate
    from mgeo_attitude.filter.history import FilterHistory, filter_history
    from mgeo_attitude.filter.model import FilterModel
    from mgeo_attitude.filter.reference import agreement, reference_run
    from mgeo_attitude.flight import Telemetry, TelemetryMapping, fly, read_telemetry
    from mgeo_attitude.problem import AttitudeManeuverProblem
    from mgeo_attitude.scenario import Scenario, scenario_schema
    from mgeo_attitude.scenario.validity import validity
    from mgeo_attitude.sensors import Gyro, Magnetometer, Sensor, StarTracker, SunSensor
    from mgeo_attitude.sensors.suite import Suite

__version__: str

__all__ = [
    "AttitudeManeuverProblem",
    "Calibration",
    "Environment",
    "Estimator",
    "Evaluation",
    "FilterHistory",
    "FilterModel",
    "Gyro",
    "LimitCurves",
    "Magnetometer",
    "MonteCarlo",
    "NoLimit",
    "Scenario",
    "Sensor",
    "StarTracker",
    "Suite",
    "SunSensor",
    "Telemetry",
    "TelemetryMapping",
    "agreement",
    "calibrate",
    "consistency",
    "evaluate",
    "filter_history",
    "fly",
    "limit",
    "read_telemetry",
    "reference_run",
    "scenario_schema",
    "simulate",
    "simulate_calibrations",
    "validity",
]

_HOMES = {
    "mgeo_attitude.bound": ("LimitCurves", "NoLimit", "limit"),
    "mgeo_attitude.calibration": ("Calibration", "calibrate", "simulate_calibrations"),
    "mgeo_attitude.environment.environment": ("Environment",),
    "mgeo_attitude.estimation": ("Estimator", "MonteCarlo", "consistency", "simulate", "validity"),
    "mgeo_attitude.filter.evaluator": ("Evaluation", "evaluate"),
    "mgeo_attitude.filter.model": ("FilterModel",),
    "mgeo_attitude.filter.history": ("FilterHistory", "filter_history"),
    "mgeo_attitude.filter.reference": ("agreement", "reference_run"),
    "mgeo_attitude.sensors.suite": ("Suite",),
    "mgeo_attitude.flight": ("Telemetry", "TelemetryMapping", "fly", "read_telemetry"),
    "mgeo_attitude.problem": ("AttitudeManeuverProblem",),
    "mgeo_attitude.scenario": ("Scenario", "scenario_schema"),
    "mgeo_attitude.sensors": ("Gyro", "Magnetometer", "Sensor", "StarTracker", "SunSensor"),
}


def __getattr__(name: str) -> Any:
    # filters, statistics and figures take seconds to import, and help and completion need none
    if name == "__version__":
        return import_module("importlib.metadata").version("mgeo-attitude")
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(home), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
