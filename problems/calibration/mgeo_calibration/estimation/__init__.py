"""What is concluded from readings: the error-state filter, and whether its claims are true."""

from mgeo_calibration.estimation.filter import Estimator
from mgeo_calibration.estimation.monte_carlo import Consistency, Criterion, MonteCarlo, consistency
from mgeo_calibration.estimation.simulate import simulate

__all__ = [
    "Consistency",
    "Criterion",
    "Estimator",
    "MonteCarlo",
    "consistency",
    "simulate",
]
