"""A plan as an artefact: picked from a front, looked at, written, read back and flown."""

from .aem import aem_text
from .files import from_json, read_json, to_csv, to_json, write_plan
from .plan import ManeuverPlan
from .run_folder import Front, read_front
from .uplink import commands, to_uplink_csv

__all__ = [
    "Front",
    "ManeuverPlan",
    "aem_text",
    "commands",
    "from_json",
    "read_front",
    "read_json",
    "to_csv",
    "to_json",
    "to_uplink_csv",
    "write_plan",
]
