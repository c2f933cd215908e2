"""Execution of one run of a study, with a log of all its evaluations.

The evaluations are logged outside of the algorithm, so that the log has the same meaning for every
pymoo algorithm.
"""

from __future__ import annotations

import copy
import random
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo._text import join_lines
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.staged import MGEOStaged, is_low_fidelity
from mgeo.evaluation.dominance import find_not_weakly_dominated
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.evaluation.individuals import find_successful
from mgeo.runs.algorithms import MAX_IDLE_GENERATIONS, set_up
from mgeo.studies.study_run import StudyRun

#: Function that is called with problem, population and algorithm after each evaluated batch.
BatchCallback = Callable[[Any, Population, Any], object]


@dataclass(frozen=True, slots=True)
class Task:
    """Arguments of one run: problem, algorithm, evaluation budget and seed.

    The class has slots and no weak references, because joblib's Dask backend would otherwise store
    the task on one worker only.
    """

    problem: Problem
    algorithm: Algorithm
    n_eval: int
    seed: int


def run_task(task: Task) -> StudyRun | str:
    """Execute a run and return it, or return an error message if the run fails.

    Returning errors instead of raising them lets the other runs continue.
    """
    try:
        return record_run(task)
    except Exception as error:  # External algorithms and problems may raise any error.
        return f"{type(error).__name__}: {join_lines(str(error))}"


def record_run(task: Task) -> StudyRun:
    """Execute a run and return its log as a `StudyRun`. The task is not modified.

    The run ends with the generation that completes `n_eval` evaluations. The algorithm uses its own
    random generator, seeded by `Task.seed`. The global generators of NumPy and Python are seeded as
    well and restored afterwards. Algorithms that use the global generators are not reproducible if
    runs share a process in threads.

    Raises
    ------
    RuntimeError
        If the algorithm stops proposing candidates before `n_eval` evaluations.
    EvaluationError
        If the evaluation of every candidate failed.
    """
    start = time.perf_counter()
    log = EvaluationLog(task.problem.n_obj, task.n_eval)
    with seed_global_generators(task.seed), warnings.catch_warnings():
        # The notes of the comparison state this condition once for all runs.
        warnings.filterwarnings("ignore", "the first generation of")
        problem = copy.deepcopy(task.problem)
        for algorithm in iterate_generations(task, problem, lambda _, *batch: log(*batch)):
            evaluator = algorithm.evaluator.inner
        if isinstance(algorithm, MGEOStaged):
            algorithm.evaluate_archive()
        if isinstance(evaluator, TolerantEvaluator):
            evaluator.require_success()
    return log.build_run(time.perf_counter() - start)


def iterate_generations(task: Task, problem: Problem, on_batch: BatchCallback) -> Iterator[Any]:
    """Run an algorithm for `n_eval` evaluations, and yield it after each generation.

    The algorithm's own termination criterion is not used, because some criteria stop within a
    generation.

    Parameters
    ----------
    task : Task
        Run to execute. Its algorithm is copied.
    problem : Problem
        Copy of the problem of the task.
    on_batch : function
        Called with problem, population and algorithm after each evaluated batch.

    Yields
    ------
    Algorithm
        The running copy of the algorithm.

    Raises
    ------
    RuntimeError
        If the algorithm stops proposing candidates.
    """
    algorithm = set_up(problem, task.algorithm, task.n_eval, task.seed)
    evaluator = algorithm.evaluator = ReportingEvaluator(algorithm.evaluator, on_batch)
    n_idle = 0
    while evaluator.n_evaluations < task.n_eval:
        n_before = evaluator.n_evaluations
        algorithm.next()
        n_idle = n_idle + 1 if evaluator.n_evaluations == n_before else 0
        if n_idle == MAX_IDLE_GENERATIONS:
            raise RuntimeError(
                f"{type(task.algorithm).__name__} proposed no new candidate after {n_before} of "
                f"{task.n_eval} evaluations"
            )
        yield algorithm


