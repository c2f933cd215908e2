"""What was run, as plain text."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mgeo.runs.folder import Run


def title(run: Run) -> str:
    """Plain text: problem, algorithm and seed."""
    configuration = run.configuration
    return f"{configuration.problem} · {configuration.algorithm} · seed {configuration.seed}"


def lead(run: Run) -> str:
    """Plain text: how the run went, in a line."""
    outcome = run.outcome
    budget = run.configuration.evaluations
    parts = [
        f"{outcome.status} after {outcome.evaluations:,} of {budget:,} evaluations",
        f"{len(outcome.F):,} solutions",
    ]
    if outcome.hypervolume is not None:
        seen = "" if outcome.hypervolume.space == "problem" else " of the range this run saw"
        parts.append(f"hypervolume {outcome.hypervolume.value:.4f}{seen}")
    failed = sum(outcome.failures.values())
    return " · ".join([*parts, f"{failed:,} evaluations failed" if failed else "no failures"])


def facts(run: Run, folder: Path) -> dict[str, str]:
    """Configuration, versions and failures."""
    configuration, outcome = run.configuration, run.outcome
    rows = {
        "folder": folder.resolve().name,
        "problem": configuration.problem,
        "algorithm": configuration.algorithm,
        "parameters": _settings(configuration.parameters),
        "seed": str(configuration.seed),
        "budget": f"{configuration.evaluations:,} evaluations",
        "evaluations made": f"{outcome.evaluations:,}",
        "status": outcome.status,
        "started": f"{outcome.started:%Y-%m-%d %H:%M:%S} UTC",
        "wall time": f"{outcome.wall_time_s:,.1f} s",
        "versions": _settings(run.versions, " "),
    }
    rows |= {f"failed: {cause}": f"{count:,}" for cause, count in outcome.failures.items()}
    if not outcome.failures:
        rows["failed evaluations"] = "none"
    return rows


def _settings(values: Mapping[str, Any], sign: str = " = ") -> str:
    return ", ".join(f"{key}{sign}{value}" for key, value in values.items()) or "defaults"
