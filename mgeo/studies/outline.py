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
from mgeo.studies.folder import RunFolder
from mgeo.studies.run import Task
from mgeo.studies.study import RECORDS, build

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


@dataclass(frozen=True)
class Outline:
    """What would be run.

    ``found`` of the ``runs`` are in the folder already; for the others it would take about
    ``seconds``, ``processes`` at once, judged by ``timed`` evaluations made for that purpose.
    """

    title: str
    problems: Mapping[str, Problem]
    algorithms: tuple[str, ...]
    evaluations: int
    runs: int
    found: int
    processes: int
    seconds: float
    timed: int


def outline(
    study: Study, folder: Path | str, *, n_jobs: int | None = None, seconds: float = 5.0
) -> Outline:
    """Look at a study that is to be run by `run_study`; nothing is written.

    Each algorithm is tried on each problem, for about `seconds` in all. A run is expected to keep
    one process busy for as long as all processors together work for it here.

    Raises
    ------
    ValueError, TypeError
        If a problem or an algorithm cannot be built, or the folder belongs to another study.
    """
    problems, algorithms = build(study)
    check(Path(folder), study)
    store = RunFolder(Path(folder) / RECORDS)
    share = seconds / sum(map(len, algorithms))
    runs = found = timed = 0
    work = 0.0
    for problem, contenders in zip(problems, algorithms, strict=True):
        for label, algorithm in contenders.items():
            tasks = {
                (label, seed): Task(problem, algorithm, study.evaluations, seed)
                for seed in study.seeds
            }
            there = sum(path.is_file() for path in store.paths(tasks).values())
            runs, found = runs + len(tasks), found + there
            if there < len(tasks):
                expected = estimate(problem, algorithm, study.evaluations, study.seeds[0], share)
                work += (len(tasks) - there) * max(expected.elapsed, expected.processor)
                timed += expected.timed
    processes = max(1, min(joblib.effective_n_jobs(n_jobs), runs - found))
    labels = [case.label for case in study.cases]
    return Outline(
        title=study.title,
        problems=dict(zip(labels, problems, strict=True)),
        algorithms=tuple(contender.label for contender in study.contenders),
        evaluations=study.evaluations,
        runs=runs,
        found=found,
        processes=processes,
        seconds=work / processes,
        timed=timed,
    )
