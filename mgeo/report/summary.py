"""What was run, as HTML; every text in it is escaped here."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from mgeo.runs.folder import Run
from mgeo.runs.highlights import Highlight


def title(run: Run) -> str:
    """Plain text: problem, algorithm and seed."""
    recipe = run.recipe
    return f"{recipe.problem} · {recipe.algorithm} · seed {recipe.seed}"


def lead(run: Run) -> str:
    """Plain text: how the run went, in a line."""
    outcome = run.outcome
    parts = [
        f"{outcome.status} after {outcome.evaluations:,} of {run.recipe.evaluations:,} evaluations",
        f"{len(outcome.F):,} solutions",
    ]
    if outcome.hypervolume is not None:
        seen = "" if outcome.hypervolume.space == "problem" else " of the range this run saw"
        parts.append(f"hypervolume {outcome.hypervolume.value:.4f}{seen}")
    failed = sum(outcome.failures.values())
    return " · ".join([*parts, f"{failed:,} evaluations failed" if failed else "no failures"])


def facts(run: Run, folder: Path) -> str:
    """Recipe, versions and failures."""
    recipe, outcome = run.recipe, run.outcome
    rows = {
        "folder": folder.resolve().name,
        "problem": recipe.problem,
        "algorithm": recipe.algorithm,
        "parameters": _settings(recipe.parameters),
        "seed": recipe.seed,
        "budget": f"{recipe.evaluations:,} evaluations",
        "evaluations made": f"{outcome.evaluations:,}",
        "status": outcome.status,
        "started": f"{outcome.started:%Y-%m-%d %H:%M:%S} UTC",
        "wall time": f"{outcome.wall_time:,.1f} s",
        "versions": _settings(run.versions, " "),
    }
    rows |= {f"failed: {cause}": f"{count:,}" for cause, count in outcome.failures.items()}
    if not outcome.failures:
        rows["failed evaluations"] = "none"
    body = "".join(
        f"<tr><th scope=row>{escape(str(key))}</th><td>{escape(str(value))}</td></tr>"
        for key, value in rows.items()
    )
    options = escape(json.dumps(recipe.options, indent=2, ensure_ascii=False))
    return (
        f"<table class=facts>{body}</table>"
        f"<details><summary>Options of the problem</summary><pre>{options}</pre></details>"
    )


def cards(chosen: Sequence[Highlight], objectives: Sequence[str], F: np.ndarray) -> str:
    """The knee and the extremes, each a button that shows its plan."""
    return "".join(
        f'<button type=button class=card data-row="{highlight.row}">'
        f"<b>{escape(highlight.label)}</b> <span class=note>solution {highlight.row}</span>"
        + "".join(
            f"<span>{escape(name)} <output>{value:.5g}</output></span>"
            for name, value in zip(objectives, F[highlight.row], strict=True)
        )
        + "</button>"
        for highlight in chosen
    )


def table(columns: Sequence[Any], rows: Sequence[Sequence[Any]]) -> str:
    """A small table."""
    head = "".join(f"<th>{escape(str(name))}</th>" for name in columns)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(_shown(value))}</td>' for value in row)}</tr>" for row in rows
    )
    return (
        f"<div class=wide><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _shown(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _settings(values: Mapping[str, Any], sign: str = " = ") -> str:
    return ", ".join(f"{key}{sign}{value}" for key, value in values.items()) or "defaults"
