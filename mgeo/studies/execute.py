"""Execution of a comparison on one problem: `compare` executes runs and evaluates their fronts."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem

from mgeo.studies.arguments import (
    DEFAULT_GRID_SIZE,
    expand_grid,
    expand_seeds,
    label_algorithms,
)
from mgeo.studies.comparison import Comparison, ComparisonWarning, FailedRunsWarning
from mgeo.studies.comparison_files import format_folder_names, write_comparison
from mgeo.studies.indicators import (
    NoFeasibleSolutionError,
    build_indicator_rows,
    build_indicator_space,
    validate_space_arguments,
)
from mgeo.studies.plan import describe_algorithm, describe_problem, list_study_versions, lock_study
from mgeo.studies.progress import show_progress
from mgeo.studies.run import Task, run_task
from mgeo.studies.study_run import StudyRun
from mgeo.studies.trial_runs import (
    TrialResult,
    describe_limitations,
    make_trial_runs,
    reject_fractional_values,
)
from mgeo.validation.arguments import validate_integer

RUNS_FOLDER = "runs"  # Folder of the finished runs.

RunKey = tuple[str, int]
RunResult = StudyRun | str  # A failed run has an error message.


def compare(
    problem: Problem,
    algorithms: Mapping[str, Algorithm] | Iterable[Algorithm],
    n_eval: int,
    seeds: int | Iterable[int] = 10,
    *,
    folder: Path | str | None = None,
    resume: bool = False,
    grid: int | Sequence[int] = DEFAULT_GRID_SIZE,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    reference_front: ArrayLike | None = None,
    parts: Sequence[float] | None = None,
    n_jobs: int | None = None,
    progress: bool = True,
    title: str | None = None,
) -> Comparison:
    """Run all algorithms with all seeds on a problem, and compare their fronts.

    The front of a run is the set of nondominated points among *all* its evaluations, independent of
    the population that the algorithm keeps. Its indicators are computed after each evaluation count
    in `grid`, to the exact evaluation, in one indicator space for all runs. For a single objective,
    the best value takes the place of the front. A run that fails is reported, and the other runs
    continue. Each run uses its own copy of the problem and of the algorithm.

    Before its runs, each algorithm makes two short trial runs with the first seed, on random
    objective values. The trial runs show whether the algorithm is reproducible. Three points are
    evaluated twice to show whether the problem is noisy.

    joblib distributes the runs over `n_jobs` processes, or over the backend of
    ``joblib.parallel_config``, such as a Dask cluster. The table does not depend on the
    distribution if ``OPENBLAS_NUM_THREADS`` is equal on all processes: the command line sets it to
    1, loky to a share of the processors.

    Parameters
    ----------
    problem : Problem
        Any pymoo problem.
    algorithms : mapping of str to Algorithm, or iterable of Algorithm
        pymoo algorithms by label. Without labels, the class names are the labels.
    n_eval : int
        Number of evaluations of each run.
    seeds : int or iterable of int
        Number n of seeds, for the seeds 1 to n, or the seeds.
    folder : path, optional
        Folder in which each run is stored as it finishes, and the tables at the end, for
        `mgeo.studies.read_comparison`. By default, no files are written.
    resume : bool
        Whether to continue the study in the folder. Problem, algorithms with their parameters,
        seeds, evaluations and versions must equal the recorded ones. Other changes of code or data
        are not detected. Runs of algorithms that are not reproducible are repeated.
    grid : int or sequence of int
        Number of equal steps, or the evaluation counts, at which fronts are evaluated. The last
        count is always `n_eval`.
    bounds, reference_front, parts : optional
        Settings of the indicator space, see `mgeo.studies.indicators.build_indicator_space`.
    n_jobs : int, optional
        Number of processes in joblib's convention; -1 for one per processor.
    progress : bool
        Whether to show failed runs on stderr, and a progress bar on a terminal (with rich).
    title : str, optional
        Name of the problem in messages. Default: the class name of the problem.

    Returns
    -------
    Comparison
        Indicators, statistical tests and figures of all runs.

    Warns
    -----
    ComparisonWarning
        If the problem is noisy, an algorithm is not reproducible, or a first generation exceeds
        `n_eval` by more than a tenth. The `notes` of the comparison contain the same sentences.
    FailedRunsWarning
        For each algorithm whose runs all failed, with the first error.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, such as an algorithm that is already set up, an algorithm that
        evaluates fractional values of integer variables, or a dynamic problem.
    FileExistsError
        If the folder contains a study and `resume` is false.
    NoFeasibleSolutionError
        If every run failed, or no run found a feasible solution.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEODirected, compare
    >>> algorithms = {"directed": MGEODirected(), "nsga2": NSGA2(20)}
    >>> problem = ZDT1(n_var=4)
    >>> result = compare(problem, algorithms, n_eval=500, seeds=3, n_jobs=1, progress=False)
    >>> result.format_overview().index.to_list()
    ['directed', 'nsga2']
    """
    labeled = label_algorithms(algorithms)
    n_eval, seeds = validate_integer("n_eval", n_eval, low=1), expand_seeds(seeds)
    validate_space_arguments(problem, bounds, reference_front, parts)
    if resume and folder is None:
        raise ValueError("resume = True without folder: expected the folder of the study")
    experiment = Experiment(
        problem,
        labeled,
        n_eval,
        seeds,
        grid=expand_grid(grid, n_eval),
        space_options={"bounds": bounds, "reference_front": reference_front, "parts": parts},
        title=title or type(problem).__name__,
        runs_folder=None if folder is None else Path(folder) / RUNS_FOLDER,
        resume=resume,
        n_jobs=n_jobs,
        progress=progress,
    )
    if folder is None:
        return experiment.run()
    plan = _describe_plan(problem, labeled, n_eval, seeds)
    with lock_study(Path(folder), plan, resume=resume):
        comparison = experiment.run()
        write_comparison(Path(folder), comparison, plan)
    return comparison


@dataclass(frozen=True)
class Experiment:
    """Validated arguments of a comparison on one problem.

    Attributes
    ----------
    problem, algorithms, n_eval, seeds
        Problem, algorithms by label, evaluations of each run, and seeds.
    grid : sequence of int
        Ascending evaluation counts at which fronts are evaluated.
    space_options : mapping
        Keyword arguments `bounds`, `reference_front` and `parts` of `build_indicator_space`.
    title : str
        Name of the problem in messages.
    runs_folder : Path or None
        Folder in which each run is stored as it finishes; None if runs are not stored.
    resume : bool
        Whether to reuse the runs in this folder.
    n_jobs, progress
        As for `compare`.
    """

    problem: Problem
    algorithms: Mapping[str, Algorithm]
    n_eval: int
    seeds: Sequence[int]
    grid: Sequence[int]
    space_options: Mapping[str, Any]
    title: str
    runs_folder: Path | None
    resume: bool
    n_jobs: int | None
    progress: bool

    def run(self) -> Comparison:
        """Execute all runs and return the comparison.

        The warnings and errors are those of `compare`.
        """
        problem, n_eval, title = self.problem, self.n_eval, self.title
        keys = list(product(self.algorithms, self.seeds))
        tasks = {
            (label, seed): Task(problem, self.algorithms[label], n_eval, seed)
            for label, seed in keys
        }
        trials = self._make_trial_runs([tasks[label, self.seeds[0]] for label in self.algorithms])
        reject_fractional_values(trials, title)
        notes = tuple(describe_limitations(trials, title, n_eval))
        for message in notes:
            warnings.warn(message, ComparisonWarning, stacklevel=3)
        irreproducible = {label for label, trial in trials.items() if not trial.is_reproducible}
        results = self._make_runs(tasks, [key for key in keys if key[0] not in irreproducible])
        finished_runs = {key: r for key in keys if isinstance(r := results[key], StudyRun)}
        if not finished_runs:
            error = results[keys[0]]
            raise NoFeasibleSolutionError(f"all {len(keys)} runs failed, the first with {error}")
        fronts = [run.front_F for run in finished_runs.values()]
        space = build_indicator_space(problem, fronts, **self.space_options)
        rows = [
            {"algorithm": label, "seed": seed, **row}
            for (label, seed), run in finished_runs.items()
            for row in build_indicator_rows(problem, run, self.grid, space)
        ]
        table, runs = (
            pd.DataFrame(rows),
            pd.DataFrame([_build_run_row(k, results[k]) for k in keys]),
        )
        comparison = Comparison(
            problem, tuple(self.algorithms), n_eval, table, runs, finished_runs, space, notes
        )
        for message in comparison.describe_failures(title, all_failed_only=True):
            warnings.warn(message, FailedRunsWarning, stacklevel=3)
        return comparison

    def _make_trial_runs(self, tasks: Sequence[Task]) -> dict[str, TrialResult]:
        results = joblib.Parallel(self.n_jobs)(
            joblib.delayed(make_trial_runs)(task) for task in tasks
        )
        return {
            label: r for label, r in zip(self.algorithms, results, strict=True) if r is not None
        }

    def _make_runs(
        self, tasks: Mapping[RunKey, Task], reusable_keys: Sequence[RunKey]
    ) -> dict[RunKey, RunResult]:
        """Execute all runs that are not stored yet, and return the results of all runs.

        Each run is stored as it finishes.

        Parameters
        ----------
        tasks : mapping of (str, int) to Task
            Tasks by algorithm label and seed.
        reusable_keys : sequence of (str, int)
            Labels and seeds of runs that may be read from the folder if the study is resumed.
        """
        folder = self.runs_folder
        files: dict[RunKey, Path] = {}
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            names = format_folder_names(self.algorithms)
            files = {(label, s): folder / f"{names[label]}-seed{s}.npz" for label, s in tasks}
        results: dict[RunKey, RunResult] = {}
        for key in reusable_keys if self.resume else ():
            with suppress(FileNotFoundError):
                results[key] = StudyRun.read(files[key])
        n_reused = len(results) if self.resume else None
        with show_progress(self.title, len(tasks), n_reused, enabled=self.progress) as report:
            missing = {key: task for key, task in tasks.items() if key not in results}
            calls = [joblib.delayed(_run_with_key)(key, task) for key, task in missing.items()]
            pool: Any = joblib.Parallel(self.n_jobs, return_as="generator_unordered", batch_size=1)
            for (name, seed), result in pool(calls):
                # This process writes the file, because workers may not share a file system.
                if isinstance(result, StudyRun) and files:
                    result.write(files[name, seed])
                results[name, seed] = result
                report(name, seed, result if isinstance(result, str) else "")
        return results


def _run_with_key(key: RunKey, task: Task) -> tuple[RunKey, RunResult]:
    return key, run_task(task)


def _build_run_row(key: RunKey, result: RunResult) -> dict[str, Any]:
    row: dict[str, Any] = {"algorithm": key[0], "seed": key[1], "status": "failed"}
    row |= {"wall_time": np.nan, "failed_evaluations": 0, "error": ""}
    if isinstance(result, str):
        return row | {"error": result}
    statistics = {"wall_time": result.wall_time, "failed_evaluations": result.n_failed}
    return row | {"status": "finished"} | statistics


def _describe_plan(
    problem: Problem, algorithms: Mapping[str, Algorithm], n_eval: int, seeds: Sequence[int]
) -> dict[str, Any]:
    return {
        "problem": describe_problem(problem),
        "algorithms": {label: describe_algorithm(a) for label, a in algorithms.items()},
        "evaluations": n_eval,
        "seeds": list(seeds),
        "versions": list_study_versions(problem, *algorithms.values()),
    }
