"""Output of ``mgeo attitude export``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from mgeo._text import wrap_text
from mgeo.plugins.review import format_table
from mgeo.terminal import Output, build_console
from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.export_formats import find_format
from mgeo_attitude.plan.plan import ManeuverPlan


def print_export(
    selected: SelectedPlan, contents: Mapping[Path, bytes], spacing: float, output: Output
) -> None:
    """Print the files that were written with their contents, and the next commands.

    Parameters
    ----------
    selected : SelectedPlan
    contents : mapping of Path to bytes
        Contents of the files.
    spacing : float
        Largest time between attitudes [s].
    output : Output
    """
    plan, width = selected.plan, build_console().width
    rows = {
        str(path): (find_format(path).name, _describe_content(plan, path, content, spacing))
        for path, content in contents.items()
    }
    table = pd.DataFrame.from_dict(rows, "index", columns=["format", "contents"])
    title = f"Exported {selected.name}, scenario {plan.scenario.name}"
    output.print(wrap_text(title, width=width), "", format_table(table.rename_axis("file"), width))
    for path in contents:
        if path.suffix == ".json":
            output.print(
                "",
                f"Next: mgeo attitude show {path}",
                f"      mgeo attitude verify {path}  (with the package mgeo-calibration)",
            )


def _describe_content(plan: ManeuverPlan, path: Path, content: bytes, spacing: float) -> str:
    export_format = find_format(path)
    if "spacing" in export_format.list_options():
        n_epochs = 1 + sum(math.ceil(phase.duration / spacing) for phase in plan.phases)
        return f"{n_epochs:,} epochs, at most {spacing:g} s apart"
    if path.suffix == ".csv":
        lines = [line for line in content.splitlines() if not line.startswith(b"#")]
        return f"{len(lines) - 1} rows"
    return export_format.description
