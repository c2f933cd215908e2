"""Attitude maneuvers that make sensor errors observable, as a pymoo problem."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo_attitude.bound import LimitCurves, NoLimit, limit
    from mgeo_attitude.environment.environment import Environment
    from mgeo_attitude.filter.evaluator import Evaluation, evaluate
    from mgeo_attitude.filter.history import FilterHistory, filter_history
    from mgeo_attitude.filter.model import FilterModel
    from mgeo_attitude.filter.reference import agreement, reference_run
    from mgeo_attitude.problem import AttitudeManeuverProblem
    from mgeo_attitude.refine import polish, split, without_unneeded
    from mgeo_attitude.scenario import Scenario, scenario_schema
    from mgeo_attitude.scenario.validity import validity
    from mgeo_attitude.sensors import (
        GaussMarkov,
        Gyro,
        HorizonSensor,
        Influence,
        Magnetometer,
        Photodiode,
        Sensor,
        StarTracker,
        SunSensor,
        TwoAxisSunSensor,
        World,
    )
    from mgeo_attitude.sensors.suite import Suite

__version__: str

__all__ = [
    "AttitudeManeuverProblem",
    "Environment",
    "Evaluation",
    "FilterHistory",
    "FilterModel",
    "GaussMarkov",
    "Gyro",
    "HorizonSensor",
    "Influence",
    "LimitCurves",
    "Magnetometer",
    "NoLimit",
    "Photodiode",
    "Scenario",
    "Sensor",
    "StarTracker",
    "Suite",
    "SunSensor",
    "TwoAxisSunSensor",
    "World",
    "agreement",
    "evaluate",
    "filter_history",
    "limit",
    "polish",
    "reference_run",
    "scenario_schema",
    "split",
    "validity",
    "without_unneeded",
]

_HOMES = {
    "mgeo_attitude.scenario.validity": ("validity",),
    "mgeo_attitude.bound": ("LimitCurves", "NoLimit", "limit"),
    "mgeo_attitude.environment.environment": ("Environment",),
    "mgeo_attitude.filter.evaluator": ("Evaluation", "evaluate"),
    "mgeo_attitude.filter.model": ("FilterModel",),
    "mgeo_attitude.filter.history": ("FilterHistory", "filter_history"),
    "mgeo_attitude.filter.reference": ("agreement", "reference_run"),
    "mgeo_attitude.sensors.suite": ("Suite",),
    "mgeo_attitude.problem": ("AttitudeManeuverProblem",),
    "mgeo_attitude.refine": ("polish", "split", "without_unneeded"),
    "mgeo_attitude.scenario": ("Scenario", "scenario_schema"),
    "mgeo_attitude.sensors": (
        "GaussMarkov",
        "Gyro",
        "HorizonSensor",
        "Influence",
        "Magnetometer",
        "Photodiode",
        "Sensor",
        "StarTracker",
        "SunSensor",
        "TwoAxisSunSensor",
        "World",
    ),
}

#: Names that were here before mgeo-calibration had them.
_MOVED = {
    *("Calibration", "Estimator", "MonteCarlo", "Telemetry", "TelemetryMapping", "calibrate"),
    *("consistency", "fly", "read_telemetry", "simulate", "simulate_calibrations"),
}


def __getattr__(name: str) -> Any:
    # filters, statistics and figures take seconds to import, and help and completion need none
    if name == "__version__":
        return import_module("importlib.metadata").version("mgeo-attitude")
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(home), name)
    if name in _MOVED:
        return import_module("mgeo_attitude.aliases").moved(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
