"""One run of a comparison, wherever it is made."""

from __future__ import annotations

import random
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mgeo.runs.solve import set_up
from mgeo.studies.log import EvaluationLog, WatchedEvaluator
from mgeo.studies.record import Record
from mgeo.studies.versions import made_with

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

_PATIENCE = 1000  # steps without an evaluation after which a run counts as stuck


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


@dataclass(frozen=True)
class Failure:
    """A run that ended in an exception."""

    error: str
    traceback: str


def run(task: Task) -> Record | Failure:
    """Make it; what it raises is returned, so that other runs go on."""
    try:
        return record(task)
    except Exception as error:  # foreign code: it may raise anything
        message = " ".join(str(error).split())
        return Failure(f"{type(error).__name__}: {message}", traceback.format_exc())


def record(task: Task) -> Record:
    """Run a copy of the algorithm for `n_eval` evaluations, and the rest of that generation.

    The algorithm draws from its own generator, seeded by `Task.seed`. For those that (also) draw
    from the global state of NumPy or of Python, that is seeded too, and put back afterwards;
    where runs share a process, in threads, such algorithms do not repeat.

    Raises
    ------
    RuntimeError
        If the algorithm stops making evaluations before.
    """
    began = time.perf_counter()
    with _global_state(task.seed):
        algorithm = set_up(task.problem, task.algorithm, task.n_eval, task.seed)
        log = EvaluationLog(task.problem.n_obj, task.n_eval)
        algorithm.evaluator = WatchedEvaluator(algorithm.evaluator, log)
        idle = 0
        # An algorithm's own termination is not asked: some end a generation early.
        while log.seen < task.n_eval:
            before = log.seen
            algorithm.next()
            idle = idle + 1 if log.seen == before else 0
            if idle == _PATIENCE:
                raise RuntimeError(
                    f"{type(task.algorithm).__name__} made no new candidate after {log.seen} of "
                    f"{task.n_eval} evaluations"
                )
    versions = made_with(task.problem, task.algorithm)
    return replace(log.record(time.perf_counter() - began), versions=versions)


@contextmanager
def _global_state(seed: int) -> Iterator[None]:
    numpy_state, python_state = np.random.get_state(), random.getstate()  # noqa: NPY002
    np.random.seed(seed % 2**32)  # noqa: NPY002
    random.seed(seed)
    try:
        yield
    finally:
        np.random.set_state(numpy_state)  # noqa: NPY002
        random.setstate(python_state)
