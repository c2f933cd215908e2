"""Flights by Basilisk: rigid-body dynamics, reaction wheels and sensors that nobody here wrote.

Nothing of Basilisk is imported until something is flown, and nothing is ever downloaded.
"""

from mgeo_calibration.flight.basilisk.fly import fly
from mgeo_calibration.flight.basilisk.vehicle import VEHICLES, Vehicle

__all__ = ["VEHICLES", "Vehicle", "fly"]
