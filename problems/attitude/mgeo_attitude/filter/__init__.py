"""Covariance filter of the calibration: error model, reference filter and generated kernel."""
