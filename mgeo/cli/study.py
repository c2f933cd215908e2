"""``mgeo study``: run a study file, or go on with it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import joblib

from mgeo.cli.errors import ExitCode
from mgeo.cli.output import Output
from mgeo.studies.comparison import Comparison
from mgeo.studies.conclusions import conclusions, published_table
from mgeo.studies.file import Study
from mgeo.studies.results import FailedRunsWarning, NotReusedWarning
from mgeo.studies.study import REPORT
from mgeo.terminal import plain, table


def show(study: Study, comparisons: dict[str, Comparison], folder: Path, output: Output) -> int:
    """Show what was found; the exit code tells if runs failed."""
    for label, comparison in comparisons.items():
        shown, said = comparison.overview(), conclusions(comparison, study.control)
        columns = table(["", *shown.columns], shown.itertuples(name=None))
        output.print(plain(f"\n{label}", style="bold"), columns, *said)
        published = published_table(study, comparison)
        if published is not None and study.published is not None:
            beside = table(["", *published.columns], published.itertuples(name=None))
            output.print(f"beside {study.published.source}:", beside)
    output.print(f"\nwritten: {folder / REPORT}")
    output.result(
        {
            "title": study.title,
            "folder": str(folder),
            "report": str(folder / REPORT),
            "evaluations": study.evaluations,
            "per_variable": study.per_variable,
            "seeds": list(study.seeds),
            "problems": {
                label: _document(each, study.control) for label, each in comparisons.items()
            },
        }
    )
    failed = sum(_count(comparison, "failed") for comparison in comparisons.values())
    if failed:
        output.note(f"{failed} runs failed; the same command makes them again")
    return ExitCode.INCOMPLETE if failed else ExitCode.DONE


@contextmanager
def notes(output: Output) -> Iterator[None]:
    """Show what is said of runs that failed, are not kept or not used as notes, each once."""
    with warnings.catch_warnings():
        shown, told = warnings.showwarning, set[str]()

        def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
            if not issubclass(category, NotReusedWarning | FailedRunsWarning):
                shown(message, category, *where, **more)
            elif str(message) not in told:
                told.add(str(message))
                output.note(f"Note: {message}")

        warnings.showwarning = show
        yield


@contextmanager
def workers(jobs: int, cluster: str | None) -> Iterator[int | None]:
    """Number of processes, or None on a cluster, which is then joblib's backend."""
    if cluster is None:
        yield jobs
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise ValueError("--cluster needs the extra: pip install 'mgeo[distributed]'") from error
    with Client(cluster), joblib.parallel_config("dask"):
        yield None


def _document(comparison: Comparison, control: str | None) -> dict[str, Any]:
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
        "conclusions": conclusions(comparison, control),
    }


def _count(comparison: Comparison, status: str) -> int:
    return int((comparison.runs["status"] == status).sum())
