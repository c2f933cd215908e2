"""``mgeo solve``: run, write the folder, show the most telling solutions."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.text import Text

from mgeo.cli.consoles import console
from mgeo.cli.displays import clock, run_display
from mgeo.cli.errors import one_line_errors
from mgeo.cli.parameters import flag
from mgeo.cli.progress import Reporter
from mgeo.cli.signals import StopRequest, stop_requests
from mgeo.cli.solutions import solutions_table
from mgeo.figures import front_figure, page
from mgeo.runs import (
    FIGURE_FILE,
    Outcome,
    PreparedRun,
    Run,
    installed_versions,
    prepare,
    prepare_folder,
    write_figure,
    write_run,
)
from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.scenario import read_scenario

_CAUSES = 3  # of failed evaluations are shown


@dataclass(frozen=True)
class Request:
    """What was asked for on the command line."""

    problem: str
    scenario: str | None
    algorithm: str
    parameters: Mapping[str, Any]
    evaluations: int | None
    seed: int
    out: Path
    overwrite: bool
    quiet: bool
    debug: bool


def run(request: Request) -> int:
    """Do it; the exit code.

    0 if the budget was used, 128 + the number of the signal that stopped the run.
    """
    with one_line_errors(request.debug):
        check_flags(request.algorithm, request.parameters)
        prepared = prepare(
            request.problem,
            read_scenario(request.scenario),
            algorithm=request.algorithm,
            parameters=request.parameters,
            evaluations=request.evaluations,
            seed=request.seed,
        )
        prepare_folder(request.out, overwrite=request.overwrite)
    with stop_requests() as stop:  # until everything is written: impatience must not cost a run
        try:
            outcome = _solve(prepared, request, stop)
        except BaseException:
            with suppress(OSError):  # a folder with something in it stays
                request.out.rmdir()
            raise
        made = Run(prepared.recipe, outcome, installed_versions(request.problem))
        with one_line_errors(request.debug):
            # the folder was checked before the run: whatever is in it now may be replaced
            write_run(request.out, made, overwrite=True)
        html = _front_page(prepared, outcome)
        with one_line_errors(request.debug):
            if html is not None:
                write_figure(request.out, html)
    if not request.quiet:
        _print_results(prepared, outcome, request.out, html is not None)
    return stop.exit_code if outcome.status == "interrupted" else 0


def check_flags(algorithm: str, parameters: Mapping[str, Any]) -> None:
    """Refuse flags that the algorithm does not take, in terms of flags.

    Raises
    ------
    ValueError
        Naming the flag and those the algorithm takes.
    """
    known = complete_parameters(algorithm, {})
    for key in parameters:
        if key not in known:
            flags = ", ".join(map(flag, known))
            raise ValueError(f"{flag(key)} does not apply to {algorithm}, which takes {flags}")


def _solve(prepared: PreparedRun, request: Request, stop: StopRequest) -> Outcome:
    with ExitStack() as shown:
        display = None
        if not request.quiet:
            live = run_display(console(stderr=True), _title(prepared), stop)
            display = shown.enter_context(live)
        return prepared.solve(Reporter(display, stop))


def _failures(outcome: Outcome) -> list[str]:
    if not outcome.failures:
        return []
    causes = [f"{cause} ({count:,})" for cause, count in outcome.failures.items()]
    more = f" and {len(causes) - _CAUSES} more, see run.json" if len(causes) > _CAUSES else ""
    total = sum(outcome.failures.values())
    return [f"failed evaluations: {total:,}; {', '.join(causes[:_CAUSES])}{more}"]


def _title(prepared: PreparedRun) -> str:
    recipe = prepared.recipe
    values = ", ".join(f"{key} = {value}" for key, value in recipe.parameters.items())
    return f"{recipe.problem} · {recipe.algorithm} ({values}) · seed {recipe.seed}"


def _front_page(prepared: PreparedRun, outcome: Outcome) -> str | None:
    """The plugin's picture of the front or else ours, None where neither can draw it."""
    title = _title(prepared)
    figure = None
    if hasattr(prepared.problem, "figures") and len(outcome.X):
        figure = prepared.problem.figures(outcome.X).get("front")
    if figure is None and len(outcome.objectives) <= 3:
        figure = front_figure(outcome.X, outcome.F, outcome.variables, outcome.objectives, title)
    return None if figure is None else page(figure, title)


def _print_results(prepared: PreparedRun, outcome: Outcome, folder: Path, drawn: bool) -> None:
    out = console()
    summary = [
        f"{outcome.status} after {outcome.evaluations:,} evaluations in {clock(outcome.wall_time)}",
        f"solutions: {len(outcome.F):,}",
    ]
    volume = outcome.hypervolume
    if volume is not None:
        note = "" if volume.space == "problem" else " of the range this run saw"
        summary.append(f"hypervolume {volume.value:.4f}{note}")
    out.print(Text("; ".join(summary)), soft_wrap=True)
    for line in _failures(outcome):
        out.print(Text(line), soft_wrap=True)
    if len(outcome.F):
        out.print(solutions_table(prepared.problem, outcome))
    else:
        out.print(Text("no feasible solution was found"))
    out.print(Text(f"written: {folder / (FIGURE_FILE if drawn else '')}"), soft_wrap=True)
