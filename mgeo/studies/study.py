"""Execution of a study file: one comparison per problem, with tables and report pages."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plotly.offline import get_plotlyjs

from mgeo.figures.page import LIBRARY_FILE
from mgeo.store.atomic import write_file, write_files
from mgeo.store.readers import encode_csv
from mgeo.store.run_folder import REPORT_FILE
from mgeo.studies.aggregation import (
    compute_average_ranks,
    compute_problem_values,
    compute_runtime_distribution,
)
from mgeo.studies.arguments import expand_grid
from mgeo.studies.comparison import Comparison
from mgeo.studies.comparison_files import select_problem_folders, write_comparison
from mgeo.studies.conclusions import build_test_table, format_published_table, list_warnings
from mgeo.studies.execute import RUNS_FOLDER, Experiment
from mgeo.studies.indicators import NoFeasibleSolutionError, validate_space_arguments
from mgeo.studies.plan import list_study_versions, lock_study
from mgeo.studies.report import render_problem_page, render_study_page
from mgeo.studies.study_file import Study
from mgeo.studies.tables import build_study_table, format_markdown

STUDY_TOML_FILE = "study.toml"
VALUES_FILE = "values.csv"
RANKS_FILE = "ranks.csv"
TARGETS_FILE = "targets.csv"


def run_study(
    study: Study,
    folder: Path | str,
    *,
    resume: bool = False,
    n_jobs: int | None = None,
    progress: bool = True,
) -> dict[str, Comparison]:
    """Run all algorithms of a study on all problems, and write the results into a folder.

    The tables of a problem are written when its runs are finished: ``table.csv`` (indicators over
    evaluations), ``fronts.csv``, ``runs.csv``, ``tests.csv``, ``summary.md``, ``summary.tex``,
    ``report.html`` and ``provenance.json``. They are in `folder`, or in one subfolder per problem
    if the study has several problems. In this case, `folder` also contains ``report.html``,
    ``summary.md``, ``summary.tex``, ``values.csv``, ``ranks.csv`` and ``targets.csv`` (see
    `mgeo.studies.aggregation`), and the plotting library of all pages. Each run is stored in
    ``runs/`` as it finishes.

    Parameters
    ----------
    study : Study
        Study to run, as returned by `read_study`.
    folder : path
        Folder for the results, created if it does not exist.
    resume : bool
        Whether to continue the study in the folder. The problems, algorithms, options, parameters,
        seeds, evaluations and software versions must equal the recorded ones.
    n_jobs : int, optional
        Number of processes, as for `mgeo.compare`.
    progress : bool
        Whether to show the progress on stderr, as for `mgeo.compare`.

    Returns
    -------
    dict of str to Comparison
        Comparison of the algorithms on each problem, by the label of the problem.

    Raises
    ------
    FileExistsError
        If the folder already contains a study and `resume` is false.
    ValueError, TypeError
        If a problem or an algorithm cannot be built, or the folder contains another study.
    OSError
        If a file cannot be written.
    NoFeasibleSolutionError
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
    >>> comparisons = run_study(read_study("study.toml"), "results", n_jobs=1, progress=False)
    >>> list(comparisons), Path("results/summary.md").exists()
    (['zdt1'], True)
    """
    folder = Path(folder)
    problem_folders = select_problem_folders(folder, [p.label for p in study.problems])
    run_options = {"resume": resume, "n_jobs": n_jobs, "progress": progress}
    experiments = _build_experiments(study, problem_folders, run_options)
    objects = [x for e in experiments.values() for x in (e.problem, *e.algorithms.values())]
    plan = study.build_plan() | {"versions": list_study_versions(*objects)}
    with lock_study(folder, plan, resume=resume):
        write_file(folder / STUDY_TOML_FILE, study.text.encode())
        comparisons: dict[str, Comparison] = {}
        errors: list[str] = []
        for label, experiment in experiments.items():
            try:
                comparison = comparisons[label] = experiment.run()
            except NoFeasibleSolutionError as error:
                errors.append(f"{label}: {error}")
                continue
            provenance = {
                "title": study.title,
                "problem": {"label": label, **plan["problems"][label]},
                "algorithms": plan["algorithms"],
                "evaluations": experiment.n_eval,
                "seeds": plan["seeds"],
                "versions": plan["versions"],
            }
            files = _build_problem_files(study, label, comparison)
            write_comparison(problem_folders[label], comparison, provenance, files)
        if len(study.problems) > 1 and comparisons:
            write_files(folder, _build_study_files(study, comparisons, errors))
    if errors:
        raise NoFeasibleSolutionError("; ".join(errors))
    return comparisons


def _build_experiments(
    study: Study, folders: Mapping[str, Path], run_options: Mapping[str, Any]
) -> dict[str, Experiment]:
    """Build one experiment per problem, so that errors occur before the first run.

    Raises
    ------
    ValueError, TypeError
        If a problem or an algorithm cannot be built.
    """
    experiments = {}
    for configuration in study.problems:
        label = configuration.label
        try:
            problem = configuration.build()
            validate_space_arguments(problem, parts=configuration.parts)
        except ValueError as error:
            raise ValueError(f"{label}: {error}") from error
        n_eval, grid = study.compute_budget(problem)
        experiments[label] = Experiment(
            problem,
            {algorithm.label: algorithm.build(problem) for algorithm in study.algorithms},
            n_eval,
            study.seeds,
            grid=expand_grid(grid, n_eval),
            space_options={"parts": configuration.parts},
            title=label,
            runs_folder=folders[label] / RUNS_FOLDER,
            **run_options,
        )
    return experiments


def _build_study_files(
    study: Study, comparisons: Mapping[str, Comparison], errors: list[str]
) -> dict[str, bytes]:
    values = compute_problem_values(comparisons, study.per_variable)
    ranks = compute_average_ranks(values, study.control)
    table = build_study_table(comparisons)
    warnings = [*errors, *list_warnings(comparisons, study.control)]
    summary = table.to_markdown() + "".join(f"\n{text}\n" for text in warnings)
    return {
        LIBRARY_FILE: get_plotlyjs().encode(),
        "summary.md": summary.encode(),
        "summary.tex": table.to_latex().encode(),
        VALUES_FILE: encode_csv(values),
        RANKS_FILE: encode_csv(ranks),
        TARGETS_FILE: encode_csv(compute_runtime_distribution(comparisons)),
        REPORT_FILE: render_study_page(study, comparisons, ranks, errors).encode(),
    }


def _build_problem_files(study: Study, label: str, comparison: Comparison) -> dict[str, bytes]:
    tests = build_test_table(comparison, study.control)
    summary = comparison.to_markdown() + "".join(f"\n{text}\n" for text in comparison.notes)
    published = format_published_table(study, comparison)
    if published is not None and study.published is not None:
        summary += f"\nCompared with {study.published.source}:\n\n{format_markdown(published)}"
    return {
        "tests.csv": encode_csv(tests),
        "summary.md": summary.encode(),
        "summary.tex": comparison.to_latex().encode(),
        REPORT_FILE: render_problem_page(study, label, comparison).encode(),
    }
