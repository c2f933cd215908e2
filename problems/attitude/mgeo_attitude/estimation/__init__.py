"""What is concluded from readings: the error-state filter, and whether its claims are true."""

from mgeo_attitude.estimation.consistency import Consistency, Criterion, consistency
from mgeo_attitude.estimation.filter import Estimator
from mgeo_attitude.estimation.monte_carlo import MonteCarlo
from mgeo_attitude.estimation.simulate import simulate
from mgeo_attitude.scenario.validity import OutsideValidity, validity

__all__ = [
    "Consistency",
    "Criterion",
    "Estimator",
    "MonteCarlo",
    "OutsideValidity",
    "consistency",
    "simulate",
    "validity",
]
