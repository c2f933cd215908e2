"""Summary of a finished run, as text and as the JSON document of ``--json``."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from mgeo._text import format_duration, wrap_text
from mgeo.plugins.protocol import call_optional
from mgeo.plugins.review import Section, build_records
from mgeo.plugins.view import MAX_ROWS, View
from mgeo.runs.summary import (
    FrontSummary,
    InfeasibilityReport,
    explain_infeasibility,
    summarize_front,
)
from mgeo.store.run import Outcome, Run
from mgeo.store.run_folder import CHECKPOINT_FILE, FIGURE_FILE, RUN_FILES, build_run_document
from mgeo.terminal import Output

if TYPE_CHECKING:
    from mgeo.documents import Recommended, RunSummary

#: Number of constraints that a terminal shows if all of them are satisfied.
_MAX_CONSTRAINTS = 4


def print_summary(run: Run, view: View, folder: Path, output: Output) -> None:
    """Print the recommended solution of a run, an overview of the front, and warnings.

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
    infeasibility = explain_infeasibility(view, outcome.n_evaluations) if outcome.nearest else None
    warnings = [*(front.warnings if front else []), *_list_run_warnings(outcome)]
    files = [name for name in RUN_FILES if (folder / name).exists()]
    summary: RunSummary = {
        "folder": str(folder),
        "files": files,
        "recommended": _build_recommended_document(front) if front else None,
        "front": build_records(front.front.rename_axis("solution")) if front else [],
        "infeasibility": {
            "violations": build_records(infeasibility.build_table()),
            "suggestions": list(infeasibility.suggestions),
        }
        if infeasibility
        else None,
        "warnings": warnings,
    }
    output.print_document({**summary, **build_run_document(run)})
    if not output.is_text:
        return
    title, cost = _describe_run(run, view)
    output.print_title(title)
    output.print_text(cost)
    if front is not None:
        _print_front(view, front, output)
    if infeasibility is not None:
        _print_infeasibility(infeasibility, output)
    if warnings:
        output.print("")
        output.print_warnings(warnings)
    shown = [name for name in files if name.endswith((".csv", ".html"))]
    others = f"{len(files) - len(shown)} more"
    heading = wrap_text(f"Files in {folder}: {', '.join(shown)} and {others}", "  ")
    output.print_commands(_list_next_commands(view, folder, run), heading)


def _describe_run(run: Run, view: View) -> tuple[str, str]:
    """Return two lines of text: the result of a run, and the cost of the search."""
    configuration, outcome = run.configuration, run.outcome
    name = configuration.options.get("name")
    scenario = f" ({name})" if isinstance(name, str) else ""
    n = len(outcome.F)
    result = f"front of {n:,} {view.noun}{'' if n == 1 else 's'}"
    if not n:
        result = "no feasible solution"
    elif outcome.hypervolume is not None:
        result += f", normalized hypervolume {outcome.hypervolume:.4f}"
    refined = ", then local refinement," if outcome.n_refined or outcome.n_added else ""
    cost = (
        f"{outcome.n_evaluations:,} evaluations by {configuration.algorithm} "
        f"(seed {configuration.seed}){refined} in {format_duration(outcome.wall_time_s)}"
    )
    if outcome.stop_reason in ("signal", "max_time"):
        cost = f"{outcome.end_description.capitalize()} after {cost}"
    return f"{configuration.problem}{scenario}: {result}", cost


def _print_front(view: View, front: FrontSummary, output: Output) -> None:
    recommended, n, noun = front.recommended, len(view.X), view.noun
    reason = f"{recommended.label}, since the front has no knee"
    if recommended.label == "knee":
        reason = "the knee of the front"
    elif n == 1:
        reason = f"the only {noun} of the front"
    output.print_title(f"Recommended: {noun} {recommended.row}, {reason}")
    for i, (key, section) in enumerate(front.overview.items()):
        if i > 1 and key != "constraints":
            output.print("")
        if key == "constraints":
            n_violated = int((front.constraints["margin"] < 0.0).sum())
            section = replace(section, max_rows=max(_MAX_CONSTRAINTS, n_violated))
        output.print_sections(_move_title(section))
    if n > 1:
        width = len(str(max(front.front.index)))
        rows = zip(front.front.index, front.front["label"], front.front["violated"], strict=True)
        labels = [
            f"{row:>{width}}  {label}{' *' if violated else ''}" for row, label, violated in rows
        ]
        names = pd.Index(labels, name=f"{len(front.front):,} of {n:,} {noun}s")
        table = front.front.drop(columns=["label", "violated"]).set_axis(names, axis=0)
        violated = dict.fromkeys(chain.from_iterable(front.front["violated"]))
        note = f"* violates a constraint: {', '.join(violated)}." if violated else ""
        output.print("")
        output.print_sections(Section("", table=table, note=note))


def _move_title(section: Section) -> Section:
    """Move a section title into the table header, to save a line on the screen."""
    if section.table is None:
        return section
    return replace(section, title="", table=section.table.rename_axis(section.title))


def _print_infeasibility(report: InfeasibilityReport, output: Output) -> None:
    note = (
        "Of the solutions nearest to feasibility: smallest violation, and number of solutions that "
        "violate the constraint."
    )
    section = Section("Violated constraint", (), report.build_table(), note, max_rows=MAX_ROWS)
    output.print("")
    output.print_sections(_move_title(section))
    if report.suggestions:
        output.print("")
        output.print_sections(
            Section("Suggestions", tuple(f"- {line}" for line in report.suggestions))
        )


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


def _list_next_commands(view: View, folder: Path, run: Run) -> dict[str, str]:
    from mgeo.plugins.problems import format_problem_options

    commands, outcome = {}, run.outcome
    options = format_problem_options([run.configuration.problem])
    if len(outcome.F):
        commands = call_optional(view, View.next_commands, str(folder))
    if (folder / FIGURE_FILE).exists():
        commands["Write a report"] = f"mgeo report {folder}{options}"
    is_early = outcome.stop_reason in ("signal", "max_time")
    if is_early and outcome.checkpoint_error is None and (folder / CHECKPOINT_FILE).exists():
        commands["Continue the run"] = f"mgeo resume {folder}{options}"
    return commands


def _build_recommended_document(front: FrontSummary) -> Recommended:
    tables: Any = {
        key: build_records(section.table)
        for key, section in front.overview.items()
        if section.table is not None
    }
    return {
        "solution": front.recommended.row,
        "label": front.recommended.label,
        "summary": front.text,
        **tables,
        "constraints": build_records(front.constraints),
    }
