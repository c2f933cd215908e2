"""A run of the command line: show its progress, write its folder, and print the summary."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from mgeo.cli.errors import ExitCode, bad_input, stop_requests
from mgeo.cli.output import Output
from mgeo.cli.progress import Progress, run_title
from mgeo.cli.summary import show_summary
from mgeo.evaluation.evaluator import EvaluationError
from mgeo.figures.page import page
from mgeo.plugins.protocol import ask
from mgeo.plugins.view import View, front_of, view_of
from mgeo.runs.prepare import PreparedRun
from mgeo.store.atomic import check_writable, lock, write_file
from mgeo.store.provenance import installed_versions
from mgeo.store.run import Outcome, Run
from mgeo.store.run_folder import (
    CHECKPOINT_FILE,
    FIGURE_FILE,
    remove_run,
    write_arrays,
    write_run,
)
from mgeo.terminal import console


def run_and_show(run: PreparedRun, folder: Path, output: Output, max_time: float | None) -> int:
    """Run until the budget is used, write the run folder and print the summary.

    Returns
    -------
    Exit code: 0 if the run ended by its budget or `max_time`, 3 if no solution satisfies all
    constraints or the problem knows that none can, 128 + the number of the signal that stopped the
    run.
    """
    if impossible := ask(view_of(run.problem), View.impossible):
        output.print("nothing can keep all limits", *(f"  {why}" for why in impossible))
        output.result({"impossible": impossible})
        return ExitCode.INCOMPLETE
    with bad_input():
        folder.mkdir(parents=True, exist_ok=True)
    with stop_requests() as stop, bad_input((ValueError, OSError)), lock(folder):
        check_writable(folder)
        if run.notes is None:
            remove_run(folder)
        screen = Console(quiet=True) if output.quiet else console(stderr=True)
        progress = Progress(screen, run_title(run.configuration), stop)
        try:
            with progress.shown():
                outcome = run.solve(progress, folder, max_time)
            stop.may_raise = False
            made = Run(run.configuration, outcome, installed_versions(run.configuration.problem))
            write_run(folder, made, overwrite=True)
        except (EvaluationError, OSError):
            if (folder / CHECKPOINT_FILE).exists():
                output.note(f"To go on once that is put right: mgeo resume {folder}")
            raise
        solutions = outcome.nearest or outcome
        view = view_of(run.problem, solutions.X, solutions.F)
        try:
            _write_extras(run, outcome, view, folder)
        finally:  # the summary is printed even if a figure fails
            show_summary(made, view, folder, output)
    if outcome.stop_reason == "signal":
        return stop.exit_code or ExitCode.INTERRUPTED
    return ExitCode.DONE if len(outcome.F) else ExitCode.INCOMPLETE


def _write_extras(run: PreparedRun, outcome: Outcome, view: View, folder: Path) -> None:
    """Write the further arrays of the problem, and the figure of the front."""
    if len(outcome.F) and (arrays := ask(view, View.arrays)):
        write_arrays(folder, outcome, arrays)
    title, note = run_title(run.configuration), ""
    if outcome.nearest:
        note = f"Nothing that was found keeps all limits. These {len(view.X)} come nearest."
    if (figure := front_of(view, title)) is not None:
        write_file(folder / FIGURE_FILE, page(figure, title, note).encode())
