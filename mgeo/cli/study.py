"""``mgeo study``: run a study file, or go on with it."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import joblib
import typer
from rich.text import Text

from mgeo.cli.consoles import console
from mgeo.cli.errors import one_line_errors
from mgeo.studies.comparison import Comparison
from mgeo.studies.file import Study, read_study
from mgeo.studies.study import REPORT, run_study
from mgeo.studies.verdict import verdict

FAILED = 1
INTERRUPTED = 130  # as a shell reports Ctrl-C


@dataclass(frozen=True)
class Request:
    """What was asked for on the command line."""

    file: Path
    out: Path | None
    evaluations: int | None
    seeds: int | None
    jobs: int
    cluster: str | None
    quiet: bool
    debug: bool


def run(request: Request) -> int:
    """Do it; the exit code: 1 if runs failed, 130 if it was interrupted."""
    with one_line_errors(request.debug):
        study = read_study(request.file).reduced(request.evaluations, request.seeds)
        out = request.out or Path("studies", request.file.stem)
        try:
            with ExitStack() as stack:
                n_jobs = _where(request, stack)
                comparisons = run_study(study, out, n_jobs=n_jobs, progress=not request.quiet)
        except KeyboardInterrupt:
            typer.echo(f"interrupted; the same command goes on with what is in {out}", err=True)
            return INTERRUPTED
    if not request.quiet:
        _print_results(study, comparisons, out)
    failed = sum(int((c.runs["status"] == "failed").sum()) for c in comparisons.values())
    if failed:
        typer.echo(f"{failed} runs failed; the same command makes them again", err=True)
    return FAILED if failed else 0


def _where(request: Request, stack: ExitStack) -> int | None:
    """Number of processes, or None on a cluster, which is then joblib's backend."""
    if request.cluster is None:
        return request.jobs
    try:
        from distributed import Client
    except ImportError as error:
        raise ValueError("--cluster needs the extra: pip install 'mgeo[distributed]'") from error
    stack.enter_context(Client(request.cluster))
    stack.enter_context(joblib.parallel_config("dask"))
    return None


def _print_results(study: Study, comparisons: dict[str, Comparison], out: Path) -> None:
    shown = console()
    for label, comparison in comparisons.items():
        shown.print(Text(f"\n{label}", style="bold"))
        titles = {indicator.name: indicator.title for indicator in comparison.indicators}
        table = comparison.overview().rename(columns=titles)
        shown.print(Text(table.to_string()), soft_wrap=True)
        for sentence in verdict(comparison):
            shown.print(Text(sentence), soft_wrap=True)
    shown.print(Text(f"\nwritten: {out / REPORT}"), soft_wrap=True)
    sys.stdout.flush()
