"""What ``mgeo solve`` and ``mgeo resume`` share: run, write the folder, show what was found."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from typing import Any

from pymoo.core.problem import Problem

from mgeo.cli.consoles import console
from mgeo.cli.displays import clock, run_display
from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.output import Output
from mgeo.cli.progress import Reporter
from mgeo.cli.signals import StopRequest, stop_requests
from mgeo.cli.solutions import solutions_table
from mgeo.evaluation.evaluator import EvaluationError
from mgeo.figures import MOST_OBJECTIVES, front_figure, page
from mgeo.files.atomic import write_file
from mgeo.files.lock import lock
from mgeo.plugins import protocol
from mgeo.runs.configuration import RunConfiguration
from mgeo.runs.folder import (
    FIGURE_FILE,
    FRONT_FILE,
    RUN_FILE,
    Run,
    check_folder,
    installed_versions,
    run_document,
    write_run,
)
from mgeo.runs.persistence import CHECKPOINT_FILE, RECORD_FOLDER, RunPersistence
from mgeo.runs.prepare import PreparedRun
from mgeo.runs.solve import Outcome

_CAUSES = 3  # of failed evaluations are shown


def run_to_folder(
    run: PreparedRun, persistence: RunPersistence, output: Output, *, overwrite: bool
) -> int:
    """Run it to its end, write what it found into its folder; the exit code.

    Without `overwrite` there may be nothing in the folder.

    0 if the budget was used, 128 + the number of the signal that stopped the run.
    """
    folder = persistence.folder
    # until everything is written: impatience must not cost a run, nor another run its files
    with ExitStack() as stack, stop_requests() as stop:
        with bad_input():
            stack.enter_context(lock(folder))
            # another run may have ended there since somebody looked
            check_folder(folder, overwrite=overwrite)
        try:
            # of errors while it runs only those of writing are the user's to put right
            with bad_input((OSError,)):
                outcome = _solve(run, persistence, stop, output)
        except BaseException as error:
            persistence.drop_if_useless()
            with suppress(OSError):  # a folder with something in it stays
                folder.rmdir()
            if persistence.can_resume and isinstance(error, EvaluationError):
                output.note(f"To go on once that is put right: mgeo resume {folder}")
            raise
        made = Run(run.configuration, outcome, installed_versions(run.configuration.problem))
        with bad_input():
            # the folder was checked before the run: whatever is in it now may be replaced
            write_run(folder, made, overwrite=True)
        html = _front_page(run, outcome)
        with bad_input():
            if html is not None:
                write_file(folder / FIGURE_FILE, html.encode())
    _print_results(run, outcome, persistence, html is not None, output)
    output.result(_document(made, persistence))
    return stop.exit_code if outcome.status == "interrupted" else ExitCode.DONE


def _solve(
    run: PreparedRun, persistence: RunPersistence, stop: StopRequest, output: Output
) -> Outcome:
    with ExitStack() as shown:
        display = None
        if not output.quiet:
            display = shown.enter_context(
                run_display(console(stderr=True), run_title(run.configuration), stop)
            )
        return run.solve(Reporter(display, stop, persistence), persistence)


def run_title(run: RunConfiguration) -> str:
    """What a run is called."""
    values = ", ".join(f"{key} = {value}" for key, value in run.parameters.items())
    return f"{run.problem} · {run.algorithm} ({values}) · seed {run.seed}"


def can_draw(problem: Problem) -> bool:
    """Whether there will be a picture of a front that is not empty."""
    return hasattr(problem, "figures") or problem.n_obj <= MOST_OBJECTIVES


def _front_page(run: PreparedRun, outcome: Outcome) -> str | None:
    """The plugin's picture of the front or else ours, None where neither can draw it."""
    title = run_title(run.configuration)
    figure = protocol.front_figure(run.problem, outcome.X) if len(outcome.X) else None
    if figure is None and len(outcome.objectives) <= MOST_OBJECTIVES:
        figure = front_figure(outcome.X, outcome.F, outcome.variables, outcome.objectives, title)
    return None if figure is None else page(figure, title)


def _print_results(
    run: PreparedRun, outcome: Outcome, persistence: RunPersistence, drawn: bool, output: Output
) -> None:
    summary = [
        f"{outcome.status} after {outcome.evaluations:,} evaluations in "
        f"{clock(outcome.wall_time_s)}",
        f"solutions: {len(outcome.F):,}",
    ]
    volume = outcome.hypervolume
    if volume is not None:
        note = "" if volume.space == "problem" else " of the range this run saw"
        summary.append(f"hypervolume {volume.value:.4f}{note}")
    output.print("; ".join(summary), *_failures(outcome))
    if not len(outcome.F):
        output.print("no feasible solution was found")
    elif output.for_people:
        output.print(solutions_table(run.problem, outcome))
    output.print(f"written: {persistence.folder / (FIGURE_FILE if drawn else '')}")
    if persistence.error is not None:
        output.print(f"no checkpoint: {persistence.error}")
    elif outcome.status == "interrupted" and persistence.can_resume:
        output.print(f"to go on: mgeo resume {persistence.folder}")


def _document(made: Run, persistence: RunPersistence) -> dict[str, Any]:
    names = (FRONT_FILE, RUN_FILE, FIGURE_FILE, CHECKPOINT_FILE, RECORD_FOLDER)
    written = [name for name in names if (persistence.folder / name).exists()]
    error = None if persistence.error is None else str(persistence.error)
    return {
        "folder": str(persistence.folder),
        "files": written,
        "checkpoint_error": error,
        **run_document(made),
    }


def _failures(outcome: Outcome) -> list[str]:
    if not outcome.failures:
        return []
    causes = [f"{cause} ({count:,})" for cause, count in outcome.failures.items()]
    more = f" and {len(causes) - _CAUSES} more, see run.json" if len(causes) > _CAUSES else ""
    total = sum(outcome.failures.values())
    return [f"failed evaluations: {total:,}; {', '.join(causes[:_CAUSES])}{more}"]
