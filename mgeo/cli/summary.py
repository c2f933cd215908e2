"""Summary of a finished run, as text and as the JSON document of ``--json``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import RenderableType

from mgeo._text import format_column, format_key, wrap_text
from mgeo.plugins.protocol import call_optional
from mgeo.plugins.review import Section
from mgeo.plugins.view import MAX_ROWS, View
from mgeo.runs.summary import (
    FrontSummary,
    InfeasibilityReport,
    explain_infeasibility,
    summarize_front,
)
from mgeo.store.run import Outcome, Run
from mgeo.store.run_folder import CHECKPOINT_FILE, FIGURE_FILE, RUN_FILES, build_run_document
from mgeo.terminal import (
    Output,
    build_text_table,
    escape_text,
    render_section,
    to_records,
)

if TYPE_CHECKING:
    import pandas as pd

    from mgeo.documents import Recommended, RunSummary


def print_summary(run: Run, view: View, folder: Path, output: Output) -> None:
    """Print the recommended solution of a run, the front at a glance, warnings and files.

    If no solution is feasible, the violated constraints are printed instead, with suggestions to
    make the problem feasible.

    Parameters
    ----------
    run
        Finished run.
    view
        View of the front or, if no solution is feasible, of the solutions nearest to feasibility.
    folder
        Run folder.
    output
        Destination of the summary.
    """
    if output.quiet and not output.json:
        return
    outcome = run.outcome
    front = summarize_front(view) if len(outcome.F) else None
    infeasibility = explain_infeasibility(view) if outcome.nearest else None
    warnings = [*(front.warnings if front else []), *_list_run_warnings(outcome)]
    files = [name for name in RUN_FILES if (folder / name).exists()]
    summary: RunSummary = {
        "folder": str(folder),
        "files": files,
        "recommended": _build_recommended_document(front) if front else None,
        "front": _build_records(front.front.rename_axis("solution")) if front else [],
        "infeasibility": {
            "violations": _build_records(infeasibility.build_table()),
            "suggestions": list(infeasibility.suggestions),
        }
        if infeasibility
        else None,
        "warnings": warnings,
    }
    output.print_document({**summary, **build_run_document(run)})
    if not output.is_text:
        return
    output.print(*_describe_run(run, view))
    if front is not None:
        output.print(*_render_front(view, front))
    if infeasibility is not None:
        output.print(*_render_infeasibility(infeasibility))
    if warnings:
        output.print("", *(_render_warning(each) for each in warnings))
    output.print(*_render_files(folder, files), *_render_next_commands(view, folder, outcome))


def format_duration(seconds: float) -> str:
    """Format a duration in seconds, such as 9 s, 2 min 5 s or 1 h 2 min 3 s."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest, "s")]
    return " ".join(f"{value} {unit}" for value, unit in parts if value) or "less than 1 s"


def _describe_run(run: Run, view: View) -> Iterator[RenderableType]:
    configuration, outcome = run.configuration, run.outcome
    name = configuration.options.get("name")
    scenario = f", scenario {name}" if isinstance(name, str) else ""
    n = len(outcome.F)
    result = f"{n:,} {view.noun}{'' if n == 1 else 's'} on the front"
    if not n:
        result = "no feasible solution"
    elif outcome.hypervolume is not None:
        result += f", hypervolume {outcome.hypervolume:.4f}"
    yield escape_text(wrap_text(f"{configuration.problem}{scenario}: {result}"), "bold")
    refined = " and local refinement" if outcome.n_refined or outcome.n_added else ""
    cost = (
        f"{outcome.n_evaluations:,} evaluations by {configuration.algorithm} "
        f"(seed {configuration.seed}){refined} in {format_duration(outcome.wall_time_s)}"
    )
    is_early = outcome.stop_reason in ("signal", "max_time")
    yield escape_text(
        wrap_text(f"{outcome.end_description.capitalize()} after {cost}" if is_early else cost)
    )


