"""Execution of a run for ``mgeo solve`` and ``mgeo resume``: progress, run folder and summary."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import progress
from rich.console import Console, Group
from rich.live import Live

from mgeo._text import format_duration
from mgeo.cli.errors import ExitCode, StopRequest, collect_stop_requests, convert_input_errors
from mgeo.cli.summary import print_summary
from mgeo.evaluation.evaluator import EvaluationError
from mgeo.figures.page import render_figure_page
from mgeo.plugins.protocol import call_optional
from mgeo.plugins.view import View, build_front_figure, build_view
from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.prepare import PreparedRun
from mgeo.runs.solve import SolveState
from mgeo.store import run_folder
from mgeo.store.atomic import check_writable, lock_folder, write_file
from mgeo.store.provenance import list_problem_versions
from mgeo.store.run import Outcome, Run, RunConfiguration
from mgeo.terminal import Output, build_console, escape_text

if TYPE_CHECKING:
    from mgeo.documents import ImpossibleDocument

    pass

_MAX_PROGRESS_SHARE = 0.02  # maximum share of the run time that the progress display may use
_STOP_MESSAGE = "Stopping after this generation. Press Ctrl-C again to stop at once."


class Progress:
    """Callback that displays the progress of a run and stops the run after a signal.

    On a terminal, the display is redrawn in place. In a pipe or a log, the title, a line per minute
    and a line at the end are printed.

    Parameters
    ----------
    console
        Console on which the progress is displayed.
    title
        First line of the display.
    request
        Stop request, which becomes true on a signal.

    Attributes
    ----------
    interval
        Minimum time between two updates of the display [s].
    """

    def __init__(self, console: Console, title: str, request: StopRequest) -> None:
        self._console = console
        self._title = escape_text(title, style="bold")
        self._request = request
        self.interval = 0.25 if console.is_terminal else 60.0
        self._next_update = 0.0
        self._state: SolveState | None = None
        self._status, self._last_line = "", ""
        self._bar = progress.Progress(
            progress.BarColumn(),
            progress.TextColumn("{task.fields[done]}"),
            progress.TimeElapsedColumn(),
            progress.TextColumn("left"),
            progress.TimeRemainingColumn(compact=True),
        )
        self._task = self._bar.add_task("", total=None, done="first generation")

    @contextmanager
    def display(self) -> Iterator[None]:
        """Context manager that shows progress in place on a terminal, otherwise line by line."""
        if not self._console.is_terminal:
            self._print(self._title)
            self._next_update = time.monotonic() + self.interval
            yield
            self._update()
        else:
            with Live(self, console=self._console, refresh_per_second=1 / self.interval):
                yield
                self._update()

    def __call__(self, state: SolveState) -> None:
        """Stop the run if a signal was received, and update the display when it is due."""
        if self._request:
            state.stop()
        self._state = state
        if time.monotonic() >= self._next_update:
            start = time.process_time()
            self._update()
            pause = max(self.interval, (time.process_time() - start) / _MAX_PROGRESS_SHARE)
            self._next_update = time.monotonic() + pause

    def __rich__(self) -> Group:
        stopping = [escape_text(_STOP_MESSAGE, style="yellow")] if self._request else []
        return Group(self._title, self._bar, escape_text(self._status), *stopping)

    def _update(self) -> None:
        state = self._state
        if state is None:
            return
        self._status = _format_state(state)
        # The last generation can exceed the budget.
        budget = f" of {state.budget:,}" if state.n_evaluations <= state.budget else ""
        done = f"{state.n_evaluations:,}{budget} evaluations"
        if state.refinement is not None:
            done = "local refinement"
        completed = min(state.n_evaluations, state.budget)
        self._bar.update(self._task, total=state.budget, completed=completed, done=done)
        if not self._console.is_terminal:
            percentage, elapsed = self._bar.tasks[0].percentage, format_duration(state.elapsed_time)
            line = f"{done}, {self._status}"
            if line != self._last_line:  # The last update of a run may add nothing.
                self._print(escape_text(f"{percentage:.0f} % after {elapsed}: {line}"))
            self._last_line = line

    def _print(self, line: Any) -> None:
        self._console.print(line, soft_wrap=True)


def execute_run(run: PreparedRun, folder: Path, output: Output, max_time: float | None) -> int:
    """Run a search, write the run folder, print a summary, and return the exit code.

    Parameters
    ----------
    run
        Prepared run, new or resumed.
    folder
        Run folder, created if it does not exist.
    output
        Destination of the summary.
    max_time
        Time after which the run ends [s], counted from the call; None for no limit.

    Returns
    -------
    int
        Exit code: 0 if a feasible solution was found, 3 if none was found or none can exist, 128 +
        the signal number if a signal stopped the run.

    Raises
    ------
    InputError
        If the folder cannot be written, or another process is using it.
    EvaluationError, PluginError
        If all evaluations or another method of the problem fail.
    """
    if reasons := call_optional(build_view(run.problem), View.infeasibility_reasons):
        output.print_title("No solution can satisfy all constraints")
        output.print_text(*(f"- {reason}" for reason in reasons))
        document: ImpossibleDocument = {"infeasibility_reasons": list(reasons)}
        output.print_document(document)
        return ExitCode.INCOMPLETE
    with convert_input_errors():
        folder.mkdir(parents=True, exist_ok=True)
    with (
        collect_stop_requests() as request,
        convert_input_errors((ValueError, OSError)),
        lock_folder(folder),
    ):
        check_writable(folder)
        if run.metadata is None:
            run_folder.remove_run(folder)
        console = Console(quiet=True) if output.quiet else build_console(stderr=True)
        progress = Progress(console, format_run_title(run.configuration), request)
        try:
            with progress.display():
                outcome = run.solve(progress, folder, max_time)
            request.may_raise = False
            finished_run = Run(
                run.configuration, outcome, list_problem_versions(run.configuration.problem)
            )
            run_folder.write_run(folder, finished_run, overwrite=True)
        except (EvaluationError, OSError):
            if (folder / run_folder.CHECKPOINT_FILE).exists():
                output.print_note(f"To continue after correcting the error: mgeo resume {folder}")
            raise
        solutions = outcome.nearest or outcome
        view = build_view(run.problem, solutions.X, solutions.F)
        try:
            _write_front_files(run, outcome, view, folder)
        finally:  # The summary is printed even if drawing the figure fails.
            print_summary(finished_run, view, folder, output)
    if outcome.stop_reason == "signal":
        return request.exit_code or ExitCode.INTERRUPTED
    return ExitCode.SUCCESS if len(outcome.F) else ExitCode.INCOMPLETE


def _write_front_files(run: PreparedRun, outcome: Outcome, view: View, folder: Path) -> None:
    if len(outcome.F) and (arrays := call_optional(view, View.arrays)):
        run_folder.write_arrays(folder, outcome, arrays)
    title, note = format_run_title(run.configuration), ""
    if outcome.nearest:
        note = f"No feasible solution was found. Shown: the {len(view.X)} nearest to feasibility."
    if (figure := build_front_figure(view, title)) is not None:
        write_file(
            folder / run_folder.FIGURE_FILE, render_figure_page(figure, title, note).encode()
        )


def format_run_title(run: RunConfiguration) -> str:
    """Return the title of a run: problem, algorithm with its non-default parameters, and seed."""
    # A configuration read from JSON has lists in place of tuples.
    defaults = json.loads(json.dumps(complete_parameters(run.algorithm, {}), default=str))
    values = ", ".join(
        f"{key} = {value}" for key, value in run.parameters.items() if value != defaults.get(key)
    )
    parts = [run.problem, f"{run.algorithm}{f' ({values})' if values else ''}", f"seed {run.seed}"]
    parts += [f"{run.initial_designs} initial designs"] if run.initial_designs else []
    parts += ["refinement"] if run.refine else []
    return " · ".join(parts)


def _format_state(state: SolveState) -> str:
    """Return a status line: front size, normalized hypervolume and failed evaluations."""
    _, F = state.build_front()
    parts = [f"{len(F):,} on the front"]
    if (hypervolume := state.compute_hypervolume(F)) is not None:
        parts.append(f"hypervolume {hypervolume:.4f}")
    if failed := sum(state.failures.values()):
        parts.append(f"{failed:,} failed")
    if state.checkpoint_error is not None:
        parts.append(f"no checkpoint: {state.checkpoint_error}")
    return ", ".join(parts)
