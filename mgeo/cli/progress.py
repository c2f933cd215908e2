"""Progress of a run: redrawn in place on a terminal, as lines in a pipe or a log."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich import progress
from rich.console import Console, Group
from rich.live import Live

from mgeo.cli.errors import StopRequest
from mgeo.plugins.protocol import problem_size
from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.solve import State
from mgeo.store.run import RunConfiguration
from mgeo.terminal import pairs, plain

if TYPE_CHECKING:
    from mgeo.runs.prepare import PreparedRun

_MAX_SHARE = 0.02  # largest share of the run time that the computation of what is shown may take
_STOPPING = "stopping after this generation; Ctrl-C again to stop at once"


class Progress:
    """Callback of a run that shows its progress and passes on a request to stop.

    Parameters
    ----------
    console
        Where to show the progress, None for nowhere.
    title
        First line.
    request
        Signals received so far.

    Attributes
    ----------
    interval
        Shortest time between two updates [s].
    """

    def __init__(self, console: Console | None, title: str, request: StopRequest) -> None:
        self._console = console
        self._title = title
        self._request = request
        self._is_live = console is not None and console.is_terminal and not console.is_dumb_terminal
        self.interval = 0.25 if self._is_live else 10.0
        self._next = 0.0
        self._quantities: dict[str, str] = {}
        self._bar = progress.Progress(
            progress.BarColumn(),
            progress.TextColumn("{task.fields[done]}"),
            progress.TimeElapsedColumn(),
            progress.TextColumn("left"),
            progress.TimeRemainingColumn(compact=True),
        )
        self._task = self._bar.add_task(title, total=None, done="first generation")

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Redraw the progress on a terminal meanwhile. Elsewhere print the title."""
        if self._is_live:
            with Live(self, console=self._console, refresh_per_second=1 / self.interval):
                yield
        else:
            self._print(self._title)
            yield

    def __call__(self, state: State) -> None:
        """Show the state of the run if the interval has passed or the run has ended."""
        if self._request:
            state.stop()
        if state.ended:
            self._request.may_raise = False
        now = time.monotonic()
        if self._console is None or (now < self._next and not state.ended):
            return
        begin = time.process_time()
        self._quantities = _quantities(state)
        self._bar.update(
            self._task,
            total=state.budget,
            completed=min(state.evaluations, state.budget),
            done=f"{state.evaluations:,} of {state.budget:,} evaluations",
        )
        if not self._is_live:
            self._print_line()
        self._next = now + max(self.interval, (time.process_time() - begin) / _MAX_SHARE)

    def __rich__(self) -> Group:
        """Return what is drawn on a terminal."""
        lines: list[Any] = [plain(self._title, style="bold"), self._bar, pairs(self._quantities)]
        if self._request:
            lines.append(plain(_STOPPING, style="yellow"))
        return Group(*lines)

    def _print_line(self) -> None:
        (task,) = self._bar.tasks
        left = "-" if task.time_remaining is None else clock(task.time_remaining)
        fields = {**self._quantities, "elapsed": clock(task.elapsed or 0.0), "left": left}
        shown = [f"{task.percentage:3.0f}%", task.fields["done"]]
        self._print("  ".join([*shown, *(f"{name} {text}" for name, text in fields.items())]))

    def _print(self, line: str) -> None:
        if self._console is not None:
            self._console.print(plain(line), soft_wrap=True)


def run_title(run: RunConfiguration) -> str:
    """Return the title of a run, with the parameters that differ from the defaults."""
    # a file has no tuples
    defaults = json.loads(json.dumps(complete_parameters(run.algorithm, {}), default=str))
    values = ", ".join(
        f"{key} = {value}" for key, value in run.parameters.items() if value != defaults.get(key)
    )
    parts = [run.problem, f"{run.algorithm}{f' ({values})' if values else ''}", f"seed {run.seed}"]
    parts += [f"{run.starts} starts"] if run.starts else []
    parts += ["polished"] if run.polish else []
    return " · ".join(parts)


def heading(run: PreparedRun) -> str:
    """Return a line that describes a run before it begins."""
    objectives = ", ".join(problem_size(run.problem)["objectives"])
    return (
        f"{run_title(run.configuration)}: {run.configuration.evaluations:,} evaluations of "
        f"{run.problem.n_var} variables for {objectives}"
    )


def clock(seconds: float) -> str:
    """Return a duration as minutes and seconds, from one hour on with hours: 0:07, 1:02:03."""
    minutes, second = divmod(round(seconds), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02}:{second:02}" if hours else f"{minute}:{second:02}"


def _quantities(state: State) -> dict[str, str]:
    _, F = state.front()
    shown = {"front": f"{len(F):,}"}
    if state.refinement is not None:
        shown["polished"] = f"{int(state.refinement.changed.sum()) + state.refinement.added:,}"
    if failed := sum(state.failures.values()):
        shown["failed"] = f"{failed:,}"
    if len(F):
        best = zip(state.objectives, F.min(axis=0), strict=True)
        shown |= {f"best {name}": f"{value:.6g}" for name, value in best}
    if (volume := state.hypervolume(F)) is not None:
        shown["hypervolume"] = f"{volume:.4f}"
    if state.checkpoint_error is not None:
        shown["no checkpoint:"] = state.checkpoint_error
    return shown
