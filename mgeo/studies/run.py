"""One run of a comparison, wherever it is made, watched from outside.

That is the same for every pymoo algorithm, whatever it keeps or returns itself.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo._text import one_line
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.staged import MGEOStaged, is_rough
from mgeo.evaluation.dominance import not_weakly_dominated
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.evaluation.individuals import succeeded
from mgeo.runs.setup import IDLE_STEPS, set_up
from mgeo.store.study_run import StudyRun
from mgeo.studies.fingerprint.modules import made_with

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm


@dataclass(frozen=True, slots=True)
class Task:
    """A run to be made.

    It has slots, and so no weak references, for Dask's sake: joblib would keep an object with
    them on one worker only, and lose it with that worker.
    """

    problem: Problem
    algorithm: Algorithm
    n_eval: int
    seed: int
    coco: CocoFolder | None = None


@dataclass(frozen=True, slots=True)
class CocoFolder:
    """Where COCO's observer writes of a run, and what it calls the algorithm."""

    path: Path
    algorithm: str


@dataclass(frozen=True)
class Failure:
    """A run that ended in an exception."""

    error: str


def run(task: Task) -> StudyRun | Failure:
    """Make it; what it raises is returned, so that other runs go on."""
    try:
        return record(task)
    except Exception as error:  # foreign code: it may raise anything
        return Failure(told(error))


def told(error: Exception) -> str:
    """Kind and message of an error, on one line."""
    return f"{type(error).__name__}: {one_line(str(error))}"


def record(task: Task) -> StudyRun:
    """Run a copy of the algorithm for `n_eval` evaluations, and the rest of that generation.

    The algorithm draws from its own generator, seeded by `Task.seed`. For those that (also) draw
    from the global state of NumPy or of Python, that is seeded too, and put back afterwards;
    where runs share a process, in threads, such algorithms do not repeat.

    Raises
    ------
    RuntimeError
        If the algorithm stops making evaluations before.
    EvaluationError
        If every candidate failed.
    """
    began = time.perf_counter()
    with ExitStack() as during:
        during.enter_context(global_state(task.seed))
        algorithm = set_up(task.problem, task.algorithm, task.n_eval, task.seed)
        log = EvaluationLog(task.problem.n_obj, task.n_eval)
        evaluator = algorithm.evaluator
        watches: list[Callable[[Population, Any], object]] = [log]
        if task.coco is not None:
            from mgeo.benchmarks.coco import coco_data

            logged = coco_data(task.problem, task.coco.path, task.coco.algorithm, task.n_eval)
            watches.append(during.enter_context(logged))
        algorithm.evaluator = WatchedEvaluator(evaluator, *watches)
        idle = 0
        # An algorithm's own termination is not asked: some end a generation early.
        while log.seen < task.n_eval:
            before = log.seen
            algorithm.next()
            idle = idle + 1 if log.seen == before else 0
            if idle == IDLE_STEPS:
                raise RuntimeError(
                    f"{type(task.algorithm).__name__} made no new candidate after {log.seen} of "
                    f"{task.n_eval} evaluations"
                )
        if isinstance(algorithm, MGEOStaged):
            algorithm.conclude()
        if isinstance(evaluator, TolerantEvaluator):
            evaluator.require_success()
    versions = made_with(task.problem, task.algorithm)
    return replace(log.record(time.perf_counter() - began), versions=versions)


class EvaluationLog:
    """Keeps every evaluation that no earlier batch weakly dominates: all that a front can need.

    Infeasible solutions, those that failed (see `mgeo.TolerantEvaluator`) and those with a value
    that is not finite count as evaluations and are otherwise left out, as is whatever comes after
    the first `n_eval`. So are the estimates of a staged run (see `mgeo.MGEOStaged`): its front is
    empty until it judges what it has found by the objectives themselves. That judgment proposes
    nothing new, and counts whole: what of it comes after the first `n_eval`, as if it were the
    last of these. `evaluations` of the record tells how many were made.

    Parameters
    ----------
    n_obj : number of objectives.
    n_eval : how many evaluations to look at.

    Attributes
    ----------
    seen : evaluations so far, beyond `n_eval` too.
    failed : how many of the first `n_eval` failed.
    """

    def __init__(self, n_obj: int, n_eval: int) -> None:
        self.n_eval = n_eval
        self.seen = 0
        self.failed = 0
        self._archive = ParetoArchive(n_obj)
        self._rows = 0
        self._numbers: list[Any] = []
        self._F: list[Any] = [np.empty((0, n_obj))]
        self._X: list[Any] = []

    def __call__(self, population: Population, algorithm: Algorithm | None = None) -> None:
        """Take a batch that has just been evaluated for `algorithm`, in the order of evaluation."""
        F = population.get("F").astype(float)
        numbers = np.arange(self.seen + 1, self.seen + 1 + len(F))
        self.seen += len(F)
        failed = ~succeeded(population)
        self.failed += int(np.count_nonzero(failed & (numbers <= self.n_eval)))
        if is_rough(algorithm):
            return
        if isinstance(algorithm, MGEOStaged) and algorithm.judging:
            numbers = np.minimum(numbers, self.n_eval)
        kept = population.get("feas") & np.isfinite(F).all(axis=1) & (numbers <= self.n_eval)
        kept &= ~failed
        kept[kept] = not_weakly_dominated(F[kept], self._archive.F)
        if not kept.any():
            return
        rows = np.arange(self._rows, self._rows + np.count_nonzero(kept))
        self._rows += len(rows)
        self._archive.add(F[kept], rows.astype(object))
        self._numbers.append(numbers[kept])
        self._F.append(F[kept])
        self._X.append(np.array(population[kept].get("X")))

    def record(self, wall_time: float) -> StudyRun:
        """All of it; `wall_time` in seconds goes with it."""
        rows = np.array(self._archive.individuals, dtype=np.int64)
        return StudyRun(
            numbers=np.concatenate([np.empty(0, dtype=np.int64), *self._numbers]),
            F=np.concatenate(self._F),
            front=rows,
            X=_numeric(self._X, rows),
            n_eval=self.n_eval,
            evaluations=self.seen,
            failed=self.failed,
            wall_time=wall_time,
        )


class WatchedEvaluator(Evaluator):
    """Another evaluator, with a look at each batch it really evaluates, and for what algorithm."""

    def __init__(self, inner: Evaluator, *watches: Callable[[Population, Any], object]) -> None:
        super().__init__(inner.skip_already_evaluated, inner.evaluate_values_of, inner.callback)
        self._inner = inner
        self._watches = watches

    def _eval(self, problem: Problem, pop: Population, values: Any, **kwargs: Any) -> None:
        self._inner._eval(problem, pop, values, **kwargs)
        for watch in self._watches:
            watch(pop, kwargs.get("algorithm"))


def _numeric(X: list[Any], rows: Any) -> Any:
    """(n, n_var) floats of the rows asked for; no columns if the variables are not numbers."""
    if not X or X[0].ndim != 2 or X[0].dtype == object:
        return np.empty((len(rows), 0))
    return np.concatenate(X)[rows].astype(float)


@contextmanager
def global_state(seed: int) -> Iterator[None]:
    """Seed both, and put them back as they were."""
    numpy_state, python_state = np.random.get_state(), random.getstate()  # noqa: NPY002
    np.random.seed(seed % 2**32)  # noqa: NPY002
    random.seed(seed)
    try:
        yield
    finally:
        np.random.set_state(numpy_state)  # noqa: NPY002
        random.setstate(python_state)
