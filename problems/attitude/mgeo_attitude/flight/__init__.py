"""What happens: the truth of a plan's flights, what gyro and sensors report, and telemetry."""

from mgeo_attitude.flight.flight import Draws, Flight, draw, fly_run
from mgeo_attitude.flight.mapping import TelemetryMapping
from mgeo_attitude.flight.simulated import fly
from mgeo_attitude.flight.telemetry import Telemetry, Truth
from mgeo_attitude.flight.telemetry_files import read_telemetry
from mgeo_attitude.flight.truth import other_truth

__all__ = [
    "Draws",
    "Flight",
    "Telemetry",
    "TelemetryMapping",
    "Truth",
    "draw",
    "fly",
    "fly_run",
    "other_truth",
    "read_telemetry",
]
