"""Progress display of a run."""

import io
import time

from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems.multi import ZDT1
from rich.console import Console

from mgeo.cli.errors import StopRequest
from mgeo.cli.execution import Progress
from tests.mgeo.solved import solve


def test_progress_in_a_pipe_is_lines_without_escapes():
    console = Console(file=io.StringIO(), width=100, force_terminal=False)
    progress = Progress(console, "title [s]", StopRequest())
    progress.interval = 0.0
    with progress.display():
        outcome = solve(ZDT1(), NSGA2(pop_size=20), 60, 1, progress)
    title, first, *_, last = console.file.getvalue().splitlines()
    assert title == "title [s]"
    assert "20 of 60 evaluations" in first
    assert "60 of 60 evaluations" in last
    assert f"{len(outcome.F)} on the front" in last
    assert max(map(len, (first, last))) <= 80


def test_short_run_in_a_pipe_is_two_lines():
    console = Console(file=io.StringIO(), width=100, force_terminal=False)
    progress = Progress(console, "title", StopRequest())
    with progress.display():
        solve(ZDT1(), NSGA2(pop_size=20), 60, 1, progress)
    first, last = console.file.getvalue().splitlines()
    assert first == "title"
    assert "60 of 60 evaluations" in last


def test_last_line_in_a_pipe_is_not_repeated():
    """The last generation is displayed in time, and again when the run ends."""
    console = Console(file=io.StringIO(), width=100, force_terminal=False)
    progress = Progress(console, "title", StopRequest())
    progress.interval = 0.0

    def display_late(state):
        time.sleep(0.05)  # The display is updated if it has used a small share of the time.
        progress(state)

    with progress.display():
        solve(ZDT1(), NSGA2(pop_size=20), 60, 1, display_late)
    _, *lines = console.file.getvalue().splitlines()
    assert sum("60 of 60 evaluations" in line for line in lines) == 1
