"""Why telemetry is not calibrated: causes that are seen without any attitude, each in a line."""

from mgeo_calibration.diagnosis.causes import causes, checks

__all__ = ["causes", "checks"]
