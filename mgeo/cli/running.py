"""What ``mgeo solve`` and ``mgeo resume`` share: run, write the folder, show what was found."""

from __future__ import annotations

from contextlib import ExitStack, suppress

import typer
from rich.text import Text

from mgeo.cli.consoles import console
from mgeo.cli.displays import clock, run_display
from mgeo.cli.errors import one_line_errors
from mgeo.cli.progress import Reporter
from mgeo.cli.signals import StopRequest, stop_requests
from mgeo.cli.solutions import solutions_table
from mgeo.evaluation import EvaluationError
from mgeo.figures import front_figure, page
from mgeo.runs import (
    FIGURE_FILE,
    Keeper,
    Outcome,
    PreparedRun,
    ResumedRun,
    Run,
    installed_versions,
    write_figure,
    write_run,
)
from mgeo.runs.sole_use import sole_use

_CAUSES = 3  # of failed evaluations are shown


def run_to_folder(
    run: PreparedRun | ResumedRun, keeper: Keeper, *, quiet: bool, debug: bool
) -> int:
    """Run it to its end, write what it found into the keeper's folder; the exit code.

    0 if the budget was used, 128 + the number of the signal that stopped the run.
    """
    folder = keeper.folder
    # until everything is written: impatience must not cost a run, nor another run its files
    with ExitStack() as stack, stop_requests() as stop:
        with one_line_errors(debug):
            stack.enter_context(sole_use(folder))
        try:
            # of errors while it runs only those of writing are the user's to put right
            with one_line_errors(debug, (OSError,)):
                outcome = _solve(run, keeper, stop, quiet)
        except BaseException as error:
            keeper.drop_if_useless()
            with suppress(OSError):  # a folder with something in it stays
                folder.rmdir()
            if keeper.can_go_on and isinstance(error, EvaluationError):
                typer.echo(f"To go on once that is put right: mgeo resume {folder}", err=True)
            raise
        made = Run(run.recipe, outcome, installed_versions(run.recipe.problem))
        with one_line_errors(debug):
            # the folder was checked before the run: whatever is in it now may be replaced
            write_run(folder, made, overwrite=True)
        html = _front_page(run, outcome)
        with one_line_errors(debug):
            if html is not None:
                write_figure(folder, html)
    if not quiet:
        _print_results(run, outcome, keeper, html is not None)
    return stop.exit_code if outcome.status == "interrupted" else 0


def _solve(
    run: PreparedRun | ResumedRun, keeper: Keeper, stop: StopRequest, quiet: bool
) -> Outcome:
    with ExitStack() as shown:
        display = None
        if not quiet:
            display = shown.enter_context(run_display(console(stderr=True), _title(run), stop))
        return run.solve(Reporter(display, stop, keeper), keeper)


def _title(run: PreparedRun | ResumedRun) -> str:
    recipe = run.recipe
    values = ", ".join(f"{key} = {value}" for key, value in recipe.parameters.items())
    return f"{recipe.problem} · {recipe.algorithm} ({values}) · seed {recipe.seed}"


def _front_page(run: PreparedRun | ResumedRun, outcome: Outcome) -> str | None:
    """The plugin's picture of the front or else ours, None where neither can draw it."""
    title = _title(run)
    figure = None
    if hasattr(run.problem, "figures") and len(outcome.X):
        figure = run.problem.figures(outcome.X).get("front")
    if figure is None and len(outcome.objectives) <= 3:
        figure = front_figure(outcome.X, outcome.F, outcome.variables, outcome.objectives, title)
    return None if figure is None else page(figure, title)


def _print_results(
    run: PreparedRun | ResumedRun, outcome: Outcome, keeper: Keeper, drawn: bool
) -> None:
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
        out.print(solutions_table(run.problem, outcome))
    else:
        out.print(Text("no feasible solution was found"))
    out.print(Text(f"written: {keeper.folder / (FIGURE_FILE if drawn else '')}"), soft_wrap=True)
    if keeper.error is not None:
        out.print(Text(f"no checkpoint: {keeper.error}"), soft_wrap=True)
    elif outcome.status == "interrupted" and keeper.can_go_on:
        out.print(Text(f"to go on: mgeo resume {keeper.folder}"), soft_wrap=True)


def _failures(outcome: Outcome) -> list[str]:
    if not outcome.failures:
        return []
    causes = [f"{cause} ({count:,})" for cause, count in outcome.failures.items()]
    more = f" and {len(causes) - _CAUSES} more, see run.json" if len(causes) > _CAUSES else ""
    total = sum(outcome.failures.values())
    return [f"failed evaluations: {total:,}; {', '.join(causes[:_CAUSES])}{more}"]
