"""How large a study is, and how long it will take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import joblib

from mgeo.runs.estimate import estimate
from mgeo.studies.claim import check
from mgeo.studies.file import Study
from mgeo.studies.folder import run_files
from mgeo.studies.run import Task
from mgeo.studies.study import RECORDS, build

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


@dataclass(frozen=True)
class StudyEstimate:
    """What would be run.

    ``found`` of the ``runs`` are in the folder already; for the others it would take about
    ``seconds``, ``processes`` at once, judged by ``timed`` evaluations made for that purpose.
    """

    problems: Mapping[str, Problem]
    runs: int
    found: int
    processes: int
    seconds: float
    timed: int


def estimate_study(
    study: Study, folder: Path | str, *, n_jobs: int | None = None, seconds: float = 5.0
) -> StudyEstimate:
    """Look at a study that is to be run by `run_study`; nothing is written.

    Each algorithm is tried on each problem, for about `seconds` in all. A run is expected to keep
    one process busy for as long as all processors together work for it here.

    Raises
    ------
    ValueError, TypeError
        If a problem or an algorithm cannot be built, or the folder belongs to another study.
    """
    built = build(study)
    check(Path(folder), study)
    share = seconds / (len(built) * len(study.algorithms))
    found, timed, work = 0, 0, 0.0
    for problem, algorithms in built:
        n_eval, _ = study.budget(problem)
        for label, algorithm in algorithms.items():
            tasks = {(label, s): Task(problem, algorithm, n_eval, s) for s in study.seeds}
            files = run_files(Path(folder) / RECORDS, tasks).values()
            there = sum(path.is_file() for path in files)
            found += there
            if there < len(tasks):
                expected = estimate(problem, algorithm, n_eval, study.seeds[0], share)
                work += (len(tasks) - there) * max(expected.elapsed, expected.processor)
                timed += expected.timed
    runs = len(built) * len(study.algorithms) * len(study.seeds)
    processes = max(1, min(joblib.effective_n_jobs(n_jobs), runs - found))
    problems = {p.label: made for p, (made, _) in zip(study.problems, built, strict=True)}
    return StudyEstimate(problems, runs, found, processes, work / processes, timed)
