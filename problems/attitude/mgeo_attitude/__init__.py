"""Satellite attitude maneuvers that calibrate sensors and gyro, as an optimization problem for
pymoo.
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo_attitude.environment.environment import Environment as Environment
    from mgeo_attitude.filter.evaluator import Evaluation as Evaluation
    from mgeo_attitude.filter.evaluator import evaluate as evaluate
    from mgeo_attitude.filter.history import FilterHistory as FilterHistory
    from mgeo_attitude.filter.history import run_filter as run_filter
    from mgeo_attitude.filter.model import FilterModel as FilterModel
    from mgeo_attitude.filter.reference import compare_filters as compare_filters
    from mgeo_attitude.filter.reference import run_reference_filter as run_reference_filter
    from mgeo_attitude.lower_bound.assembly import compute_lower_bound as compute_lower_bound
    from mgeo_attitude.lower_bound.curves import LowerBound as LowerBound
    from mgeo_attitude.lower_bound.samples import NoLowerBoundError as NoLowerBoundError
    from mgeo_attitude.problem import AttitudeManeuverProblem as AttitudeManeuverProblem
    from mgeo_attitude.refine.local_refinement import refine_plans as refine_plans
    from mgeo_attitude.refine.splitting import (
        remove_ineffective_maneuvers as remove_ineffective_maneuvers,
    )
    from mgeo_attitude.refine.splitting import split_maneuvers as split_maneuvers
    from mgeo_attitude.scenario.scenario import Scenario as Scenario
    from mgeo_attitude.scenario.schema import build_scenario_schema as build_scenario_schema
    from mgeo_attitude.scenario.validity import find_validity_violations as find_validity_violations
    from mgeo_attitude.sensors.base import Sensor as Sensor
    from mgeo_attitude.sensors.direction_sensors import HorizonSensor as HorizonSensor
    from mgeo_attitude.sensors.direction_sensors import TwoAxisSunSensor as TwoAxisSunSensor
    from mgeo_attitude.sensors.environment_errors import EnvironmentErrors as EnvironmentErrors
    from mgeo_attitude.sensors.error_models import BiasSensitivity as BiasSensitivity
    from mgeo_attitude.sensors.error_models import GaussMarkov as GaussMarkov
    from mgeo_attitude.sensors.gyro import Gyro as Gyro
    from mgeo_attitude.sensors.photodiode import Photodiode as Photodiode
    from mgeo_attitude.sensors.star_tracker import StarTracker as StarTracker
    from mgeo_attitude.sensors.suite import Suite as Suite
    from mgeo_attitude.sensors.vector_sensors import Magnetometer as Magnetometer
    from mgeo_attitude.sensors.vector_sensors import SunSensor as SunSensor

#: Public names by module. A name is imported on first use, so that the command line starts quickly.
_NAMES = {
    "environment.environment": "Environment",
    "filter.evaluator": "Evaluation evaluate",
    "filter.history": "FilterHistory run_filter",
    "filter.model": "FilterModel",
    "filter.reference": "compare_filters run_reference_filter",
    "lower_bound.assembly": "compute_lower_bound",
    "lower_bound.curves": "LowerBound",
    "lower_bound.samples": "NoLowerBoundError",
    "problem": "AttitudeManeuverProblem",
    "refine.local_refinement": "refine_plans",
    "refine.splitting": "remove_ineffective_maneuvers split_maneuvers",
    "scenario.scenario": "Scenario",
    "scenario.schema": "build_scenario_schema",
    "scenario.validity": "find_validity_violations",
    "sensors.base": "Sensor",
    "sensors.direction_sensors": "HorizonSensor TwoAxisSunSensor",
    "sensors.environment_errors": "EnvironmentErrors",
    "sensors.error_models": "BiasSensitivity GaussMarkov",
    "sensors.gyro": "Gyro",
    "sensors.photodiode": "Photodiode",
    "sensors.star_tracker": "StarTracker",
    "sensors.suite": "Suite",
    "sensors.vector_sensors": "Magnetometer SunSensor",
}
_MODULES = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return version("mgeo-attitude")
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"mgeo_attitude.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
