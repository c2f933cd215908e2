"""Smoothing of telemetry batches to estimate attitude and calibration parameters."""
