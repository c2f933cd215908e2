"""All kinds of cases, registered by importing them."""

from . import arguments, places, plugins, run_folders, telemetry, texts
from .harness import KINDS

#: Those that read a file and run no command: some ten milliseconds a case.
CHEAP = ("run read", "record read", "configuration made", "study read", "scenario read",
         "scenario solved", "study record read", "checkpoint content read")  # fmt: skip

#: Those about telemetry: some hundred milliseconds a case.
TELEMETRY = ("telemetry read", "telemetry mapped", "telemetry calibrated", "telemetry command",
             "calibration read", "calibration gone on from", "calibration command")  # fmt: skip

__all__ = ["CHEAP", "KINDS", "TELEMETRY", "arguments", "places", "plugins", "run_folders",
           "telemetry", "texts"]  # fmt: skip
