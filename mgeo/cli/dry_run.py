"""``--dry-run``: how large a run or a study is, what it would write, how long it would take."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.table import Table

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.cli.consoles import plain
from mgeo.cli.displays import clock
from mgeo.cli.output import Output
from mgeo.cli.running import can_draw, run_title
from mgeo.plugins.protocol import problem_size
from mgeo.runs.estimate import estimate
from mgeo.runs.folder import FIGURE_FILE, FRONT_FILE, RUN_FILE
from mgeo.runs.persistence import CHECKPOINT_FILE, RECORD_FOLDER, RunPersistence
from mgeo.runs.prepare import PreparedRun
from mgeo.studies.outline import Outline


def describe_run(run: PreparedRun, persistence: RunPersistence, output: Output) -> None:
    """Tell it about a run of ``mgeo solve``; the problem is evaluated for about a second."""
    configuration = run.configuration
    expected = estimate(run.problem, run.algorithm, configuration.evaluations, configuration.seed)
    size = problem_size(run.problem)
    files = [FRONT_FILE, RUN_FILE]
    files += [FIGURE_FILE] if can_draw(run.problem) else []
    files += [CHECKPOINT_FILE] if isinstance(run.algorithm, ExtremalOptimization) else []
    files += [f"{RECORD_FOLDER}/"] if persistence.record else []
    output.print(
        run_title(configuration),
        _table(
            {
                "size": _size(size),
                "budget": f"{configuration.evaluations:,} evaluations",
                "folder": str(persistence.folder),
                "files": ", ".join(files),
                "time": _time(expected.elapsed, expected.timed),
            }
        ),
    )
    output.result(
        {
            "dry_run": True,
            "configuration": configuration.model_dump(),
            **size,
            "folder": str(persistence.folder),
            "files": files,
            "expected_time_s": expected.elapsed,
            "timed_evaluations": expected.timed,
        }
    )


def describe_study(outline: Outline, folder: Path, output: Output) -> None:
    """Tell it about a study."""
    sizes = {label: problem_size(problem) for label, problem in outline.problems.items()}
    missing = outline.runs - outline.found
    output.print(
        outline.title,
        _table(
            {label: _size(size) for label, size in sizes.items()}
            | {
                "algorithms": ", ".join(outline.algorithms),
                "budget": f"{outline.runs:,} runs of {outline.evaluations:,} evaluations; "
                f"{outline.found:,} of them found, {missing:,} to make",
                "folder": str(folder),
                "time": f"{_time(outline.seconds, outline.timed)}, {outline.processes} at once",
            }
        ),
    )
    output.result(
        {
            "dry_run": True,
            "title": outline.title,
            "problems": sizes,
            "algorithms": list(outline.algorithms),
            "evaluations": outline.evaluations,
            "runs": outline.runs,
            "runs_found": outline.found,
            "processes": outline.processes,
            "folder": str(folder),
            "expected_time_s": outline.seconds,
            "timed_evaluations": outline.timed,
        }
    )


def _size(size: Mapping[str, Any]) -> str:
    objectives = size["objectives"]
    return (
        f"{_count(len(size['variables']), 'variable')}, {_count(len(objectives), 'objective')} "
        f"({', '.join(objectives)}), {_count(size['constraints'], 'constraint')}"
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _time(seconds: float, timed: int) -> str:
    about = f"{seconds:.2g} s" if seconds < 10 else clock(seconds)
    return f"about {about}, an estimate from {timed:,} evaluations"


def _table(rows: Mapping[str, str]) -> Table:
    table = Table.grid(padding=(0, 2))
    for name, text in rows.items():
        table.add_row(plain(name, style="dim"), plain(text))
    return table
