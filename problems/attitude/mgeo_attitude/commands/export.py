"""Output of ``mgeo attitude export``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from mgeo.terminal import Output
from mgeo_attitude.calibration_package import suggest_verification
from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.export_formats import find_format
from mgeo_attitude.plan.plan import ManeuverPlan


def print_export(
    selected: SelectedPlan,
    contents: Mapping[Path, bytes],
    warnings: Sequence[str],
    spacing: float,
    output: Output,
) -> None:
    """Print the result of an export: warnings, written files, and the next commands.

    Parameters
    ----------
    selected : SelectedPlan
    contents : mapping of Path to bytes
        Contents of the files.
    warnings : sequence of str
    spacing : float
        Largest time between attitudes [s].
    output : Output
    """
    plan = selected.plan
    output.print_title(f"Exported {selected.name}, scenario {plan.scenario.name}")
    output.print_warnings(warnings)
    output.print_files(
        {
            str(path): f"{find_format(path).name}, "
            f"{_describe_content(plan, path, content, spacing)}"
            for path, content in contents.items()
        }
    )
    for path in contents:
        if path.suffix == ".json":
            output.print_commands(
                {
                    "Print the plan": f"mgeo attitude show {path}",
                    **suggest_verification(path),
                }
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
