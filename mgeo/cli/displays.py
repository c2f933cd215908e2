"""A run under way on a terminal, or as lines in a pipe or log."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table

from mgeo.cli.progress import Display, Snapshot
from mgeo.cli.signals import StopRequest
from mgeo.terminal import pairs, plain

_STOPPING = "stopping after this generation; Ctrl-C again to stop at once"


@contextmanager
def run_display(console: Console, title: str, request: StopRequest) -> Iterator[Display]:
    """What suits the console: redrawn in place on a terminal, lines without escapes elsewhere."""
    if not console.is_terminal or console.is_dumb_terminal:
        yield PlainDisplay(console, title)
        return
    display = LiveDisplay(title, request)
    with Live(display, console=console, refresh_per_second=1 / display.interval):
        yield display


class PlainDisplay:
    """One line now and then."""

    interval = 10.0

    def __init__(self, console: Console, title: str) -> None:
        self._console = console
        self._print(title)

    def show(self, snapshot: Snapshot) -> None:
        """Print it."""
        share = min(1.0, snapshot.evaluations / snapshot.budget)
        fields = [f"{share:4.0%}", _evaluations(snapshot)]
        fields += [f"{name} {value}" for name, value in _quantities(snapshot) + _times(snapshot)]
        self._print("  ".join(fields))

    def _print(self, line: str) -> None:
        self._console.print(plain(line), soft_wrap=True)


class LiveDisplay:
    """A bar and a few numbers; rich asks for them (`__rich__`) at every refresh."""

    interval = 0.25

    def __init__(self, title: str, request: StopRequest) -> None:
        self._title = title
        self._request = request
        self._snapshot: Snapshot | None = None
        self._start = self._taken = time.monotonic()

    def show(self, snapshot: Snapshot) -> None:
        """Take it over for the next refresh."""
        self._snapshot, self._taken = snapshot, time.monotonic()

    def __rich__(self) -> RenderableType:
        snapshot = self._snapshot
        lines: list[RenderableType] = [plain(self._title, style="bold")]
        if snapshot is None:
            lines.append(plain(f"first generation  {clock(time.monotonic() - self._start)}"))
        else:
            since = 0.0 if snapshot.last else time.monotonic() - self._taken
            lines += [_bar(snapshot), pairs(dict(_times(snapshot, since) + _quantities(snapshot)))]
        if self._request and not (snapshot and snapshot.last):
            lines.append(plain(_STOPPING, style="yellow"))
        return Group(*lines)


def clock(seconds: float) -> str:
    """A duration as minutes and seconds, with hours from one hour on: 0:07, 1:02:03."""
    minutes, second = divmod(round(seconds), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02}:{second:02}" if hours else f"{minute}:{second:02}"


def _evaluations(snapshot: Snapshot) -> str:
    return f"{snapshot.evaluations:,} of {snapshot.budget:,} evaluations"


def _times(snapshot: Snapshot, since: float = 0.0) -> list[tuple[str, str]]:
    left = "-" if snapshot.left is None else clock(max(0.0, snapshot.left - since))
    return [("elapsed", clock(snapshot.elapsed + since)), ("left", left)]


def _quantities(snapshot: Snapshot) -> list[tuple[str, str]]:
    shown = [("front", f"{snapshot.solutions:,}")]
    if snapshot.failed:
        shown.append(("failed", f"{snapshot.failed:,}"))
    shown += [(f"best {name}", f"{value:.6g}") for name, value in snapshot.best.items()]
    if snapshot.hypervolume is not None:
        name = "hypervolume" if snapshot.whole_space else "hypervolume (of the range seen)"
        shown.append((name, f"{snapshot.hypervolume:.4f}"))
    if snapshot.trouble:
        shown.append(("no checkpoint:", snapshot.trouble))
    return shown


def _bar(snapshot: Snapshot) -> RenderableType:
    row = Table.grid(padding=(0, 2))
    done = min(snapshot.evaluations, snapshot.budget)
    row.add_row(ProgressBar(snapshot.budget, done, width=40), plain(_evaluations(snapshot)))
    return row
