import io
import re

from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems.multi import ZDT1
from rich.console import Console

from mgeo.cli.errors import StopRequest
from mgeo.cli.running import Progress
from tests.mgeo.solved import solve


def shown(progress, evaluations=400, before=lambda state: None):
    """The outcome of a run of 20 evaluations a generation, and the text that is shown."""

    def callback(state):
        before(state)
        progress(state)

    with progress.shown():
        outcome = solve(ZDT1(), NSGA2(pop_size=20), evaluations, 1, callback)
    return outcome, progress._console.file.getvalue()


def progress_on(terminal, request=None):
    console = Console(file=io.StringIO(), width=100, force_terminal=terminal)
    return Progress(console, "title [s]", StopRequest() if request is None else request)


def test_elsewhere_there_are_whole_lines_without_escapes():
    progress = progress_on(False)
    progress.interval = 0.0
    outcome, text = shown(progress, 60)
    title, first, *_, last = text.splitlines()
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


def test_a_request_to_stop_reaches_the_run():
    request = StopRequest()

    def interrupt(state):
        if state.evaluations == 60:
            request.signal = 2

    outcome, text = shown(progress_on(False, request), before=interrupt)
    assert (outcome.stop_reason, outcome.evaluations) == ("signal", 60)
    assert "60 of 400 evaluations" in text.splitlines()[-1]
