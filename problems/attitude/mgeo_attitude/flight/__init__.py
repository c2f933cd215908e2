"""What happens: the truth of a plan's flights, and what gyro and sensors report of it."""

from mgeo_attitude.flight.draws import Draws, draw
from mgeo_attitude.flight.flight import Flight, fly_runs
from mgeo_attitude.flight.motion import Motion
from mgeo_attitude.flight.other import other_truth
from mgeo_attitude.flight.readings import Readings

__all__ = ["Draws", "Flight", "Motion", "Readings", "draw", "fly_runs", "other_truth"]
