import io
from dataclasses import replace

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems.multi import ZDT1
from rich.console import Console

from mgeo.cli.displays import LiveDisplay, PlainDisplay, clock, run_display
from mgeo.cli.progress import Reporter, Snapshot
from mgeo.cli.signals import StopRequest
from mgeo.runs.solve import solve

SNAPSHOT = Snapshot(
    evaluations=12_000,
    failed=0,
    trouble="",
    budget=60_000,
    elapsed=65.0,
    left=3700.0,
    solutions=1234,
    best={"t_end [s]": 1040.25, "trace": 2.3e-6},
    hypervolume=0.81234,
    whole_space=True,
    last=False,
)


class Recorder:
    """A display that keeps what it is shown."""

    def __init__(self, interval):
        self.interval, self.shown = interval, []

    def show(self, snapshot):
        self.shown.append(snapshot)


def rendered(display, terminal=False):
    console = Console(file=io.StringIO(), width=100, force_terminal=terminal)
    console.print(display)
    return console.file.getvalue()


def test_snapshots_say_what_the_run_has():
    recorder = Recorder(interval=0.0)
    outcome = solve(ZDT1(), NSGA2(pop_size=20), 60, 1, Reporter(recorder, StopRequest()))
    last = recorder.shown[-1]
    assert (last.evaluations, last.budget, last.solutions) == (60, 60, len(outcome.F))
    assert last.best == {"f1": outcome.F[:, 0].min(), "f2": outcome.F[:, 1].min()}
    assert last.hypervolume == outcome.hypervolume.value
    assert not last.whole_space
    assert last.left == 0
    assert (recorder.shown[0].last, last.last) == (False, True)
    assert recorder.shown[0].left is None  # one generation says nothing about the others


def test_a_display_is_updated_no_more_often_than_it_wants_but_always_at_the_end():
    recorder = Recorder(interval=60.0)
    solve(ZDT1(), NSGA2(pop_size=20), 400, 1, Reporter(recorder, StopRequest()))
    assert [snapshot.evaluations for snapshot in recorder.shown] == [20, 400]


def test_a_costly_snapshot_is_taken_less_often(monkeypatch):
    now = [0.0]
    for clock_of in ("monotonic", "process_time"):
        monkeypatch.setattr(f"mgeo.cli.progress.time.{clock_of}", lambda: now[0])
    recorder = Recorder(interval=0.25)
    recorder.show = lambda snapshot: (recorder.shown.append(now[0]), now.__setitem__(0, now[0] + 1))
    reporter = Reporter(recorder, StopRequest())

    def callback(state):
        reporter(state)
        now[0] += 10.0

    solve(ZDT1(), NSGA2(pop_size=20), 400, 1, callback)
    # a snapshot takes 1 s of this clock: the next one comes 50 s later at the earliest
    assert np.diff(recorder.shown[:-1]).min() >= 50


def test_a_request_to_stop_reaches_the_run():
    request = StopRequest()
    recorder = Recorder(interval=60.0)
    reporter = Reporter(recorder, request)

    def callback(state):
        if state.evaluations == 60:
            request.signal = 2
        reporter(state)

    outcome = solve(ZDT1(), NSGA2(pop_size=20), 400, 1, callback)
    assert (outcome.status, outcome.evaluations) == ("interrupted", 60)
    assert recorder.shown[-1].evaluations == 60


def test_the_live_display_shows_everything_with_units():
    display = LiveDisplay("a title [s]", StopRequest())
    assert "first generation" in rendered(display)
    display.show(SNAPSHOT)
    text = rendered(display)
    for part in (
        "a title [s]",
        "12,000 of 60,000 evaluations",
        "1,234",
        "best t_end [s]  1040.25",
        "best trace",
        "2.3e-06",
        "0.8123",
        "1:05",
        "1:01:40",
    ):
        assert part in text, part
    assert "range seen" not in text
    assert "Ctrl-C" not in text


def test_the_live_display_says_what_a_hypervolume_means_and_that_it_is_stopping():
    request = StopRequest()
    display = LiveDisplay("title", request)
    display.show(replace(SNAPSHOT, whole_space=False))
    request.signal = 2
    text = rendered(display)
    assert "hypervolume (of the range seen)" in text
    assert "Ctrl-C again to stop at once" in text
    display.show(replace(SNAPSHOT, last=True))
    assert "Ctrl-C" not in rendered(display)


def test_a_plain_display_writes_whole_lines_without_escapes():
    console = Console(file=io.StringIO(), width=40, force_terminal=False)
    with run_display(console, "title", StopRequest()) as display:
        assert isinstance(display, PlainDisplay)
        display.show(SNAPSHOT)
        display.show(replace(SNAPSHOT, hypervolume=None, left=None, best={}))
    assert console.file.getvalue().splitlines() == [
        "title",
        " 20%  12,000 of 60,000 evaluations  front 1,234  best t_end [s] 1040.25  "
        "best trace 2.3e-06  hypervolume 0.8123  elapsed 1:05  left 1:01:40",
        " 20%  12,000 of 60,000 evaluations  front 1,234  elapsed 1:05  left -",
    ]


def test_a_terminal_gets_the_live_display():
    console = Console(file=io.StringIO(), force_terminal=True, width=80)
    with run_display(console, "title", StopRequest()) as display:
        assert isinstance(display, LiveDisplay)
    assert "\x1b[?25h" in console.file.getvalue()  # the cursor is shown again


@pytest.mark.parametrize(
    ("seconds", "text"), [(0, "0:00"), (59.6, "1:00"), (61, "1:01"), (3725, "1:02:05")]
)
def test_clock(seconds, text):
    assert clock(seconds) == text
