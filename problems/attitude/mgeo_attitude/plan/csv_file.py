"""Timelines as CSV, one row per phase, for spreadsheets and flight-procedure tools.

The columns are those of `ManeuverPlan.timeline`, after ``row``, such as 2/4, by which a file that
has lost rows is known. Floats are written by repr, to the last digit. The file says less than the
plan: what is to be read back as one is JSON.
"""

from __future__ import annotations

from pathlib import Path

from mgeo.files.atomic import write_file
from mgeo_attitude.plan.plan import ManeuverPlan


def to_csv(plan: ManeuverPlan) -> str:
    """The timeline as CSV with a header.

    Lines that begin with # stand before it where the plan violates constraints, and name them.
    """
    table = plan.timeline()
    rows = [f"{i + 1}/{len(table)}" for i in range(len(table))]
    comments = "".join(f"# VIOLATED CONSTRAINT: {violation}\n" for violation in plan.violations())
    text: str = table.set_axis(rows, axis=0).to_csv(index_label="row", lineterminator="\n")
    return comments + text


def write_csv(plan: ManeuverPlan, path: Path | str) -> None:
    """Write `to_csv` to a file, whole or not at all."""
    write_file(path, to_csv(plan).encode())
