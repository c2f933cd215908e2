import io
import re

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems.multi import ZDT1
from rich.console import Console

from mgeo.cli.errors import StopRequest
from mgeo.cli.progress import Progress, clock
from mgeo.store.run import Hypervolume
from tests.mgeo.solved import solve

#: Hypervolumes that compare with those of other runs, and that do not.
COMPARABLE, OWN = (Hypervolume(value=0.81234, space=space) for space in ("problem", "seen"))


class Run:
    """A run under way, as its callback sees it: a fifth is done, after a first generation."""

    budget, objectives, failures = 60_000, ("t_end [s]", "trace"), {}
    refinement = None

    def __init__(self, volume=COMPARABLE, n=1234):
        self.volume, self.n = volume, n
        self.evaluations, self.elapsed, self.stopped = 3_000, 5.0, False

    def front(self):
        return np.ones((self.n, 12)), np.tile([1040.25, 2.3e-6], (self.n, 1))

    def hypervolume(self, F):
        return self.volume

    @property
    def ended(self):
        return self.stopped or self.evaluations >= self.budget

    def stop(self):
        self.stopped = True

    def after(self, evaluations, elapsed):
        self.evaluations, self.elapsed = evaluations, elapsed
        return self


def a_fifth_of(run, progress):
    """Shows a run after its first generation, and when a fifth of it is done."""
    progress(run)
    look(progress, run.after(12_000, 65.0))


def look(progress, run):
    """Takes a look now, whatever the one before has cost."""
    progress._next = 0.0
    progress(run)


def lines_of(progress, evaluations=400, before=lambda state: None):
    """What is shown, by column and line, of a run that makes 20 evaluations a generation."""

    def callback(state):
        before(state)
        progress(state)

    outcome = solve(ZDT1(), NSGA2(pop_size=20), evaluations, 1, callback)
    lines = progress._console.file.getvalue().splitlines()
    return outcome, [re.split("  +", line.strip()) for line in lines]


def plain(request=None):
    console = Console(file=io.StringIO(), width=40, force_terminal=False)
    return Progress(console, "title", StopRequest() if request is None else request)


def live(title="title", request=None):
    console = Console(file=io.StringIO(), width=100, force_terminal=True)
    return Progress(console, title, StopRequest() if request is None else request)


def rendered(progress):
    console = Console(file=io.StringIO(), width=100, force_terminal=False)
    console.print(progress)
    return console.file.getvalue()


def test_what_the_run_has_is_shown():
    progress = plain()
    progress.interval = 0.0
    outcome, lines = lines_of(progress, 60)
    f1, f2 = outcome.F.min(axis=0)
    assert lines[-1] == [
        "100%",
        "60 of 60 evaluations",
        f"front {len(outcome.F)}",
        f"best f1 {f1:.6g}",
        f"best f2 {f2:.6g}",
        f"hypervolume (of the range seen) {outcome.hypervolume.value:.4f}",
        lines[-1][-2],
        "left 0:00",
    ]
    assert lines[0][-1] == "left -"  # one generation says nothing about the others


def test_it_looks_no_more_often_than_it_should_but_always_at_the_end():
    progress = plain()
    progress.interval = 60.0
    _, lines = lines_of(progress)
    assert [line[1].split()[0] for line in lines] == ["20", "400"]


def test_a_costly_look_is_taken_less_often(monkeypatch):
    now, shown = [0.0], []
    for clock_of in ("monotonic", "process_time"):
        monkeypatch.setattr(f"mgeo.cli.progress.time.{clock_of}", lambda: now[0])
    progress = plain()
    progress.interval = 0.25
    progress._console.print = lambda *_, **__: (
        shown.append(now[0]),
        now.__setitem__(0, now[0] + 1),
    )

    def callback(state):
        progress(state)
        now[0] += 10.0

    solve(ZDT1(), NSGA2(pop_size=20), 400, 1, callback)
    # a look takes 1 s of this clock: the next one comes 50 s later at the earliest
    assert np.diff(shown[:-1]).min() >= 50


def test_a_request_to_stop_reaches_the_run():
    request = StopRequest()
    progress = plain(request=request)
    progress.interval = 60.0

    def interrupt(state):
        if state.evaluations == 60:
            request.signal = 2

    outcome, lines = lines_of(progress, before=interrupt)
    assert (outcome.status, outcome.evaluations) == ("interrupted", 60)
    assert lines[-1][1] == "60 of 400 evaluations"


def test_a_terminal_shows_everything_with_units():
    progress = live("a title [s]")
    assert "first generation" in rendered(progress)
    a_fifth_of(Run(), progress)
    text = rendered(progress)
    for part in (
        "a title [s]",
        "12,000 of 60,000 evaluations",
        "1,234",
        "best t_end [s]  1040.25",
        "best trace",
        "2.3e-06",
        "0.8123",
        "1:05",
        "5:20",
    ):
        assert part in text, part
    assert "range seen" not in text
    assert "Ctrl-C" not in text


def test_a_terminal_shows_what_a_hypervolume_means_and_that_it_is_stopping():
    request = StopRequest()
    progress = live(request=request)
    run = Run(OWN)
    a_fifth_of(run, progress)
    request.signal = 2
    text = rendered(progress)
    assert "hypervolume (of the range seen)" in text
    assert "Ctrl-C again to stop at once" in text
    progress(run)  # which ends there
    assert "Ctrl-C" not in rendered(progress)


def test_elsewhere_there_are_whole_lines_without_escapes():
    progress = plain()
    with progress.shown():
        a_fifth_of(Run(), progress)
        look(progress, Run(None, n=0).after(12_000, 65.0))
    assert progress._console.file.getvalue().splitlines() == [
        "title",
        "  5%  3,000 of 60,000 evaluations  front 1,234  best t_end [s] 1040.25  "
        "best trace 2.3e-06  hypervolume 0.8123  elapsed 0:05  left -",
        " 20%  12,000 of 60,000 evaluations  front 1,234  best t_end [s] 1040.25  "
        "best trace 2.3e-06  hypervolume 0.8123  elapsed 1:05  left 5:20",
        " 20%  12,000 of 60,000 evaluations  front 0  elapsed 1:05  left 5:20",
    ]


def test_a_terminal_is_redrawn():
    progress = live()
    with progress.shown():
        pass
    assert "\x1b[?25h" in progress._console.file.getvalue()  # the cursor is shown again


@pytest.mark.parametrize(
    ("seconds", "text"), [(0, "0:00"), (59.6, "1:00"), (61, "1:01"), (3725, "1:02:05")]
)
def test_clock(seconds, text):
    assert clock(seconds) == text
