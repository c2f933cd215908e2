"""Summary of a finished run, as text and as the JSON document of ``--json``."""

from __future__ import annotations

from dataclasses import asdict
from datetime import timedelta
from pathlib import Path

from rich.table import Table

from mgeo.plugins.protocol import call_optional
from mgeo.plugins.view import View
from mgeo.runs.summary import (
    explain_infeasibility,
    select_representative_solutions,
    summarize_default_solution,
)
from mgeo.store.run import Outcome, Run
from mgeo.store.run_folder import CHECKPOINT_FILE, FIGURE_FILE, RUN_FILES, build_run_document
from mgeo.terminal import Output, build_console, build_table, escape_text, is_within_width


def print_summary(run: Run, view: View, folder: Path, output: Output) -> None:
    """Print the statistics of a run, and its recommended solution.

    If no solution is feasible, suggestions to make the problem feasible are printed instead.

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
    summary = summarize_default_solution(view) if len(outcome.F) else None
    infeasibility = explain_infeasibility(view) if outcome.nearest else None
    # Remarks can take seconds to compute.
    remarks = call_optional(view, View.remarks) if summary else []
    output.print_document(
        {
            "folder": str(folder),
            "files": [name for name in RUN_FILES if (folder / name).exists()],
            "summary": None if summary is None else asdict(summary),
            "infeasibility": None if infeasibility is None else asdict(infeasibility),
            "remarks": remarks,
            **build_run_document(run),
        }
    )
    if not output.is_text:
        return
    if summary is not None:
        output.print(escape_text(summary, "bold"))
    if infeasibility is not None:
        output.print(
            escape_text("no feasible solution was found; the nearest solutions violate", "bold"),
            *(f"  {line}" for line in infeasibility.violations),
            escape_text("suggestions", "bold"),
            *(f"  {line}" for line in infeasibility.suggestions),
        )
    _print_statistics(outcome, remarks, output)
    if summary is not None:
        output.print(_build_solutions_table(view, outcome))
    elif infeasibility is None:
        output.print("no feasible solution was found")
    figure_file = folder / FIGURE_FILE
    output.print(f"written: {figure_file if figure_file.exists() else folder}")
    if outcome.checkpoint_error is not None:
        output.print(f"no checkpoint: {outcome.checkpoint_error}")
    elif outcome.stop_reason in ("signal", "max_time") and (folder / CHECKPOINT_FILE).exists():
        output.print(f"to continue: mgeo resume {folder}")


def format_duration(seconds: float) -> str:
    """Format a duration in seconds as hours, minutes and seconds, such as 1:02:03."""
    return str(timedelta(seconds=round(seconds)))


def _print_statistics(outcome: Outcome, remarks: list[str], output: Output) -> None:
    size = f"solutions: {len(outcome.F):,}"
    if outcome.hypervolume is not None:
        size += f"; hypervolume {outcome.hypervolume:.4f}"
    cost = f"{outcome.n_evaluations:,} evaluations in {format_duration(outcome.wall_time_s)}"
    output.print(f"{outcome.end_description} after {cost}; {size}", *remarks)
    if outcome.n_refined or outcome.n_added:
        output.print(
            f"refined: {outcome.n_refined:,} solutions improved, {outcome.n_added:,} added"
        )
    if outcome.refinement_error:
        output.print(f"refinement incomplete: {outcome.refinement_error}")
    if outcome.failures:
        causes = [f"{cause} ({count:,})" for cause, count in outcome.failures.items()]
        output.print(f"failed evaluations: {sum(outcome.failures.values()):,}; {', '.join(causes)}")


def _build_solutions_table(view: View, outcome: Outcome) -> Table:
    """Return a terminal table with representative solutions as columns and metrics as rows.

    Solutions labeled "between" are omitted if the terminal is too narrow.
    """
    solutions = select_representative_solutions(view.problem, outcome.F, outcome.objectives)
    descriptions = call_optional(
        view.select([solution.row for solution in solutions]), View.describe
    )
    titles = [f"{solution.label} ({solution.row})" for solution in solutions]
    frame = descriptions.astype(object).T.set_axis(titles, axis="columns")
    full_table = build_table(["", *frame], frame.itertuples(name=None))
    if is_within_width(full_table, build_console().width):
        return full_table
    frame = frame[[title for title in titles if not title.startswith("between")]]
    return build_table(["", *frame], frame.itertuples(name=None))
