"""Gyro and sensors: their parameters and, in one function each, their error model."""

from .base import Sensor
from .gyro import Gyro
from .magnetometer import Magnetometer
from .star_tracker import StarTracker
from .sun_sensor import SunSensor

#: Sensor classes by the ``kind`` that names them in a scenario file.
SENSORS: dict[str, type[Sensor]] = {cls.kind: cls for cls in (SunSensor, Magnetometer, StarTracker)}

__all__ = ["SENSORS", "Gyro", "Magnetometer", "Sensor", "StarTracker", "SunSensor"]
