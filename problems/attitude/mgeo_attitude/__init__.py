"""Attitude maneuvers that make sensor errors observable, as a pymoo problem."""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo_attitude.bound.assembly import limit
    from mgeo_attitude.bound.curves import LimitCurves
    from mgeo_attitude.bound.samples import NoLimit
    from mgeo_attitude.environment.environment import Environment
    from mgeo_attitude.filter.evaluator import Evaluation, evaluate
    from mgeo_attitude.filter.history import FilterHistory, filter_history
    from mgeo_attitude.filter.model import FilterModel
    from mgeo_attitude.filter.reference import agreement, reference_run
    from mgeo_attitude.problem import AttitudeManeuverProblem
    from mgeo_attitude.refine.polish import polish
    from mgeo_attitude.refine.splitting import split, without_unneeded
    from mgeo_attitude.scenario.scenario import Scenario
    from mgeo_attitude.scenario.schema import scenario_schema
    from mgeo_attitude.scenario.validity import validity
    from mgeo_attitude.sensors.base import Sensor
    from mgeo_attitude.sensors.direction_sensors import HorizonSensor, TwoAxisSunSensor
    from mgeo_attitude.sensors.errors import GaussMarkov, Influence
    from mgeo_attitude.sensors.gyro import Gyro
    from mgeo_attitude.sensors.photodiode import Photodiode
    from mgeo_attitude.sensors.star_tracker import StarTracker
    from mgeo_attitude.sensors.suite import Suite
    from mgeo_attitude.sensors.vector_sensors import Magnetometer, SunSensor
    from mgeo_attitude.sensors.world import World

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

#: Modules of the public names. A name is imported when it is first used, so that the command
#: line starts quickly.
_MODULES = {
    "AttitudeManeuverProblem": "mgeo_attitude.problem",
    "Environment": "mgeo_attitude.environment.environment",
    "Evaluation": "mgeo_attitude.filter.evaluator",
    "FilterHistory": "mgeo_attitude.filter.history",
    "FilterModel": "mgeo_attitude.filter.model",
    "GaussMarkov": "mgeo_attitude.sensors.errors",
    "Gyro": "mgeo_attitude.sensors.gyro",
    "HorizonSensor": "mgeo_attitude.sensors.direction_sensors",
    "Influence": "mgeo_attitude.sensors.errors",
    "LimitCurves": "mgeo_attitude.bound.curves",
    "Magnetometer": "mgeo_attitude.sensors.vector_sensors",
    "NoLimit": "mgeo_attitude.bound.samples",
    "Photodiode": "mgeo_attitude.sensors.photodiode",
    "Scenario": "mgeo_attitude.scenario.scenario",
    "Sensor": "mgeo_attitude.sensors.base",
    "StarTracker": "mgeo_attitude.sensors.star_tracker",
    "Suite": "mgeo_attitude.sensors.suite",
    "SunSensor": "mgeo_attitude.sensors.vector_sensors",
    "TwoAxisSunSensor": "mgeo_attitude.sensors.direction_sensors",
    "World": "mgeo_attitude.sensors.world",
    "agreement": "mgeo_attitude.filter.reference",
    "evaluate": "mgeo_attitude.filter.evaluator",
    "filter_history": "mgeo_attitude.filter.history",
    "limit": "mgeo_attitude.bound.assembly",
    "polish": "mgeo_attitude.refine.polish",
    "reference_run": "mgeo_attitude.filter.reference",
    "scenario_schema": "mgeo_attitude.scenario.schema",
    "split": "mgeo_attitude.refine.splitting",
    "validity": "mgeo_attitude.scenario.validity",
    "without_unneeded": "mgeo_attitude.refine.splitting",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return version("mgeo-attitude")
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
