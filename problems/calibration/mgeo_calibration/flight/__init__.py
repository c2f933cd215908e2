"""Flights: what is true of a plan that is flown, and what gyro and sensors report of it."""

from mgeo_calibration.flight.flight import Draws, Flight, draw, fly_run
from mgeo_calibration.flight.own import fly
from mgeo_calibration.flight.truth import other_truth, surroundings

__all__ = ["Draws", "Flight", "draw", "fly", "fly_run", "other_truth", "surroundings"]
