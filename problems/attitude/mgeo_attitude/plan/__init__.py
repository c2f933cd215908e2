"""Plans as objects and files: selected from a front, analyzed, exported, read."""

from mgeo_attitude.plan.aem import aem_text
from mgeo_attitude.plan.attitudes import stk_text
from mgeo_attitude.plan.files import from_json, read_json, to_csv, to_json, write_plan
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.run_folder import Front, read_front
from mgeo_attitude.plan.spice import ck_bytes, sclk_text
from mgeo_attitude.plan.uplink import commands, to_uplink_csv

__all__ = [
    "Front",
    "ManeuverPlan",
    "aem_text",
    "ck_bytes",
    "commands",
    "from_json",
    "read_front",
    "read_json",
    "sclk_text",
    "stk_text",
    "to_csv",
    "to_json",
    "to_uplink_csv",
    "write_plan",
]
