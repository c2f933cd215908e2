"""What is concluded from readings: the error-state filter, and whether its claims are true."""

from .consistency import Consistency, Criterion, consistency
from .estimator import Estimator
from .monte_carlo import MonteCarlo
from .simulate import simulate
from .validity import OutsideValidity, validity

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
