"""Telemetry: what a satellite has reported, its files, columns, units and frames."""

from mgeo_calibration.telemetry.mapping import GyroChannels, SensorChannels, TelemetryMapping
from mgeo_calibration.telemetry.reading import read_telemetry
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth

__all__ = [
    "GyroChannels",
    "SensorChannels",
    "Telemetry",
    "TelemetryMapping",
    "Truth",
    "read_telemetry",
]