def _render_front(view: View, front: FrontSummary) -> Iterator[str | RenderableType]:
    recommended, n, noun = front.recommended, len(view.X), view.noun
    reason = f"{recommended.label}, since the front has no knee"
    if recommended.label == "knee":
        reason = "the knee of the front"
    elif n == 1:
        reason = f"the only {noun} of the front"
    yield ""
    yield escape_text(f"Recommended: {noun} {recommended.row}, {reason}", "bold")
    for i, (key, section) in enumerate(front.overview.items()):
        if i > 1 and key != "constraints":
            yield ""
        yield from render_section(section)
    if n > 1:
        yield ""
        columns = {f"{len(front.front):,} of {n:,} {noun}s": _format_labels(front)}
        for name in front.front.columns[1:]:
            columns[str(name)] = format_column(front.front[name].tolist())
        yield build_text_table(columns)


def _format_labels(front: FrontSummary) -> list[str]:
    width = len(str(max(front.front.index)))
    pairs = zip(front.front.index, front.front["label"], strict=True)
    return [f"{row:>{width}}  {label}" for row, label in pairs]


def _render_infeasibility(report: InfeasibilityReport) -> Iterator[str | RenderableType]:
    note = "Smallest violation by a solution, and number of solutions that violate it."
    yield ""
    yield from render_section(
        Section("Violated constraint", table=report.build_table(), note=note, max_rows=MAX_ROWS)
    )
    if report.suggestions:
        yield ""
        yield escape_text("Suggestions", "bold")
        yield from (wrap_text(f"- {line}", "  ") for line in report.suggestions)


def _list_run_warnings(outcome: Outcome) -> list[str]:
    lines = []
    if outcome.failures:
        causes = [f"{cause} ({count:,})" for cause, count in outcome.failures.items()]
        lines.append(f"{sum(outcome.failures.values()):,} evaluations failed: {', '.join(causes)}.")
    if outcome.refinement_error:
        lines.append(f"The local refinement is incomplete: {outcome.refinement_error}.")
    if outcome.checkpoint_error is not None:
        lines.append(f"The run cannot be resumed: {outcome.checkpoint_error}.")
    return lines


def _render_warning(text: str) -> RenderableType:
    line = escape_text(wrap_text(f"Warning: {text}", "  "))
    line.stylize("yellow", 0, len("Warning:"))
    return line


def _render_files(folder: Path, files: list[str]) -> Iterator[str]:
    yield ""
    yield wrap_text(f"Files in {folder}: {', '.join(files)}", "  ")


def _render_next_commands(view: View, folder: Path, outcome: Outcome) -> Iterator[RenderableType]:
    commands = {}
    if len(outcome.F):
        commands = call_optional(view, View.next_commands, str(folder))
    if (folder / FIGURE_FILE).exists():
        commands["Write a report"] = f"mgeo report {folder}"
    is_early = outcome.stop_reason in ("signal", "max_time")
    if is_early and outcome.checkpoint_error is None and (folder / CHECKPOINT_FILE).exists():
        commands["Continue the run"] = f"mgeo resume {folder}"
    width = max(map(len, commands), default=0)
    for purpose, command in commands.items():
        yield escape_text(f"{purpose + ':':<{width + 1}}  {command}")


def _build_recommended_document(front: FrontSummary) -> Recommended:
    tables: Any = {
        key: _build_records(section.table)
        for key, section in front.overview.items()
        if section.table is not None
    }
    return {
        "solution": front.recommended.row,
        "label": front.recommended.label,
        "summary": front.text,
        **tables,
        "constraints": _build_records(front.constraints),
    }


def _build_records(table: pd.DataFrame) -> list[Any]:
    """Return the rows of a table as dicts; the keys contain the units of the columns."""
    records = to_records(table.rename_axis(str(table.index.name or "name")))
    return [{format_key(str(key)): value for key, value in each.items()} for each in records]
