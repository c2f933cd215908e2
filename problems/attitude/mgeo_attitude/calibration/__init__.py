"""What telemetry says of gyro and sensors: estimated, tested, written, drawn and read back."""

from mgeo_attitude.calibration.calibration import Calibration
from mgeo_attitude.calibration.files import from_json, read_json, to_json
from mgeo_attitude.calibration.from_telemetry import calibrate
from mgeo_attitude.calibration.history import History
from mgeo_attitude.calibration.sensor_tests import SensorTest
from mgeo_attitude.calibration.simulated import simulate_calibrations

__all__ = [
    "Calibration",
    "History",
    "SensorTest",
    "calibrate",
    "from_json",
    "read_json",
    "simulate_calibrations",
    "to_json",
]
