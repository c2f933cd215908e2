"""``mgeo solve`` and ``mgeo resume``: run, write the folder, show what was found."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pymoo.core.problem import Problem
from rich.text import Text

from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.output import Output
from mgeo.cli.progress import Progress, clock, run_title
from mgeo.cli.signals import stop_requests
from mgeo.evaluation.evaluator import EvaluationError
from mgeo.figures import MOST_OBJECTIVES, MOST_TEXTS, front_figure, page
from mgeo.files.atomic import write_file
from mgeo.files.lock import lock
from mgeo.plugins import protocol
from mgeo.runs.answer import Answer, answer
from mgeo.runs.dead_end import DeadEnd, dead_end
from mgeo.runs.folder import (
    FIGURE_FILE,
    FRONT_FILE,
    NEAREST_FILE,
    RUN_FILE,
    Run,
    check_folder,
    front_table,
    installed_versions,
    run_document,
    write_run,
)
from mgeo.runs.persistence import CHECKPOINT_FILE, RECORD_FOLDER, RunPersistence
from mgeo.runs.prepare import PreparedRun
from mgeo.runs.representative import representative_solutions
from mgeo.runs.resume import resume_run
from mgeo.runs.solve import Outcome
from mgeo.terminal import Columns, console, plain, table

_CAUSES = 3  # of failed evaluations are shown


def resumed(folder: Path, output: Output, **options: Any) -> tuple[PreparedRun, RunPersistence]:
    """The run of a folder (see `resume_run`); other versions than it was begun with are told."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", RuntimeWarning)
        run = resume_run(folder, **options)
    for warning in told:
        output.note(f"Note: {warning.message}")
    record = run.notes is not None and run.notes.record
    return run, RunPersistence(folder, run.configuration, run.algorithm, record=record)


def run_to_folder(
    run: PreparedRun, persistence: RunPersistence, output: Output, *, overwrite: bool
) -> int:
    """Run it to its end, write what it found into its folder; the exit code.

    Without `overwrite` there may be nothing in the folder.

    0 if the budget was used, 3 if nothing that was found keeps all limits, 128 + the number of the
    signal that stopped the run.
    """
    folder = persistence.folder
    # until everything is written: impatience must not cost a run, nor another run its files
    with ExitStack() as stack, stop_requests() as stop:
        with bad_input():
            stack.enter_context(lock(folder))
            # another run may have ended there since somebody looked
            check_folder(folder, overwrite=overwrite)
        seen = None if output.quiet else console(stderr=True)
        progress = Progress(seen, run_title(run.configuration), stop, persistence)
        try:
            # of errors while it runs only those of writing are the user's to put right
            with bad_input((OSError,)), progress.shown():
                outcome = run.solve(progress, persistence)
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
    found = answer(run.problem, outcome)
    dead = dead_end(run.problem, outcome.nearest) if outcome.nearest else None
    told = [] if output.quiet and not output.json else protocol.remarks(run.problem, outcome.X)
    _print_results(run.problem, outcome, found, dead, told, persistence, html is not None, output)
    output.result(_document(made, found, dead, told, persistence))
    if outcome.status == "interrupted":
        return stop.exit_code
    return ExitCode.DONE if len(outcome.F) else ExitCode.INCOMPLETE


def _front_page(run: PreparedRun, outcome: Outcome) -> str | None:
    """The plugin's picture of the front or else ours, None where neither can draw it.

    Of a run that found nothing that keeps all limits it shows the nearest, and says so.
    """
    title = run_title(run.configuration)
    X, F, note = outcome.X, outcome.F, ""
    if outcome.nearest:
        X, F = outcome.nearest.X, outcome.nearest.F
        note = f"Nothing that was found keeps all limits. These {len(X)} come nearest."
    figure = protocol.front_figure(run.problem, X) if len(X) else None
    if figure is None and len(outcome.objectives) <= MOST_OBJECTIVES:
        told = protocol.describe(run.problem, X) if len(X) <= MOST_TEXTS else None
        figure = front_figure(X, F, outcome.variables, outcome.objectives, title, told)
    return None if figure is None else page(figure, title, note)


