"""Progress display of a run."""

import io

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
