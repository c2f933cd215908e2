"""Gyro and attitude sensors: parameters, error models and measurements."""

from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.direction_sensors import HorizonSensor, TwoAxisSunSensor
from mgeo_attitude.sensors.environment_errors import EnvironmentErrors
from mgeo_attitude.sensors.error_models import BiasSensitivity, GaussMarkov
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.star_tracker import StarTracker
from mgeo_attitude.sensors.vector_sensors import Magnetometer, SunSensor

#: Sensor classes by the value of ``kind`` in a scenario file.
SENSORS: dict[str, type[Sensor]] = {
    cls.kind: cls
    for cls in (SunSensor, TwoAxisSunSensor, Photodiode, HorizonSensor, Magnetometer, StarTracker)
}

__all__ = [
    "SENSORS",
    "BiasSensitivity",
    "EnvironmentErrors",
    "GaussMarkov",
    "Gyro",
    "HorizonSensor",
    "Magnetometer",
    "Photodiode",
    "Sensor",
    "StarTracker",
    "SunSensor",
    "TwoAxisSunSensor",
]
