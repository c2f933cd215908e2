"""``mgeo solve`` and ``mgeo resume``: run, write the folder, show what was found."""

from __future__ import annotations

import tempfile
import warnings
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from mgeo.cli.errors import ExitCode, Refused, bad_input, stop_requests
from mgeo.cli.output import Output
from mgeo.cli.progress import Progress, run_title, task
from mgeo.cli.results import Findings, document, print_impossible, print_results
from mgeo.evaluation.evaluator import EvaluationError
from mgeo.figures import page
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, front_of, view_of
from mgeo.runs.prepare import PreparedRun
from mgeo.runs.resume import resume_run
from mgeo.store.atomic import check_writable, lock, write_file
from mgeo.store.provenance import installed_versions
from mgeo.store.run import Outcome, Run
from mgeo.store.run_folder import FIGURE_FILE, check_folder, write_run
from mgeo.store.run_persistence import RunPersistence
from mgeo.terminal import console

_GO_ON = "To go on once that is put right: mgeo resume {}"


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
    run: PreparedRun,
    persistence: RunPersistence,
    output: Output,
    *,
    overwrite: bool,
    verbose: bool = False,
) -> int:
    """Run it to its end, write what it found into its folder; the exit code.

    Without `overwrite` there may be nothing in the folder. If it is `verbose`, all parameters of
    the algorithm are told.

    0 if the budget was used, 3 if nothing that was found keeps all limits, 128 + the number of the
    signal that stopped the run. Where the problem knows that nothing can, nothing is searched, nor
    written.
    """
    folder = persistence.folder
    if impossible := ask(view_of(run.problem), View.impossible):
        print_impossible(impossible, output)
        return ExitCode.INCOMPLETE
    # until everything is written: impatience must not cost a run, nor another run its files
    with ExitStack() as stack, stop_requests() as stop:
        with bad_input():
            if not folder.exists():
                stack.callback(_remove_if_empty, folder)  # once the lock is released
            folder.mkdir(parents=True, exist_ok=True)
            stack.enter_context(lock(folder))
            # another run may have ended there since somebody looked
            check_folder(folder, overwrite=overwrite)
            check_writable(folder)
        seen = None if output.quiet else console(stderr=True)
        progress = Progress(
            seen, task(run.configuration, run.problem, verbose=verbose), stop, persistence
        )
        try:
            # of errors while it runs only those of writing are the user's to put right
            with bad_input((OSError,)), progress.shown():
                outcome = run.solve(progress, persistence)
        except BaseException as error:
            persistence.drop_if_useless()
            if persistence.can_resume and isinstance(error, EvaluationError | Refused):
                output.note(_GO_ON.format(folder))
            raise
        made = Run(run.configuration, outcome, installed_versions(run.configuration.problem))
        written, failed, view = False, None, None
        try:
            with bad_input():
                # the folder was checked before the run: whatever is in it now may be replaced
                write_run(folder, made, overwrite=True)
                written = True
                view = _view(run, outcome)
                html = _front_page(run, outcome, view)
                if html is not None:
                    write_file(folder / FIGURE_FILE, html.encode())
        except Refused as error:  # what was found is told all the same
            failed = error
    view = view or _view(run, outcome)
    told, table = output.json or not output.quiet, output.for_people
    found = Findings.of(view, outcome, remarks=told, table=table)
    print_results(outcome, found, persistence, output, written=written)
    output.result(document(made, found, persistence, written=written))
    if not written:
        output.note(_still_to_be_had(made, persistence))
    if failed is not None:
        raise failed
    if outcome.status == "interrupted":
        return stop.exit_code or ExitCode.INTERRUPTED
    return ExitCode.DONE if len(outcome.F) else ExitCode.INCOMPLETE


def _still_to_be_had(made: Run, persistence: RunPersistence) -> str:
    """Of a run that could not be written: its checkpoint, or else a copy on another disk."""
    if persistence.can_resume:
        return _GO_ON.format(persistence.folder)
    with suppress(OSError):
        place = Path(tempfile.mkdtemp(prefix="mgeo-"))
        with ExitStack() as stack:
            stack.callback(_remove_if_empty, place)
            write_run(place, made)
            return f"The run was written into {place} instead"
    return "The run could not be written elsewhere either"


def _remove_if_empty(folder: Path) -> None:
    with suppress(OSError):  # one with something in it stays
        folder.rmdir()


def _view(run: PreparedRun, outcome: Outcome) -> View:
    """What was found, or of a run that found nothing that keeps all limits the nearest."""
    shown = outcome.nearest or outcome
    return view_of(run.problem, shown.X, shown.F)


def _front_page(run: PreparedRun, outcome: Outcome, view: View) -> str | None:
    """The plugin's picture of the front or else ours, None where neither can draw it.

    Of a run that found nothing that keeps all limits it says so.
    """
    title, note = run_title(run.configuration), ""
    if outcome.nearest:
        note = f"Nothing that was found keeps all limits. These {len(view.X)} come nearest."
    figure = front_of(view, title)
    return None if figure is None else page(figure, title, note)
