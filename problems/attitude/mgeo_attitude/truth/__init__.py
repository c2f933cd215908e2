"""Truth simulation: whether a filter achieves what its covariance promises."""

from .estimator import Estimator
from .monte_carlo import MonteCarlo
from .simulate import simulate

__all__ = ["Estimator", "MonteCarlo", "simulate"]
