"""Progress of a run: redrawn in place on a terminal, as lines in a pipe or a log."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from typing import Any

from rich import progress
from rich.console import Console, Group
from rich.live import Live

from mgeo.cli.errors import StopRequest
from mgeo.plugins.protocol import column_names
from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.solve import State
from mgeo.store.run import RunConfiguration
from mgeo.terminal import plain

_MAX_SHARE = 0.02  # largest share of the run time that the computation of what is shown may take
_STOPPING = "stopping after this generation; Ctrl-C again to stop at once"


class Progress:
    """Callback of a run that shows its progress and passes on a request to stop.

    Parameters
    ----------
    console
        Where to show the progress.
    title
        First line.
    request
        Signals received so far.

    Attributes
    ----------
    interval
        Shortest time between two updates [s].
    """

    def __init__(self, console: Console, title: str, request: StopRequest) -> None:
        self._console = console
        self._title = plain(title, style="bold")
        self._request = request
        self.interval = 0.25 if console.is_terminal else 10.0
        self._next = 0.0
        self._state: State | None = None
        self._numbers = ""
        self._bar = progress.Progress(
            progress.BarColumn(),
            progress.TextColumn("{task.fields[done]}"),
            progress.TimeElapsedColumn(),
            progress.TextColumn("left"),
            progress.TimeRemainingColumn(compact=True),
        )
        self._task = self._bar.add_task("", total=None, done="first generation")

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Redraw the progress on a terminal meanwhile. Elsewhere print lines."""
        if not self._console.is_terminal:
            self._print(self._title)
            yield
            self._update()
        else:
            with Live(self, console=self._console, refresh_per_second=1 / self.interval):
                yield
                self._update()

    def __call__(self, state: State) -> None:
        """Stop the run if that was requested, and show its state if the interval has passed."""
        if self._request:
            state.stop()
        self._state = state
        if time.monotonic() >= self._next:
            begin = time.process_time()
            self._update()
            pause = max(self.interval, (time.process_time() - begin) / _MAX_SHARE)
            self._next = time.monotonic() + pause

    def __rich__(self) -> Group:
        """Return what is drawn on a terminal."""
        stopping = [plain(_STOPPING, style="yellow")] if self._request else []
        return Group(self._title, self._bar, plain(self._numbers), *stopping)

    def _update(self) -> None:
        state = self._state
        if state is None:
            return
        self._numbers = _numbers(state)
        done = f"{state.evaluations:,} of {state.budget:,} evaluations"
        completed = min(state.evaluations, state.budget)
        self._bar.update(self._task, total=state.budget, completed=completed, done=done)
        if not self._console.is_terminal:
            task, left = self._bar.tasks[0], self._bar.tasks[0].time_remaining
            times = f"elapsed {clock(state.elapsed)}  left {'-' if left is None else clock(left)}"
            self._print(plain(f"{task.percentage:3.0f}%  {done}  {self._numbers}  {times}"))

    def _print(self, line: Any) -> None:
        self._console.print(line, soft_wrap=True)


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


def clock(seconds: float) -> str:
    """Return a duration as hours, minutes and seconds: 1:02:03."""
    return str(timedelta(seconds=round(seconds)))


def _numbers(state: State) -> str:
    """Return the size and the quality of the front, and what went wrong, in one line."""
    _, F = state.front()
    shown = {"front": f"{len(F):,}"}
    if state.refinement is not None:
        shown["polished"] = f"{int(state.refinement.changed.sum()) + state.refinement.added:,}"
    if failed := sum(state.failures.values()):
        shown["failed"] = f"{failed:,}"
    if len(F):
        best = zip(column_names(state.problem)[1], F.min(axis=0), strict=True)
        shown |= {f"best {name}": f"{value:.6g}" for name, value in best}
    if (volume := state.hypervolume(F)) is not None:
        shown["hypervolume"] = f"{volume:.4f}"
    if state.checkpoint_error is not None:
        shown["no checkpoint:"] = state.checkpoint_error
    return "  ".join(f"{name} {text}" for name, text in shown.items())
