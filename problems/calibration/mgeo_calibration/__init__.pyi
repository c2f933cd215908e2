from .calibration import Calibration as Calibration
from .calibration import CannotCalibrate as CannotCalibrate
from .calibration import StrengthCalibration as StrengthCalibration
from .calibration import calibrate as calibrate
from .calibration import calibrate_alone as calibrate_alone
from .flight import fly as fly
from .simulation import Estimator as Estimator
from .simulation import MonteCarlo as MonteCarlo
from .simulation import consistency as consistency
from .simulation import simulate as simulate
from .simulation import simulate_calibrations as simulate_calibrations
from .telemetry import Telemetry as Telemetry
from .telemetry import TelemetryMapping as TelemetryMapping
from .telemetry import read_telemetry as read_telemetry
from .verification import Verification as Verification
from .verification import verify as verify

__version__: str
