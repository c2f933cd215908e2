"""Gyro and sensors: their parameters and, in one function each, their error model."""

from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.magnetometer import Magnetometer
from mgeo_attitude.sensors.star_tracker import StarTracker
from mgeo_attitude.sensors.sun_sensor import SunSensor

#: Sensor classes by the ``kind`` that names them in a scenario file.
SENSORS: dict[str, type[Sensor]] = {cls.kind: cls for cls in (SunSensor, Magnetometer, StarTracker)}

__all__ = ["SENSORS", "Gyro", "Magnetometer", "Sensor", "StarTracker", "SunSensor"]