class EvaluationLog:
    """Log from which the front of a run after any number of evaluations can be reconstructed.

    A point is logged unless a point of an earlier batch weakly dominates it. Infeasible solutions,
    failed evaluations (see `mgeo.TolerantEvaluator`) and values that are not finite are counted,
    but not logged. Low-fidelity values of `mgeo.MGEOStaged` are not logged either: its front is
    empty until the final high-fidelity evaluation. This final evaluation proposes no new candidates
    and counts as part of the first `n_eval` evaluations.

    Parameters
    ----------
    n_obj : int
        Number of objectives.
    n_eval : int
        Number of evaluations to log.

    Attributes
    ----------
    n_evaluations : int
        Number of evaluations so far, including those beyond `n_eval`.
    n_failed : int
        Number of failures among the first `n_eval` evaluations.
    """

    def __init__(self, n_obj: int, n_eval: int) -> None:
        self.n_eval = n_eval
        self.n_evaluations = 0
        self.n_failed = 0
        self._archive = ParetoArchive(n_obj)
        self._n_rows = 0
        self._numbers: list[Any] = []
        self._F: list[Any] = [np.empty((0, n_obj))]
        self._X: list[Any] = []

    def __call__(self, population: Population, algorithm: Algorithm | None = None) -> None:
        """Log a batch of evaluated candidates in the order of their evaluation."""
        F = population.get("F").astype(float)
        numbers = np.arange(self.n_evaluations + 1, self.n_evaluations + 1 + len(F))
        self.n_evaluations += len(F)
        failed = ~find_successful(population)
        self.n_failed += int(np.count_nonzero(failed & (numbers <= self.n_eval)))
        if is_low_fidelity(algorithm):
            return
        if isinstance(algorithm, MGEOStaged) and algorithm.is_reevaluating:
            numbers = np.minimum(numbers, self.n_eval)
        is_logged = population.get("feas") & np.isfinite(F).all(axis=1) & (numbers <= self.n_eval)
        is_logged &= ~failed
        is_logged[is_logged] = find_not_weakly_dominated(F[is_logged], self._archive.F)
        if not is_logged.any():
            return
        rows = np.arange(self._n_rows, self._n_rows + np.count_nonzero(is_logged))
        self._n_rows += len(rows)
        self._archive.add(F[is_logged], rows.astype(object))
        self._numbers.append(numbers[is_logged])
        self._F.append(F[is_logged])
        self._X.append(np.array(population[is_logged].get("X")))

    def build_run(self, wall_time: float) -> StudyRun:
        """Return the logged points and statistics as a `StudyRun`.

        Parameters
        ----------
        wall_time : float
            Duration of the run [s].
        """
        rows = np.array(self._archive.individuals, dtype=np.int64)
        return StudyRun(
            evaluation_numbers=np.concatenate([np.empty(0, dtype=np.int64), *self._numbers]),
            F=np.concatenate(self._F),
            front_rows=rows,
            X=_select_numeric_rows(self._X, rows),
            n_eval=self.n_eval,
            n_evaluations=self.n_evaluations,
            n_failed=self.n_failed,
            wall_time=wall_time,
        )


class ReportingEvaluator(Evaluator):
    """Evaluator that calls a function after each batch.

    Parameters
    ----------
    inner : Evaluator
        Evaluator that evaluates the batches.
    on_batch : function
        Called with problem, population and algorithm after each batch.

    Attributes
    ----------
    n_evaluations : int
        Number of evaluations so far.
    """

    def __init__(self, inner: Evaluator, on_batch: BatchCallback) -> None:
        super().__init__(inner.skip_already_evaluated, inner.evaluate_values_of, inner.callback)
        self.inner = inner
        self.n_evaluations = 0
        self._on_batch = on_batch

    def _eval(self, problem: Problem, pop: Population, values: Any, **kwargs: Any) -> None:
        self.inner._eval(problem, pop, values, **kwargs)
        self.n_evaluations += len(pop)
        self._on_batch(problem, pop, kwargs.get("algorithm"))


def _select_numeric_rows(X: list[Any], rows: Any) -> Any:
    """Return selected designs as a float array, without columns if designs are not numeric."""
    if not X or X[0].ndim != 2 or X[0].dtype == object:
        return np.empty((len(rows), 0))
    return np.concatenate(X)[rows].astype(float)


@contextmanager
def seed_global_generators(seed: int) -> Iterator[None]:
    """Context manager that seeds the global random generators of NumPy and Python.

    Both generators are restored to their previous state on exit.
    """
    numpy_state, python_state = np.random.get_state(), random.getstate()  # noqa: NPY002
    np.random.seed(seed % 2**32)  # noqa: NPY002
    random.seed(seed)
    try:
        yield
    finally:
        np.random.set_state(numpy_state)  # noqa: NPY002
        random.setstate(python_state)
