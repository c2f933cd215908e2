"""Progress display of a run."""

import io
import re

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
    f1, f2 = outcome.F.min(axis=0)
    assert title == "title [s]"
    assert re.fullmatch(
        r" 33%  20 of 60 evaluations  front \d+  .*  elapsed 0:00:0\d  left -", first
    )
    assert re.fullmatch(
        rf"100%  60 of 60 evaluations  front {len(outcome.F)}  best f1 {f1:.6g}  best f2 {f2:.6g}"
        r"  elapsed 0:00:0\d  left 0:00:00",
        last,
    )
