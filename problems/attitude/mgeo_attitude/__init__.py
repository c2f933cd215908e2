"""Attitude maneuvers that make sensor errors observable, as a pymoo problem."""

from .environment import Environment
from .filter import Evaluation, FilterHistory, FilterModel, Suite, evaluate, reference_run
from .problem import AttitudeManeuverProblem
from .scenario import Scenario
from .sensors import Gyro, Magnetometer, Sensor, StarTracker, SunSensor
from .truth import Estimator, MonteCarlo, consistency, simulate, validity

__version__ = "0.1.0"

__all__ = [
    "AttitudeManeuverProblem",
    "Environment",
    "Estimator",
    "Evaluation",
    "FilterHistory",
    "FilterModel",
    "Gyro",
    "Magnetometer",
    "MonteCarlo",
    "Scenario",
    "Sensor",
    "StarTracker",
    "Suite",
    "SunSensor",
    "consistency",
    "evaluate",
    "reference_run",
    "simulate",
    "validity",
]
