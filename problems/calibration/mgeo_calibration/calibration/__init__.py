"""Calibration of gyro and sensors from telemetry: estimates, tests, documents and reports."""
