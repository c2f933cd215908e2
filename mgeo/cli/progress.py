"""How a run is going: redrawn in place on a terminal, as lines in a pipe or a log."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table

from mgeo.cli.errors import StopRequest
from mgeo.plugins.protocol import problem_size
from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.solve import State
from mgeo.store.run import RunConfiguration
from mgeo.store.run_persistence import RunPersistence
from mgeo.terminal import folded, pairs, plain

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

_MAX_SHARE = 0.02  # of the time of a run may go into computing what is shown
_STOPPING = "stopping after this generation; Ctrl-C again to stop at once"


class Progress:
    """Callback of a run: shows how it is going, and passes a request to stop on to it.

    Parameters
    ----------
    console
        Where to show it; None for nowhere. Only within `shown`.
    persistence
        Of the run, to tell why a checkpoint could not be written.

    Attributes
    ----------
    interval
        Least time between two looks at the run [s].
    """

    def __init__(
        self,
        console: Console | None,
        title: str,
        request: StopRequest,
        persistence: RunPersistence | None = None,
    ) -> None:
        self._console = console
        self._title = title
        self._request = request
        self._persistence = persistence
        self._live = console is not None and console.is_terminal and not console.is_dumb_terminal
        self.interval = 0.25 if self._live else 10.0
        self._next = 0.0
        self._first: tuple[int, float] | None = None
        self._latest: tuple[State, dict[str, str]] | None = None
        self._end: float | None = None  # expected, on the clock
        self._begun = time.monotonic()

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Redraw it on a terminal meanwhile; elsewhere a line tells the title."""
        if self._live:
            with Live(self, console=self._console, refresh_per_second=1 / self.interval):
                yield
        else:
            self._print(self._title)
            yield

    def __call__(self, state: State) -> None:
        """Look at the run if it is time to or the run ends here."""
        if self._request:
            state.stop()
        if self._first is None:  # the first step may include compiling: its time is not typical
            self._first = state.evaluations, state.elapsed
        now = time.monotonic()
        last = state.ended
        if last:
            self._request.settle()
        if self._console is None or (now < self._next and not last):
            return
        work = time.process_time()  # not the clock's: others may keep us waiting
        left = _time_left(state, *self._first)
        self._end = None if left is None else now + left
        self._latest = state, _quantities(state, self._persistence)
        if not self._live:
            self._print("  ".join(self._fields(*self._latest)))
        cost = time.process_time() - work
        self._next = now + max(self.interval, cost / _MAX_SHARE)

    def __rich__(self) -> RenderableType:
        """What is seen at a refresh."""
        lines: list[RenderableType] = [plain(self._title, style="bold")]
        ended = False
        if self._latest is None:
            lines.append(plain(f"first generation  {clock(time.monotonic() - self._begun)}"))
        else:
            state, quantities = self._latest
            ended = state.ended
            bar = Table.grid(padding=(0, 2))
            done = min(state.evaluations, state.budget)
            bar.add_row(ProgressBar(state.budget, done, width=40), plain(_evaluations(state)))
            lines += [bar, pairs({**self._times(state), **quantities})]
        if self._request and not ended:
            lines.append(plain(_STOPPING, style="yellow"))
        return Group(*lines)

    def _fields(self, state: State, quantities: Mapping[str, str]) -> list[str]:
        share = min(1.0, state.evaluations / state.budget)
        named = {**quantities, **self._times(state)}.items()
        return [f"{share:4.0%}", _evaluations(state), *(f"{name} {text}" for name, text in named)]

    def _times(self, state: State) -> dict[str, str]:
        left = "-" if self._end is None else clock(max(0.0, self._end - time.monotonic()))
        return {"elapsed": clock(state.elapsed), "left": left}

    def _print(self, line: str) -> None:
        if self._console is not None:
            self._console.print(plain(folded(line, stderr=True)), soft_wrap=True)


def run_title(run: RunConfiguration, *, whole: bool = False) -> str:
    """What a run is called, with the parameters that are not the algorithm's defaults, or all."""
    told = run.parameters
    if not whole:
        defaults = complete_parameters(run.algorithm, {})
        told = {
            key: value for key, value in told.items() if _json(value) != _json(defaults.get(key))
        }
    values = ", ".join(f"{key} = {value}" for key, value in told.items())
    parts = [run.problem, f"{run.algorithm}{f' ({values})' if values else ''}", f"seed {run.seed}"]
    parts += [f"{run.starts} starts"] if run.starts else []
    parts += ["polished"] if run.polish else []
    return " · ".join(parts)


def task(run: RunConfiguration, problem: Problem, *, verbose: bool = False) -> str:
    """What a run does, before it begins."""
    objectives = ", ".join(problem_size(problem)["objectives"])
    return (
        f"{run_title(run, whole=verbose)}: {run.evaluations:,} evaluations of "
        f"{problem.n_var} variables for {objectives}"
    )


def clock(seconds: float) -> str:
    """A duration as minutes and seconds, with hours from one hour on: 0:07, 1:02:03."""
    minutes, second = divmod(round(seconds), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02}:{second:02}" if hours else f"{minute}:{second:02}"


def _json(value: Any) -> str:
    """A value as it is kept in files, which know no tuples."""
    return json.dumps(value, default=str)


def _evaluations(state: State) -> str:
    return f"{state.evaluations:,} of {state.budget:,} evaluations"


def _quantities(state: State, persistence: RunPersistence | None) -> dict[str, str]:
    _, F = state.front()
    shown = {"front": f"{len(F):,}"}
    if state.refinement is not None:
        shown["polished"] = f"{int(state.refinement.changed.sum()) + state.refinement.added:,}"
    failed = sum(state.failures.values())
    if failed:
        shown["failed"] = f"{failed:,}"
    if len(F):
        best = zip(state.objectives, F.min(axis=0), strict=True)
        shown |= {f"best {name}": f"{value:.6g}" for name, value in best}
    volume = state.hypervolume(F)
    if volume is not None:  # that of a range seen does not compare with another run's
        seen = "" if volume.space == "problem" else " (of the range seen)"
        shown[f"hypervolume{seen}"] = f"{volume.value:.4f}"
    if persistence is not None and persistence.error is not None:
        shown["no checkpoint:"] = str(persistence.error)
    return shown


def _time_left(state: State, evaluations: int, elapsed: float) -> float | None:
    """Judged by the pace since so many evaluations were made in so much time."""
    if state.evaluations <= evaluations:
        return None
    pace = (state.elapsed - elapsed) / (state.evaluations - evaluations)
    return max(0.0, pace * (state.budget - state.evaluations))
