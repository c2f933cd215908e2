"""Execution of a study file: one comparison per problem, with tables and report pages."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from plotly.offline import get_plotlyjs

from mgeo.figures.page import LIBRARY
from mgeo.store.atomic import write_file, write_files
from mgeo.store.reading import to_csv
from mgeo.store.run_folder import REPORT_FILE
from mgeo.studies.arguments import grid_steps
from mgeo.studies.comparison import Comparison
from mgeo.studies.conclusions import published_table
from mgeo.studies.execute import RECORDS, Experiment
from mgeo.studies.file import Study
from mgeo.studies.indicators import NothingToCompareError, check_space
from mgeo.studies.plan import claim, installed_versions
from mgeo.studies.pooled import problem_values, ranks_over_problems, targets_reached
from mgeo.studies.report import problem_page, study_page
from mgeo.studies.stored import problem_folder, write_comparison
from mgeo.studies.tables import markdown, problems_table

TEXT = "study.toml"
VALUES = "values.csv"
RANKS = "ranks.csv"
TARGETS = "targets.csv"


def run_study(
    study: Study,
    folder: Path | str,
    *,
    resume: bool = False,
    n_jobs: int | None = None,
    progress: bool = True,
) -> dict[str, Comparison]:
    """Make the runs of a study, and write tables and report pages.

    The tables of a problem are written when its runs are finished: ``table.csv`` (indicators over
    evaluations), ``fronts.csv``, ``runs.csv``, ``tests.csv``, ``summary.md``, ``summary.tex``,
    ``report.html`` and ``provenance.json``. They are in `folder`, or in one subfolder per problem
    if there are several. In this case, `folder` also contains ``report.html``, ``summary.md``,
    ``summary.tex``, ``values.csv``, ``ranks.csv`` and ``targets.csv`` (see `mgeo.studies.pooled`),
    and the plotting library of all pages. Each run is stored in ``runs/`` as it finishes.

    Parameters
    ----------
    study : the study, see `read_study`.
    folder : folder to write into, created if it does not exist.
    resume : whether to continue the study in the folder. Its problems, algorithms, options,
        parameters, seeds, evaluations and versions must be equal to the recorded ones.
    n_jobs, progress : as for `mgeo.compare`.

    Returns
    -------
    Comparisons by problem label.

    Raises
    ------
    FileExistsError
        If the folder holds a study and `resume` is false.
    ValueError, TypeError
        If a problem or an algorithm cannot be built, or the folder holds another study.
    OSError
        If a file cannot be written.
    NothingToCompareError
        If all runs of a problem failed, or none found a feasible solution. The error is raised
        after the other problems are finished.

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
    places = {p.label: problem_folder(folder, p.label, len(study.problems)) for p in study.problems}
    how = {"resume": resume, "n_jobs": n_jobs, "progress": progress}
    experiments = _build_experiments(study, places, how)
    parts = [part for e in experiments.values() for part in (e.problem, *e.algorithms.values())]
    plan = study.plan() | {"versions": installed_versions(*parts)}
    with claim(folder, plan, resume=resume):
        write_file(folder / TEXT, study.text.encode())
        comparisons: dict[str, Comparison] = {}
        without: list[str] = []
        for label, experiment in experiments.items():
            try:
                comparison = comparisons[label] = experiment.compare()
            except NothingToCompareError as error:
                without.append(f"{label}: {error}")
                continue
            about = {
                "title": study.title,
                "problem": {"label": label, **plan["problems"][label]},
                "algorithms": plan["algorithms"],
                "evaluations": experiment.n_eval,
                "seeds": plan["seeds"],
                "versions": plan["versions"],
            }
            write_comparison(
                places[label], comparison, about, _files_of_problem(study, label, comparison)
            )
        if len(study.problems) > 1 and comparisons:
            write_files(folder, _files_over_problems(study, comparisons, without))
    if without:
        raise NothingToCompareError("; ".join(without))
    return comparisons


def _build_experiments(
    study: Study, places: Mapping[str, Path], how: Mapping[str, Any]
) -> dict[str, Experiment]:
    """Build all problems and algorithms before the first run, so that errors appear early.

    Raises
    ------
    ValueError, TypeError
        If a problem or an algorithm cannot be built.
    """
    experiments = {}
    for configuration in study.problems:
        label, problem = configuration.label, configuration.build()
        try:
            check_space(problem, parts=configuration.parts)
        except ValueError as error:
            raise ValueError(f"{label}: {error}") from error
        n_eval, grid = study.budget(problem)
        experiments[label] = Experiment(
            problem,
            {each.label: each.build(problem) for each in study.algorithms},
            n_eval,
            study.seeds,
            steps=grid_steps(grid, n_eval),
            space={"parts": configuration.parts},
            title=label,
            runs=places[label] / RECORDS,
            **how,
        )
    return experiments


def _files_over_problems(
    study: Study, comparisons: Mapping[str, Comparison], without: list[str]
) -> dict[str, bytes]:
    values = problem_values(comparisons, study.per_variable)
    standings = ranks_over_problems(values, study.control)
    marked = problems_table(comparisons)
    remarks = [text for label, each in comparisons.items() for text in each.failures(label)]
    remarks += [*without, *(text for each in comparisons.values() for text in each.notes)]
    summary = marked.markdown() + "".join(f"\n{text}\n" for text in remarks)
    return {
        LIBRARY: get_plotlyjs().encode(),
        "summary.md": summary.encode(),
        "summary.tex": marked.latex().encode(),
        VALUES: to_csv(values),
        RANKS: to_csv(standings),
        TARGETS: to_csv(targets_reached(comparisons)),
        REPORT_FILE: study_page(study, comparisons, standings, remarks).encode(),
    }


def _files_of_problem(study: Study, label: str, comparison: Comparison) -> dict[str, bytes]:
    pairs = {each.name: comparison.tests(each.name).pairs for each in comparison.measures}
    tests = pd.concat(pairs, names=["indicator"])
    summary = comparison.to_markdown() + "".join(f"\n{text}\n" for text in comparison.notes)
    published = published_table(study, comparison)
    if published is not None and study.published is not None:
        summary += f"\nBeside {study.published.source}:\n\n{markdown(published)}"
    return {
        "tests.csv": to_csv(tests.reset_index(0)),
        "summary.md": summary.encode(),
        "summary.tex": comparison.to_latex().encode(),
        REPORT_FILE: problem_page(study, label, comparison).encode(),
    }
