"""Summary of a finished run, as text and as the document of ``--json``."""

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
    """Print the recommended solution, or suggestions if none is feasible, and the statistics.

    Parameters
    ----------
    run
        Finished run.
    view
        View of the front, or of the nearest solutions if no solution is feasible.
    folder
        Run folder.
    output
        Destination of the summary.
    """
    if output.quiet and not output.json:
        return
    outcome = run.outcome
    best = summarize_default_solution(view) if len(outcome.F) else None
    stuck = explain_infeasibility(view) if outcome.nearest else None
    remarks = (
        call_optional(view, View.remarks) if best else []
    )  # Remarks can take seconds to compute.
    output.print_document(
        {
            "folder": str(folder),
            "files": [name for name in RUN_FILES if (folder / name).exists()],
            "summary": None if best is None else asdict(best),
            "infeasibility": None if stuck is None else asdict(stuck),
            "remarks": remarks,
            **build_run_document(run),
        }
    )
    if not output.is_text:
        return
    if best is not None:
        output.print(escape_text(best, "bold"))
    if stuck is not None:
        output.print(
            escape_text("no feasible solution was found; the nearest solutions violate", "bold"),
            *(f"  {line}" for line in stuck.violations),
            escape_text("suggestions", "bold"),
            *(f"  {line}" for line in stuck.suggestions),
        )
    _print_statistics(outcome, remarks, output)
    if best is not None:
        output.print(_build_solutions_table(view, outcome))
    elif stuck is None:
        output.print("no feasible solution was found")
    picture = folder / FIGURE_FILE
    output.print(f"written: {picture if picture.exists() else folder}")
    if outcome.checkpoint_error is not None:
        output.print(f"no checkpoint: {outcome.checkpoint_error}")
    elif outcome.stop_reason in ("signal", "max_time") and (folder / CHECKPOINT_FILE).exists():
        output.print(f"to continue: mgeo resume {folder}")


def format_duration(seconds: float) -> str:
    """Return a duration [s] as hours, minutes and seconds, such as 1:02:03."""
    return str(timedelta(seconds=round(seconds)))


def _print_statistics(outcome: Outcome, remarks: list[str], output: Output) -> None:
    size = f"solutions: {len(outcome.F):,}"
    if outcome.hypervolume is not None:
        size += f"; hypervolume {outcome.hypervolume:.4f}"
    took = f"{outcome.n_evaluations:,} evaluations in {format_duration(outcome.wall_time_s)}"
    output.print(f"{outcome.end_description} after {took}; {size}", *remarks)
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
    """Return a table with one column per representative solution and one row per quantity.

    Solutions labeled "between" are omitted if the terminal is too narrow.
    """
    chosen = select_representative_solutions(view.problem, outcome.F, outcome.objectives)
    described = call_optional(view.select([solution.row for solution in chosen]), View.describe)
    titles = [f"{solution.label} ({solution.row})" for solution in chosen]
    frame = described.astype(object).T.set_axis(titles, axis="columns")
    full_table = build_table(["", *frame], frame.itertuples(name=None))
    if is_within_width(full_table, build_console().width):
        return full_table
    frame = frame[[title for title in titles if not title.startswith("between")]]
    return build_table(["", *frame], frame.itertuples(name=None))
