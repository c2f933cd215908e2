"""``mgeo solve`` and ``mgeo resume``: run, write the run folder, and print the summary."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from rich.table import Table
from rich.text import Text

from mgeo.cli.errors import ExitCode, StopRequest, bad_input, stop_requests
from mgeo.cli.output import Output
from mgeo.cli.progress import Progress, clock, run_title, task
from mgeo.evaluation.evaluator import EvaluationError
from mgeo.figures.page import page
from mgeo.plugins.discovery import code_of_others
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
from mgeo.store.atomic import check_writable, lock, write_file
from mgeo.store.provenance import installed_versions
from mgeo.store.run import Outcome, Run
from mgeo.store.run_folder import (
    ARRAYS_FILE,
    CHECKPOINT_FILE,
    FIGURE_FILE,
    FRONT_FILE,
    NEAREST_FILE,
    RECORD_FOLDER,
    RUN_FILE,
    check_folder,
    remove_run,
    run_document,
    write_arrays,
    write_run,
)
from mgeo.store.run_persistence import RunPersistence
from mgeo.terminal import console, fits, plain, table

if TYPE_CHECKING:
    import pandas as pd

_CAUSES = 3  # causes of failed evaluations that are printed


def run_to_folder(
    run: PreparedRun,
    persistence: RunPersistence,
    output: Output,
    *,
    overwrite: bool,
    max_time: float | None = None,
    verbose: bool = False,
) -> int:
    """Run until the budget is used, write the run folder and print the summary.

    Parameters
    ----------
    overwrite
        Whether another run in the folder may be replaced.
    max_time
        Time from now after which the run ends [s].
    verbose
        Whether to print all parameters of the algorithm.

    Returns
    -------
    Exit code: 0 if the run ended by its budget or `max_time`, 3 if no solution satisfies all
    constraints or the problem knows that none can, 128 + the number of the signal that stopped the
    run.
    """
    if impossible := ask(view_of(run.problem), View.impossible):
        output.print(plain("nothing can keep all limits", "bold"), *(f"  {w}" for w in impossible))
        output.result({"impossible": impossible})
        return ExitCode.INCOMPLETE
    folder = persistence.folder
    with bad_input():
        folder.mkdir(parents=True, exist_ok=True)
    with stop_requests() as stop, bad_input((ValueError, OSError)), lock(folder):
        check_folder(folder, overwrite=overwrite)
        check_writable(folder)
        if run.notes is None:
            remove_run(folder)
        outcome = _search(run, persistence, output, stop, max_time, verbose=verbose)
        made = Run(run.configuration, outcome, installed_versions(run.configuration.problem))
        try:
            write_run(folder, made, overwrite=True)
        except OSError:
            if persistence.can_resume:
                output.note(_resume_hint(persistence))
            raise
        view = _view(run, outcome)
        try:
            _write_extras(run, outcome, view, persistence)
        finally:  # the summary is printed even if a figure fails
            findings = Findings.of(view, outcome, output)
            print_results(outcome, findings, persistence, output)
            output.result(document(made, findings, persistence))
    if outcome.stop_reason == "signal":
        return stop.exit_code or ExitCode.INTERRUPTED
    return ExitCode.DONE if len(outcome.F) else ExitCode.INCOMPLETE


def _search(
    run: PreparedRun,
    persistence: RunPersistence,
    output: Output,
    stop: StopRequest,
    max_time: float | None,
    *,
    verbose: bool,
) -> Outcome:
    shown = None if output.quiet else console(stderr=True)
    title = task(run.configuration, run.problem, verbose=verbose)
    progress = Progress(shown, title, stop, persistence)
    try:
        with progress.shown():
            return run.solve(progress, persistence, max_time)
    except (EvaluationError, OSError):
        if persistence.can_resume:
            output.note(_resume_hint(persistence))
        raise


def _resume_hint(persistence: RunPersistence) -> str:
    return f"To go on once that is put right: mgeo resume {persistence.folder}"


def _view(run: PreparedRun, outcome: Outcome) -> View:
    """Return a view of the front, or of the nearest solutions if no solution is feasible."""
    shown = outcome.nearest or outcome
    return view_of(run.problem, shown.X, shown.F)


def _write_extras(
    run: PreparedRun, outcome: Outcome, view: View, persistence: RunPersistence
) -> None:
    """Write the further arrays of the problem, and the figure of the front."""
    if len(outcome.F):
        with code_of_others(f"arrays() of problem {type(run.problem).__name__} raised"):
            arrays = view.arrays()
        if arrays:
            write_arrays(persistence.folder, outcome, arrays)
    title, note = run_title(run.configuration), ""
    if outcome.nearest:
        note = f"Nothing that was found keeps all limits. These {len(view.X)} come nearest."
    figure = front_of(view, title)
    if figure is not None:
        html = page(figure, title, note)
        write_file(persistence.folder / FIGURE_FILE, html.encode())


@dataclass(frozen=True)
class Findings:
    """Summary of an outcome: answer, or why no solution is feasible, and remarks of the problem.

    Representative solutions have a row each in a table of the problem.
    """

    answer: Answer | None = None
    dead_end: DeadEnd | None = None
    remarks: list[str] = field(default_factory=list)
    chosen: list[RepresentativeSolution] = field(default_factory=list)
    described: pd.DataFrame | None = None

    @classmethod
    def of(cls, view: View, outcome: Outcome, output: Output) -> Findings:
        """Return what the output needs. Remarks of a problem can take seconds."""
        if outcome.nearest:
            return cls(dead_end=dead_end(view))
        if not len(outcome.F):
            return cls()
        chosen = representative_solutions(view.problem, outcome.F, outcome.objectives)
        few = view.take([solution.row for solution in chosen])
        described = ask(few, View.describe) if output.for_people else None
        remarks = ask(view, View.remarks) if output.json or not output.quiet else []
        return cls(answer(view), None, remarks, chosen, described)


def print_results(
    outcome: Outcome, findings: Findings, persistence: RunPersistence, output: Output
) -> None:
    """Print the answer, or suggestions if no solution is feasible, the statistics and solutions."""
    if findings.answer is not None:
        output.print(plain(findings.answer, "bold"))
    if findings.dead_end is not None:
        output.print(*_suggestions(findings.dead_end))
    size = f"solutions: {len(outcome.F):,}"
    if outcome.hypervolume is not None:
        size += f"; hypervolume {outcome.hypervolume:.4f}"
    took = f"{outcome.evaluations:,} evaluations in {clock(outcome.wall_time_s)}"
    output.print(f"{outcome.end} after {took}; {size}", *findings.remarks)
    if outcome.refined or outcome.added:
        output.print(
            f"polished: {outcome.refined:,} solutions of the search are better by it, "
            f"{outcome.added:,} more were found"
        )
    if outcome.unrefined:
        output.print(f"not polished to the end: {outcome.unrefined}")
    if outcome.failures:
        output.print(_failures(outcome))
    if findings.described is not None:
        output.print(_solutions(findings.chosen, findings.described))
    elif not len(outcome.F) and findings.dead_end is None:
        output.print("no feasible solution was found")
    picture = persistence.folder / FIGURE_FILE
    output.print(f"written: {picture if picture.exists() else persistence.folder}")
    if persistence.error is not None:
        output.print(f"no checkpoint: {persistence.error}")
    elif outcome.stop_reason in ("signal", "max_time") and persistence.can_resume:
        output.print(f"to go on: mgeo resume {persistence.folder}")


def document(made: Run, findings: Findings, persistence: RunPersistence) -> dict[str, Any]:
    """Return what ``--json`` prints."""
    results = (FRONT_FILE, ARRAYS_FILE, RUN_FILE, NEAREST_FILE, FIGURE_FILE)
    names = (*results, CHECKPOINT_FILE, RECORD_FOLDER)
    return {
        "folder": str(persistence.folder),
        "files": [name for name in names if (persistence.folder / name).exists()],
        "answer": None if findings.answer is None else asdict(findings.answer),
        "dead_end": None if findings.dead_end is None else asdict(findings.dead_end),
        "remarks": findings.remarks,
        "checkpoint_error": None if persistence.error is None else str(persistence.error),
        **run_document(made),
    }


def _suggestions(found: DeadEnd) -> Iterator[str | Text]:
    yield plain("nothing that was found keeps all limits; the nearest solutions exceed", "bold")
    yield from (f"  {line}" for line in found.exceeded)
    yield plain("ways out", "bold")
    yield from (f"  {line}" for line in found.ways)


def _failures(outcome: Outcome) -> str:
    causes = [f"{cause} ({count:,})" for cause, count in outcome.failures.items()]
    more = f" and {len(causes) - _CAUSES} more, see run.json" if len(causes) > _CAUSES else ""
    total = sum(outcome.failures.values())
    return f"failed evaluations: {total:,}; {', '.join(causes[:_CAUSES])}{more}"


def _solutions(chosen: list[RepresentativeSolution], described: pd.DataFrame) -> Table:
    """Return a table with one column per solution and one row per quantity.

    Solutions between the extremes and the knee are left out if the terminal is too narrow.
    """

    def table_of(places: list[int]) -> Table:
        titles = ["", *(f"{chosen[i].label} ({chosen[i].row})" for i in places)]
        shown = described.iloc[places]
        return table(titles, [(str(name), *shown[name]) for name in shown.columns])

    whole = table_of(list(range(len(chosen))))
    if fits(whole, console().width):
        return whole
    return table_of([i for i, solution in enumerate(chosen) if solution.label != "between"])
