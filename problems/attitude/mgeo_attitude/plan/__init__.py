"""Maneuver plans as objects and files: selection from a front, analysis, export and import."""

from mgeo_attitude.plan.aem import format_aem
from mgeo_attitude.plan.attitudes import format_stk
from mgeo_attitude.plan.files import from_json, read_json, to_csv, to_json, write_plan
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.run_folder import Front, read_front
from mgeo_attitude.plan.spice import build_ck, format_sclk
from mgeo_attitude.plan.uplink import list_commands, to_uplink_csv

__all__ = [
    "Front",
    "ManeuverPlan",
    "build_ck",
    "format_aem",
    "format_sclk",
    "format_stk",
    "from_json",
    "list_commands",
    "read_front",
    "read_json",
    "to_csv",
    "to_json",
    "to_uplink_csv",
    "write_plan",
]
