"""What happens: the truth of a plan's flights, and what gyro and sensors report of it."""

from mgeo_attitude.flight.flight import Draws, Flight, Motion, draw, fly
from mgeo_attitude.flight.truth import other_truth

__all__ = ["Draws", "Flight", "Motion", "draw", "fly", "other_truth"]
