"""Fixed-interval smoothing of attitude and calibration parameters from all readings of a batch."""
