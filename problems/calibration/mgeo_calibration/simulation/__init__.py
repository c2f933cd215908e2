"""Flights by the hundred: the error-state filter on board, what it claims, and calibrations."""

from mgeo_calibration.simulation.calibrations import simulate_calibrations
from mgeo_calibration.simulation.filter import Estimator
from mgeo_calibration.simulation.flights import simulate
from mgeo_calibration.simulation.monte_carlo import Consistency, Criterion, MonteCarlo, consistency

__all__ = [
    "Consistency",
    "Criterion",
    "Estimator",
    "MonteCarlo",
    "consistency",
    "simulate",
    "simulate_calibrations",
]
