"""How large a study is, and how long it will take."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import joblib

from mgeo.runs.estimate import estimate
from mgeo.studies.execute import run_files
from mgeo.studies.file import Study
from mgeo.studies.run import Task, told
from mgeo.studies.stored import check
from mgeo.studies.study import RECORDS, build

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


@dataclass(frozen=True)
class StudyEstimate:
    """What would be run.

    ``found`` of the ``runs`` are in the folder already; for the others it would take about
    ``seconds``, ``processes`` at once, judged by ``timed`` evaluations made for that purpose.
    ``untold`` says whose runs these seconds are without, and why.
    """

    problems: Mapping[str, Problem]
    runs: int
    found: int
    processes: int
    seconds: float
    timed: int
    untold: tuple[str, ...] = ()


def estimate_study(study: Study, folder: Path | str, *, n_jobs: int | None = None) -> StudyEstimate:
    """Look at a study that is to be run by `run_study`; nothing is written.

    Each algorithm is tried on each problem, by `mgeo.runs.estimate`. A run is expected to keep one
    process busy for as long as all processors together work for it here. What fails when it is
    tried, as its runs would, is told and left out. So is what the study names ``module:Class``: a
    look at a file has no module imported that it names.

    Raises
    ------
    ValueError, TypeError
        If a problem or an algorithm cannot be built, or the folder belongs to another study.
    """
    own = [each.label for each in study.algorithms if ":" in each.name]
    untold = [f"{label}: a dry run has no module imported that a file names" for label in own]
    named = tuple(each for each in study.algorithms if each.label not in own)
    built = build(replace(study, algorithms=named))
    check(Path(folder), study)
    found, timed, work = 0, 0, 0.0
    for configuration, (problem, algorithms) in zip(study.problems, built, strict=True):
        n_eval, _ = study.budget(problem)
        tasks = {
            (label, seed): Task(problem, algorithm, n_eval, seed)
            for (label, algorithm), seed in product(algorithms.items(), study.seeds)
        }
        files = run_files(Path(folder) / RECORDS, tasks)
        there = Counter(label for (label, _), path in files.items() if path.is_file())
        found += there.total()
        for label, algorithm in algorithms.items():
            if there[label] < len(study.seeds):
                try:
                    expected = estimate(problem, algorithm, n_eval, study.seeds[0])
                except Exception as error:  # foreign code: it may raise anything
                    untold.append(f"{label} on {configuration.label} fails: {told(error)}")
                    continue
                work += (len(study.seeds) - there[label]) * max(
                    expected.elapsed, expected.processor
                )
                timed += expected.timed
    runs = len(built) * len(study.algorithms) * len(study.seeds)
    processes = max(1, min(joblib.effective_n_jobs(n_jobs), runs - found))
    problems = {p.label: made for p, (made, _) in zip(study.problems, built, strict=True)}
    seconds = work / processes
    return StudyEstimate(problems, runs, found, processes, seconds, timed, tuple(untold))