def _print_results(
    problem: Problem,
    outcome: Outcome,
    found: Answer | None,
    dead: DeadEnd | None,
    remarks: list[str],
    persistence: RunPersistence,
    drawn: bool,
    output: Output,
) -> None:
    if found is not None:
        output.print(plain(found, "bold"))
    if dead is not None:
        output.print(*_told(dead))
    size = f"solutions: {len(outcome.F):,}"
    volume = outcome.hypervolume
    if volume is not None:
        seen = "" if volume.space == "problem" else " of the range this run saw"
        size += f"; hypervolume {volume.value:.4f}{seen}"
    took = f"{outcome.evaluations:,} evaluations in {clock(outcome.wall_time_s)}"
    output.print(f"{outcome.status} after {took}; {size}")
    output.print(*remarks)
    if outcome.failures:
        output.print(_failures(outcome))
    if not len(outcome.F) and dead is None:
        output.print("no feasible solution was found")
    elif len(outcome.F) and output.for_people:
        output.print(_solutions(problem, outcome))
    output.print(f"written: {persistence.folder / (FIGURE_FILE if drawn else '')}")
    if persistence.error is not None:
        output.print(f"no checkpoint: {persistence.error}")
    elif outcome.status == "interrupted" and persistence.can_resume:
        output.print(f"to go on: mgeo resume {persistence.folder}")


def _told(found: DeadEnd) -> Iterator[str | Text]:
    yield plain("nothing that was found keeps all limits; the nearest solutions exceed", "bold")
    yield from (f"  {line}" for line in found.exceeded)
    yield plain("ways out", "bold")
    yield from (f"  {line}" for line in found.ways)


def _failures(outcome: Outcome) -> str:
    causes = [f"{cause} ({count:,})" for cause, count in outcome.failures.items()]
    more = f" and {len(causes) - _CAUSES} more, see run.json" if len(causes) > _CAUSES else ""
    total = sum(outcome.failures.values())
    return f"failed evaluations: {total:,}; {', '.join(causes[:_CAUSES])}{more}"


def _solutions(problem: Problem, outcome: Outcome) -> Columns:
    """One column per solution, one row per quantity: any number of variables fits a terminal.

    The quantities are those of ``problem.describe``, or else objectives and variables. Solutions
    between the best and the knee are left out where there is no room for all.
    """
    chosen = representative_solutions(problem, outcome.F, outcome.objectives)
    rows = [solution.row for solution in chosen]
    described = protocol.describe(problem, outcome.X[rows])
    if described is None:
        described = front_table(outcome).iloc[rows][[*outcome.objectives, *outcome.variables]]

    def of(places: list[int]) -> Columns:
        titles = ["", *(f"{chosen[i].label} ({chosen[i].row})" for i in places)]
        shown = described.iloc[places]
        return table(titles, [(str(name), *shown[name]) for name in shown.columns])

    every = of(list(range(len(chosen))))
    told = [i for i, solution in enumerate(chosen) if solution.label != "between"]
    return every if every.fits(console().width) else of(told)


def _document(
    made: Run,
    found: Answer | None,
    dead: DeadEnd | None,
    remarks: list[str],
    persistence: RunPersistence,
) -> dict[str, Any]:
    names = (FRONT_FILE, RUN_FILE, NEAREST_FILE, FIGURE_FILE, CHECKPOINT_FILE, RECORD_FOLDER)
    return {
        "folder": str(persistence.folder),
        "files": [name for name in names if (persistence.folder / name).exists()],
        "answer": None if found is None else asdict(found),
        "dead_end": None if dead is None else asdict(dead),
        "remarks": remarks,
        "checkpoint_error": None if persistence.error is None else str(persistence.error),
        **run_document(made),
    }
