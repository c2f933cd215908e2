"""How a run is going, in a few numbers, taken rarely enough to cost nothing."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Protocol

from mgeo.cli.signals import StopRequest
from mgeo.runs.persistence import RunPersistence
from mgeo.runs.solve import State

_MAX_SHARE = 0.02  # of the time of a run may go into computing what is shown


@dataclass(frozen=True)
class Snapshot:
    """The state of a run; times in seconds, `left` None while it cannot be told."""

    evaluations: int
    failed: int
    budget: int
    elapsed: float
    left: float | None
    solutions: int
    best: dict[str, float]
    hypervolume: float | None
    whole_space: bool  # whether the hypervolume compares with that of another run
    trouble: str  # why the latest checkpoint could not be written; empty if it was
    last: bool  # whether the run ends here


class Display(Protocol):
    """Shows snapshots; `interval` is the least time between two, in seconds."""

    interval: float

    def show(self, snapshot: Snapshot) -> None:
        """Show this one, now or at the next refresh."""


class Reporter:
    """Callback of a run: passes snapshots to a display, and a request to stop to the run."""

    def __init__(
        self,
        display: Display | None,
        request: StopRequest,
        persistence: RunPersistence | None = None,
    ) -> None:
        self._display = display
        self._persistence = persistence
        self._request = request
        self._next = 0.0
        self._first: tuple[int, float] | None = None

    def __call__(self, state: State) -> None:
        """Take a snapshot if it is time to or the run ends here."""
        if self._request:
            state.stop()
        if self._first is None:  # the first step may include compiling: its time is not typical
            self._first = state.evaluations, state.elapsed
        now = time.monotonic()
        last = state.stopped or state.evaluations >= state.budget
        if last:
            self._request.settle()
        if self._display is None or (now < self._next and not last):
            return
        work = time.process_time()  # not the clock's: others may keep us waiting
        self._display.show(self._snapshot(state, last))
        cost = time.process_time() - work
        self._next = now + max(self._display.interval, cost / _MAX_SHARE)

    def _snapshot(self, state: State, last: bool) -> Snapshot:
        _, F = state.front()
        volume = state.hypervolume(F)
        best = F.min(axis=0).tolist() if len(F) else []
        return Snapshot(
            evaluations=state.evaluations,
            failed=sum(state.failures.values()),
            budget=state.budget,
            elapsed=state.elapsed,
            left=self._time_left(state),
            solutions=len(F),
            best=dict(zip(state.objectives, best, strict=False)),
            hypervolume=volume.value if volume else None,
            whole_space=volume is not None and volume.space == "problem",
            trouble=self._trouble(),
            last=last,
        )

    def _trouble(self) -> str:
        if self._persistence is None or self._persistence.error is None:
            return ""
        return str(self._persistence.error)

    def _time_left(self, state: State) -> float | None:
        if self._first is None or state.evaluations <= self._first[0]:
            return None
        evaluations, elapsed = self._first
        pace = (state.elapsed - elapsed) / (state.evaluations - evaluations)
        return max(0.0, pace * (state.budget - state.evaluations))
