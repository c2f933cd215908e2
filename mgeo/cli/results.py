"""What a run has found, as ``mgeo solve`` and ``mgeo resume`` tell it to people and to scripts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from rich.text import Text

from mgeo.cli.output import Output
from mgeo.cli.progress import clock
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View
from mgeo.runs.answer import (
    Answer,
    DeadEnd,
    RepresentativeSolution,
    answer,
    dead_end,
    representative_solutions,
)
from mgeo.store.run import Outcome, Run
from mgeo.store.run_folder import (
    CHECKPOINT_FILE,
    FIGURE_FILE,
    FRONT_FILE,
    NEAREST_FILE,
    RECORD_FOLDER,
    RUN_FILE,
    run_document,
)
from mgeo.store.run_persistence import RunPersistence
from mgeo.terminal import Columns, console, plain, table

if TYPE_CHECKING:
    import pandas as pd

_CAUSES = 3  # of failed evaluations are shown


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


def print_impossible(reasons: list[str], output: Output) -> None:
    """Why no search is made: nothing can keep all limits."""
    output.print(plain("nothing can keep all limits", "bold"), *(f"  {why}" for why in reasons))
    output.result({"impossible": reasons})


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
