"""``mgeo study``: run a study file, or go on with it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib

from mgeo.cli.dry_run import describe_study
from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.output import Output
from mgeo.studies.comparison import Comparison
from mgeo.studies.file import Study, read_study
from mgeo.studies.folder import NotReusedWarning
from mgeo.studies.outline import outline
from mgeo.studies.study import REPORT, run_study
from mgeo.studies.verdict import verdict
from mgeo.terminal import plain


@dataclass(frozen=True)
class Request:
    """What was asked for on the command line."""

    file: Path
    out: Path | None
    evaluations: int | None
    seeds: int | None
    jobs: int
    cluster: str | None
    dry_run: bool


def run(request: Request, output: Output) -> int:
    """Do it; the exit code tells if runs failed, or it was interrupted."""
    with bad_input(), ExitStack() as stack:
        stack.enter_context(_notes(output))
        study = read_study(request.file).reduced(request.evaluations, request.seeds)
        out = request.out or Path("studies", request.file.stem)
        n_jobs = _where(request, stack)
        if request.dry_run:
            describe_study(outline(study, out, n_jobs=n_jobs), out, output)
            return ExitCode.DONE
        try:
            comparisons = run_study(study, out, n_jobs=n_jobs, progress=not output.quiet)
        except KeyboardInterrupt:
            output.note(f"interrupted; the same command goes on with what is in {out}")
            return ExitCode.INTERRUPTED
    _print_results(study, comparisons, out, output)
    failed = sum(_count(comparison, "failed") for comparison in comparisons.values())
    if failed:
        output.note(f"{failed} runs failed; the same command makes them again")
    return ExitCode.INCOMPLETE if failed else ExitCode.DONE


@contextmanager
def _notes(output: Output) -> Iterator[None]:
    """Show what is said of runs that are not kept or not used as notes, each of them once."""
    with warnings.catch_warnings():
        shown = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
            if issubclass(category, NotReusedWarning):
                output.note(f"Note: {message}")
            else:
                shown(message, category, *where, **more)

        warnings.showwarning = show
        yield


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


def _print_results(
    study: Study, comparisons: dict[str, Comparison], out: Path, output: Output
) -> None:
    for label, comparison in comparisons.items():
        table = comparison.overview()
        output.print(plain(f"\n{label}", style="bold"), table.to_string(), *verdict(comparison))
    output.print(f"\nwritten: {out / REPORT}")
    output.result(
        {
            "title": study.title,
            "folder": str(out),
            "report": str(out / REPORT),
            "evaluations": study.evaluations,
            "seeds": list(study.seeds),
            "problems": {label: _document(each) for label, each in comparisons.items()},
        }
    )


def _document(comparison: Comparison) -> dict[str, Any]:
    summary = comparison.summary()
    names = [name for name in dict.fromkeys(summary.columns.get_level_values(0)) if name != "runs"]
    return {
        "runs_finished": _count(comparison, "finished"),
        "runs_failed": _count(comparison, "failed"),
        "best_first": comparison.order(),
        "algorithms": {
            label: {
                name: {key: float(value) for key, value in summary.loc[label, name].items()}
                for name in names
            }
            for label in comparison.algorithms
        },
        "verdict": verdict(comparison),
    }


def _count(comparison: Comparison, status: str) -> int:
    return int((comparison.runs["status"] == status).sum())
