"""``mgeo solve`` and ``mgeo resume``: run, write the folder, tell what was found."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.text import Text

from mgeo.cli.errors import ExitCode, Refused, bad_input, stop_requests
from mgeo.cli.output import Output
from mgeo.cli.progress import Progress, clock, run_title, task
from mgeo.evaluation.evaluator import EvaluationError
from mgeo.figures.page import page
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, front_of, view_of
from mgeo.runs.answer import (
    Answer,
    DeadEnd,
    RepresentativeSolution,
    answer,
    dead_end,
    representative_solutions,
)
from mgeo.runs.prepare import PreparedRun
from mgeo.runs.resume import resume_run
from mgeo.store.atomic import check_writable, lock, write_file
from mgeo.store.checkpoint import read_notes
from mgeo.store.provenance import installed_versions
from mgeo.store.run import Notes, Outcome, Run
from mgeo.store.run_folder import (
    CHECKPOINT_FILE,
    FIGURE_FILE,
    FRONT_FILE,
    NEAREST_FILE,
    RECORD_FOLDER,
    RUN_FILE,
    check_folder,
    run_document,
    write_run,
)
from mgeo.store.run_persistence import RunPersistence
from mgeo.terminal import Columns, console, plain, table
from mgeo.validation.tables import checked

if TYPE_CHECKING:
    import pandas as pd

_CAUSES = 3  # of failed evaluations are shown
_GO_ON = "To go on once that is put right: mgeo resume {}"
_SPARED = "What was in {} before is still there"


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
        output.print(plain("nothing can keep all limits", "bold"), *(f"  {w}" for w in impossible))
        output.result({"impossible": impossible})
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
            if run.notes is not None and run.notes != checked(Notes, read_notes(persistence.path)):
                raise ValueError(
                    f"{folder}: another process has gone on with the run, or begun one, since it "
                    "was read: resume it again"
                )
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
            elif persistence.waits:
                output.note(_SPARED.format(folder))
            raise
        made = Run(run.configuration, outcome, installed_versions(run.configuration.problem))
        # one that was stopped before it had anything costs the user no other
        spared = persistence.waits and not len((outcome.nearest or outcome).X)
        written, failed, view = False, None, None
        try:
            with bad_input():
                if not spared:
                    persistence.take_over()
                    # the folder was checked before the run: what is in it now may be replaced
                    write_run(folder, made, overwrite=True)
                    written = True
                    view = _view(run, outcome)
                    html = _front_page(run, outcome, view)
                    if html is not None:
                        write_file(folder / FIGURE_FILE, html.encode())
        except Refused as error:  # what was found is told all the same
            failed = error
    view = view or _view(run, outcome)
    told = output.json or not output.quiet
    found = Findings.of(view, outcome, remarks=told, table=output.for_people)
    print_results(outcome, found, persistence, output, written=written)
    output.result(document(made, found, persistence, written=written))
    if not written:
        output.note(_SPARED.format(folder) if spared else _still_to_be_had(made, persistence))
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


@dataclass(frozen=True)
class Findings:
    """What is said of an outcome: answer, why nothing keeps all limits, the problem's remarks.

    And a few solutions that tell most about the front, each with a row of a table.
    """

    answer: Answer | None = None
    dead_end: DeadEnd | None = None
    remarks: list[str] = field(default_factory=list)
    chosen: list[RepresentativeSolution] = field(default_factory=list)
    described: pd.DataFrame | None = None

    @classmethod
    def of(
        cls, view: View, outcome: Outcome, *, remarks: bool = True, table: bool = True
    ) -> Findings:
        """Those of a run, whose front, or what is nearest to one, is seen by `view`.

        A problem's remarks can take it seconds.
        """
        if outcome.nearest:
            return cls(dead_end=dead_end(view))
        if not len(outcome.F):
            return cls()
        chosen = representative_solutions(view.problem, outcome.F, outcome.objectives)
        few = view.take([solution.row for solution in chosen])
        described = ask(few, View.describe) if table else None  # first: it knows the answer, too
        said = ask(view, View.remarks) if remarks else []
        return cls(answer(view), None, said, chosen, described)


def print_results(
    outcome: Outcome,
    found: Findings,
    persistence: RunPersistence,
    output: Output,
    *,
    written: bool = True,
) -> None:
    """The answer, or a way out of a dead end, then the size of the run, solutions and files.

    Of a run that could not be `written` no files are told.
    """
    if found.answer is not None:
        output.print(plain(found.answer, "bold"))
    if found.dead_end is not None:
        output.print(*_told(found.dead_end))
    size = f"solutions: {len(outcome.F):,}"
    volume = outcome.hypervolume
    if volume is not None:
        seen = "" if volume.space == "problem" else " of the range this run saw"
        size += f"; hypervolume {volume.value:.4f}{seen}"
    took = f"{outcome.evaluations:,} evaluations in {clock(outcome.wall_time_s)}"
    output.print(f"{outcome.status} after {took}; {size}")
    output.print(*found.remarks)
    if outcome.refined or outcome.added:
        output.print(
            f"polished: {outcome.refined:,} solutions of the search are better by it, "
            f"{outcome.added:,} more were found"
        )
    if outcome.unrefined:
        output.print(f"not polished to the end: {outcome.unrefined}")
    if outcome.failures:
        output.print(_failures(outcome))
    if not len(outcome.F) and found.dead_end is None:
        output.print("no feasible solution was found")
    elif found.described is not None:
        output.print(_solutions(found.chosen, found.described))
    if written:
        picture = persistence.folder / FIGURE_FILE
        output.print(f"written: {picture if picture.exists() else persistence.folder}")
    if persistence.error is not None:
        output.print(f"no checkpoint: {persistence.error}")
    elif outcome.status == "interrupted" and persistence.can_resume:
        output.print(f"to go on: mgeo resume {persistence.folder}")


def document(
    made: Run, found: Findings, persistence: RunPersistence, *, written: bool = True
) -> dict[str, Any]:
    """What ``--json`` prints; of a run that could not be `written` other files may be there."""
    names = [CHECKPOINT_FILE, RECORD_FOLDER]
    if written:
        names = [FRONT_FILE, RUN_FILE, NEAREST_FILE, FIGURE_FILE, *names]
    return {
        "folder": str(persistence.folder),
        "files": [name for name in names if (persistence.folder / name).exists()],
        "answer": None if found.answer is None else asdict(found.answer),
        "dead_end": None if found.dead_end is None else asdict(found.dead_end),
        "remarks": found.remarks,
        "checkpoint_error": None if persistence.error is None else str(persistence.error),
        **run_document(made),
    }


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


def _solutions(chosen: list[RepresentativeSolution], described: pd.DataFrame) -> Columns:
    """One column per solution, one row per quantity: any number of variables fits a terminal.

    The quantities are those that the problem describes. Solutions between the best and the knee are
    left out where there is no room for all.
    """

    def of(places: list[int]) -> Columns:
        titles = ["", *(f"{chosen[i].label} ({chosen[i].row})" for i in places)]
        shown = described.iloc[places]
        return table(titles, [(str(name), *shown[name]) for name in shown.columns])

    every = of(list(range(len(chosen))))
    told = [i for i, solution in enumerate(chosen) if solution.label != "between"]
    return every if every.fits(console().width) else of(told)
