"""Runs a study and writes what it found, or tells how large it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import joblib
import pandas as pd
from plotly.offline import get_plotlyjs

from mgeo.figures.page import LIBRARY
from mgeo.plugins.problems import is_own_class
from mgeo.store.atomic import check_writable, lock, to_json, write_files
from mgeo.store.run_folder import REPORT_FILE
from mgeo.studies.comparison import Comparison, markdown, problems_table
from mgeo.studies.conclusions import published_table
from mgeo.studies.execute import compare, run_files
from mgeo.studies.file import ProblemConfiguration, Study
from mgeo.studies.fingerprint.modules import distinct
from mgeo.studies.indicators import NothingToCompareError, check_space
from mgeo.studies.labels import folder_name
from mgeo.studies.pooled import friedman_over_problems, problem_values, ranks_over_problems
from mgeo.studies.report import problem_page, study_page
from mgeo.studies.results import failures, targets_reached
from mgeo.studies.run import Task
from mgeo.studies.stored import PATIENCE, PROVENANCE, check, claim, stored_tables

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

RECORDS = "runs"  # folder of the finished runs
VALUES = "values.csv"
RANKS = "ranks.csv"
TARGETS = "targets.csv"


def run_study(
    study: Study,
    folder: Path | str,
    *,
    n_jobs: int | None = None,
    progress: bool | None = None,
    coco_data: Path | str | None = None,
) -> dict[str, Comparison]:
    """Make the runs that are missing, and write tables and figures.

    Everything goes into `folder`, or with several problems into a folder each below it, once a
    problem is done: ``table.csv`` (indicators over evaluations), ``final.csv`` (after all of
    them), ``fronts.csv``, ``runs.csv``, ``tests.csv``, ``summary.md``, ``summary.tex``,
    ``report.html`` and last ``provenance.json``. With several problems there are beside these
    folders ``report.html``, ``summary.md``, ``summary.tex``, ``summary.csv``, ``values.csv`` and
    ``ranks.csv`` (see `mgeo.studies.pooled`), ``targets.csv`` (`mgeo.studies.results`) and the
    plotting library, which all pages share. A study that was interrupted goes on with the runs that
    are missing. With its first tables the folder belongs to this study, which may grow: see
    `mgeo.studies.stored.claim`.

    Parameters
    ----------
    n_jobs, progress, coco_data : as of `mgeo.compare`.

    Returns
    -------
    A comparison per problem, by its label.

    Raises
    ------
    ValueError, TypeError
        If a problem or an algorithm cannot be built, the folder belongs to another study, or there
        are to be data for COCO of a problem that is not COCO's.
    OSError
        If a folder cannot be written; that is tried before any run is made.
    NothingToCompareError
        If all runs of a problem failed, or none found a feasible solution; the others are done.

    Examples
    --------
    >>> from pathlib import Path
    >>> from mgeo.studies import read_study, run_study
    >>> text = '''
    ... title = "Two algorithms"
    ... evaluations = 200
    ... grid = 2
    ... seeds = [1, 2]
    ... problems = [{name = "pymoo:zdt1"}]
    ... algorithms = [{name = "mgeo-directed"}, {name = "nsga2"}]
    ... '''
    >>> _ = Path("study.toml").write_text(text)
    >>> found = run_study(read_study("study.toml"), "results", n_jobs=1, progress=False)
    >>> list(found), Path("results/summary.md").exists()
    (['zdt1'], True)
    """
    folder = Path(folder)
    built = build(study)
    check(folder, study)
    check_writable(folder)
    if coco_data is not None:
        from mgeo.benchmarks.coco import run_folder

        for problem, _ in built:
            run_folder(Path(coco_data), problem, 0)
        check_writable(Path(coco_data))
    comparisons: dict[str, Comparison] = {}
    without: list[str] = []
    failed: list[str] = []
    for configuration, (problem, algorithms) in zip(study.problems, built, strict=True):
        label = configuration.label
        evaluations, grid = study.budget(problem)
        try:
            comparison = compare(
                problem,
                algorithms,
                evaluations,
                study.seeds,
                folder=folder / RECORDS,
                grid=grid,
                n_jobs=n_jobs,
                progress=progress,
                title=label,
                coco_data=coco_data,
                parts=configuration.parts,
            )
        except NothingToCompareError as error:
            without.append(f"{label}: {error}")
            continue
        contents = _contents(study, configuration, comparison)
        if not comparisons:
            claim(folder, study)
        place = folder if len(study.problems) == 1 else folder / folder_name(label)
        place.mkdir(parents=True, exist_ok=True)
        with lock(folder, PATIENCE):  # or tables of two processes would be mixed
            if len(study.problems) > 1 and not comparisons:
                write_files(folder, {LIBRARY: get_plotlyjs().encode()})
            write_files(place, contents)
        comparisons[label] = comparison
        failed += failures(comparison.failures(), label)
    if len(study.problems) > 1 and comparisons:
        texts = _over_problems(study, comparisons, failed + without)
        with lock(folder, PATIENCE):
            write_files(folder, {name: text.encode() for name, text in texts.items()})
    if without:
        raise NothingToCompareError("; ".join(without))
    return comparisons


def build(study: Study) -> list[tuple[Problem, dict[str, Algorithm]]]:
    """Each problem, and the algorithms for it by their labels.

    All of them, before any is used: what cannot be built should not be found after hours.

    Raises
    ------
    ValueError, TypeError
        If one cannot be built.
    """
    problems = [configuration.build() for configuration in study.problems]
    for configuration, problem in zip(study.problems, problems, strict=True):
        try:
            check_space(problem, parts=configuration.parts)
        except ValueError as error:
            raise ValueError(f"{configuration.label}: {error}") from error
    return [(p, {each.label: each.build(p) for each in study.algorithms}) for p in problems]


def _over_problems(
    study: Study, comparisons: Mapping[str, Comparison], failed: list[str]
) -> dict[str, str]:
    """Files about all problems together."""
    values = problem_values(comparisons, study.per_variable)
    standings = ranks_over_problems(values, study.control)
    reached = targets_reached(comparisons)
    ranked = friedman_over_problems(values)
    marked = problems_table(comparisons)
    return {
        "summary.md": marked.markdown() + "".join(f"\n{text}\n" for text in failed),
        "summary.tex": marked.latex(),
        "summary.csv": marked.table.to_csv(lineterminator="\n"),
        VALUES: values.to_csv(index=False, lineterminator="\n"),
        RANKS: standings.to_csv(index=False, lineterminator="\n"),
        TARGETS: reached.to_csv(index=False, lineterminator="\n"),
        REPORT_FILE: study_page(study, comparisons, ranked, standings, reached, failed),
    }


def _contents(
    study: Study, problem: ProblemConfiguration, comparison: Comparison
) -> dict[str, bytes]:
    indicators = [each.name for each in [*comparison.indicators, *comparison.parts]]
    tests = pd.concat(
        [comparison.tests(name).pairs for name in indicators], keys=indicators, names=["indicator"]
    )
    texts = {
        "tests.csv": tests.reset_index(0).to_csv(index=False, lineterminator="\n"),
        "summary.md": _summary(study, comparison),
        "summary.tex": comparison.to_latex(),
        REPORT_FILE: problem_page(study, problem.label, comparison),
    }
    last = {PROVENANCE: to_json(_provenance(study, problem, comparison))}
    encoded = {name: text.encode() for name, text in texts.items()}
    return stored_tables(comparison) | encoded | last


def _summary(study: Study, comparison: Comparison) -> str:
    text = comparison.to_markdown()
    published = published_table(study, comparison)
    if published is None or study.published is None:
        return text
    return f"{text}\nBeside {study.published.source}:\n\n{markdown(published)}"


def _provenance(
    study: Study, problem: ProblemConfiguration, comparison: Comparison
) -> dict[str, Any]:
    statuses, compared = comparison.runs["status"], study.configuration()
    return {
        "title": study.title,
        "problem": {"label": problem.label, **compared["problems"][problem.label]},
        "algorithms": compared["algorithms"],
        "evaluations": comparison.n_eval,
        "seeds": list(study.seeds),
        "space": comparison.space.describe(),
        "runs_finished": int((statuses == "finished").sum()),
        "runs_failed": int((statuses == "failed").sum()),
        "hours_of_runs": round(float(comparison.runs["wall_time"].sum()) / 3600.0, 3),
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": distinct(record.versions for record in comparison.records.values()),
    }


@dataclass(frozen=True)
class StudyEstimate:
    """What would be run.

    Attributes
    ----------
    runs, found : number of runs, and of those that are in the folder already.
    processes : number of processes that run at the same time.
    """

    problems: Mapping[str, Problem]
    runs: int
    found: int
    processes: int


def estimate_study(study: Study, folder: Path | str, *, n_jobs: int | None = None) -> StudyEstimate:
    """Look at a study that is to be run by `run_study`; nothing is written.

    No module is imported that the study names as ``module:Class``.

    Raises
    ------
    ValueError, TypeError
        If a problem or an algorithm cannot be built, or the folder belongs to another study.
    """
    own = [a.label for a in study.algorithms if ":" in a.name]
    own += [p.label for p in study.problems if is_own_class(p.name)]
    named = replace(
        study,
        algorithms=tuple(a for a in study.algorithms if a.label not in own),
        problems=tuple(p for p in study.problems if p.label not in own),
    )
    built = build(named)
    check(Path(folder), study)
    found = 0
    for problem, algorithms in built:
        n_eval, _ = study.budget(problem)
        tasks = {
            (label, seed): Task(problem, algorithm, n_eval, seed)
            for (label, algorithm), seed in product(algorithms.items(), study.seeds)
        }
        files = run_files(Path(folder) / RECORDS, tasks)
        found += sum(path.is_file() for path in files.values())
    runs = len(study.problems) * len(study.algorithms) * len(study.seeds)
    processes = max(1, min(joblib.effective_n_jobs(n_jobs), runs - found))
    problems = {p.label: made for p, (made, _) in zip(named.problems, built, strict=True)}
    return StudyEstimate(problems, runs, found, processes)
