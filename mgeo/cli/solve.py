"""``mgeo solve`` and ``mgeo resume``: run, write the folder, show what was found."""

from __future__ import annotations

import warnings
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from pymoo.core.problem import Problem
from rich.table import Table

from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.output import Output
from mgeo.cli.progress import Progress, clock, run_title
from mgeo.cli.signals import stop_requests
from mgeo.evaluation.evaluator import EvaluationError
from mgeo.figures import MOST_OBJECTIVES, front_figure, page
from mgeo.files.lock import sole_use
from mgeo.plugins import protocol
from mgeo.runs import (
    CHECKPOINT_FILE,
    FIGURE_FILE,
    FRONT_FILE,
    RECORD_FOLDER,
    RUN_FILE,
    Keeper,
    Outcome,
    PreparedRun,
    ResumedRun,
    Run,
    check_folder,
    front_table,
    highlights,
    installed_versions,
    resume_run,
    run_document,
    write_figure,
    write_run,
)
from mgeo.terminal import console, table

_CAUSES = 3  # of failed evaluations are shown


def resumed(folder: Path, output: Output, **options: Any) -> tuple[ResumedRun, Keeper]:
    """The run of a folder (see `resume_run`); other versions than it was begun with are told."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", RuntimeWarning)
        run = resume_run(folder, **options)
    for warning in told:
        output.note(f"Note: {warning.message}")
    return run, Keeper(folder, run.recipe, run.algorithm, record=run.notes["record"])


def run_to_folder(
    run: PreparedRun | ResumedRun, keeper: Keeper, output: Output, *, overwrite: bool
) -> int:
    """Run it to its end, write what it found into the keeper's folder; the exit code.

    Without `overwrite` there may be nothing in the folder.

    0 if the budget was used, 128 + the number of the signal that stopped the run.
    """
    folder = keeper.folder
    # until everything is written: impatience must not cost a run, nor another run its files
    with ExitStack() as stack, stop_requests() as stop:
        with bad_input():
            stack.enter_context(sole_use(folder))
            # another run may have ended there since somebody looked
            check_folder(folder, overwrite=overwrite)
        seen = None if output.quiet else console(stderr=True)
        progress = Progress(seen, run_title(run.recipe), stop, keeper)
        try:
            # of errors while it runs only those of writing are the user's to put right
            with bad_input((OSError,)), progress.shown():
                outcome = run.solve(progress, keeper)
        except BaseException as error:
            keeper.drop_if_useless()
            with suppress(OSError):  # a folder with something in it stays
                folder.rmdir()
            if keeper.can_go_on and isinstance(error, EvaluationError):
                output.note(f"To go on once that is put right: mgeo resume {folder}")
            raise
        made = Run(run.recipe, outcome, installed_versions(run.recipe.problem))
        with bad_input():
            # the folder was checked before the run: whatever is in it now may be replaced
            write_run(folder, made, overwrite=True)
        html = _front_page(run, outcome)
        with bad_input():
            if html is not None:
                write_figure(folder, html)
    _print_results(run.problem, outcome, keeper, html is not None, output)
    output.result(_document(made, keeper))
    return stop.exit_code if outcome.status == "interrupted" else ExitCode.DONE


def _front_page(run: PreparedRun | ResumedRun, outcome: Outcome) -> str | None:
    """The plugin's picture of the front or else ours, None where neither can draw it."""
    title = run_title(run.recipe)
    figure = protocol.front_figure(run.problem, outcome.X) if len(outcome.X) else None
    if figure is None and len(outcome.objectives) <= MOST_OBJECTIVES:
        figure = front_figure(outcome.X, outcome.F, outcome.variables, outcome.objectives, title)
    return None if figure is None else page(figure, title)


def _print_results(
    problem: Problem, outcome: Outcome, keeper: Keeper, drawn: bool, output: Output
) -> None:
    found = f"solutions: {len(outcome.F):,}"
    volume = outcome.hypervolume
    if volume is not None:
        seen = "" if volume.space == "problem" else " of the range this run saw"
        found += f"; hypervolume {volume.value:.4f}{seen}"
    took = f"{outcome.evaluations:,} evaluations in {clock(outcome.wall_time)}"
    output.print(f"{outcome.status} after {took}; {found}")
    if outcome.failures:
        output.print(_failures(outcome))
    if not len(outcome.F):
        output.print("no feasible solution was found")
    elif output.for_people:
        output.print(_solutions(problem, outcome))
    output.print(f"written: {keeper.folder / (FIGURE_FILE if drawn else '')}")
    if keeper.error is not None:
        output.print(f"no checkpoint: {keeper.error}")
    elif outcome.status == "interrupted" and keeper.can_go_on:
        output.print(f"to go on: mgeo resume {keeper.folder}")


def _failures(outcome: Outcome) -> str:
    causes = [f"{cause} ({count:,})" for cause, count in outcome.failures.items()]
    more = f" and {len(causes) - _CAUSES} more, see run.json" if len(causes) > _CAUSES else ""
    total = sum(outcome.failures.values())
    return f"failed evaluations: {total:,}; {', '.join(causes[:_CAUSES])}{more}"


def _solutions(problem: Problem, outcome: Outcome) -> Table:
    """One column per solution, one row per quantity: any number of variables fits a terminal.

    The quantities are those of ``problem.describe``, or else objectives and variables.
    """
    chosen = highlights(problem, outcome.F, outcome.objectives)
    rows = [highlight.row for highlight in chosen]
    described = protocol.describe(problem, outcome.X[rows])
    if described is None:
        described = front_table(outcome).iloc[rows][[*outcome.objectives, *outcome.variables]]
    titles = ["", *(highlight.label for highlight in chosen)]
    return table(titles, [(str(name), *described[name]) for name in described.columns])


def _document(made: Run, keeper: Keeper) -> dict[str, Any]:
    names = (FRONT_FILE, RUN_FILE, FIGURE_FILE, CHECKPOINT_FILE, RECORD_FOLDER)
    return {
        "folder": str(keeper.folder),
        "files": [name for name in names if (keeper.folder / name).exists()],
        "checkpoint_error": None if keeper.error is None else str(keeper.error),
        **run_document(made),
    }
