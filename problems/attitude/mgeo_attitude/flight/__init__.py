"""What happens: the truth of a plan's flights, and what gyro and sensors report of it."""

from .draws import Draws, draw
from .flight import Flight, fly_runs
from .motion import Motion
from .other import other_truth
from .readings import Readings

__all__ = ["Draws", "Flight", "Motion", "Readings", "draw", "fly_runs", "other_truth"]
