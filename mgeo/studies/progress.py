"""Progress display of the runs of a comparison, on stderr."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: Function called when a run ends, with algorithm, seed and error message (empty on success).
ProgressCallback = Callable[[str, int, str], None]


@contextmanager
def show_progress(
    title: str, n_runs: int, n_reused: int | None, *, enabled: bool
) -> Iterator[ProgressCallback]:
    """Context manager that reports the progress of a comparison on stderr.

    The display shows the number of reused runs, each failed run and, on a terminal, a progress bar.
    Without rich, which comes with ``mgeo[cli]``, only the number of reused runs is shown.

    Parameters
    ----------
    title : str
        Name of the problem.
    n_runs : int
        Number of runs.
    n_reused : int or None
        Number of runs read from the folder; None for a new study.
    enabled : bool
        Whether to show the progress.

    Yields
    ------
    function
        Call it when a run ends, with algorithm, seed and error message (empty on success).
    """
    if enabled and n_reused is not None:
        print(f"{title}: reused {n_reused} of {n_runs} runs", file=sys.stderr)
    try:
        from rich import markup, progress

        from mgeo.terminal import build_console
    except ImportError:
        enabled = False
    if not enabled:
        yield lambda name, seed, error: None
        return
    screen = build_console(stderr=True)
    columns = (*progress.Progress.get_default_columns(), progress.MofNCompleteColumn())
    with progress.Progress(*columns, console=screen, disable=not screen.is_terminal) as bar:
        task = bar.add_task(markup.escape(title), total=n_runs, completed=n_reused or 0)

        def report(name: str, seed: int, error: str) -> None:
            if error:
                bar.console.print(f"{title}: {name}, seed {seed}: {error}", markup=False)
            bar.advance(task)

        yield report
