"""What telemetry says of gyro and sensors: estimated, tested, written, drawn and read back."""

from mgeo_calibration.calibration.agreement import SensorTest
from mgeo_calibration.calibration.alone import StrengthCalibration, calibrate_alone
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.document import from_json, read_json, to_json
from mgeo_calibration.calibration.from_telemetry import calibrate
from mgeo_calibration.calibration.refused import CannotCalibrate
from mgeo_calibration.estimation.residuals import History

__all__ = [
    "Calibration",
    "CannotCalibrate",
    "History",
    "SensorTest",
    "StrengthCalibration",
    "calibrate",
    "calibrate_alone",
    "from_json",
    "read_json",
    "to_json",
]
