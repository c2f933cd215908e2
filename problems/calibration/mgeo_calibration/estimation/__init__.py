"""What is concluded from all readings at once: attitude at every sample, errors and covariance."""

from mgeo_calibration.estimation.batch import Batch, batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.fit import Fit, fit
from mgeo_calibration.estimation.smoother import Solution
from mgeo_calibration.estimation.trajectory import Partition, Trajectory

__all__ = ["Batch", "Belief", "Fit", "Partition", "Solution", "Trajectory", "batch", "fit"]
