"""Runs handed to processes, here or on a cluster, whatever becomes of these."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from concurrent.futures.process import BrokenProcessPool

import joblib
from joblib.parallel import get_active_backend

from mgeo.store.study_run import StudyRun
from mgeo.studies.cluster import prepare_workers
from mgeo.studies.run import Failure, Task, run

Key = tuple[str, int]
Result = StudyRun | Failure


def run_all(tasks: Mapping[Key, Task], n_jobs: int | None) -> Iterator[tuple[Key, Result]]:
    """Each run's result, as they come, or in groups from a backend that cannot give them singly.

    A run may bring down its process (a crash of compiled code, memory used up), and then those
    of others end with it. So what was under way at that moment is made again one by one, and the
    run with which a process dies once more is a failure; the rest goes on as before. (Not so with
    joblib's multiprocessing, which does not notice, and waits for that run.)

    Raises
    ------
    WorkerError
        If a worker of a Dask cluster cannot load a problem or an algorithm.
    """
    waiting = dict(tasks)
    backend, _ = get_active_backend()
    if waiting and "distributed" in sys.modules and hasattr(backend, "client"):
        parts = {id(p): p for task in tasks.values() for p in (task.problem, task.algorithm)}
        prepare_workers(backend.client, parts.values())
    while waiting:
        try:
            for key, result in _results(waiting, n_jobs):
                del waiting[key]
                yield key, result
        except _deaths():
            # joblib hands out in order, and at most twice as many ahead as there are processes
            under_way = list(waiting)[: 3 * joblib.effective_n_jobs(n_jobs)]
            for key in under_way:
                yield key, _alone(key, waiting.pop(key), n_jobs)


def _results(tasks: Mapping[Key, Task], n_jobs: int | None) -> Iterator[tuple[Key, Result]]:
    # a new Parallel for every call: after an error one keeps calls handed out but not begun, and
    # would make them together with those of its next call
    calls = [joblib.delayed(_keyed)(key, task) for key, task in tasks.items()]
    backend, _ = get_active_backend()
    if getattr(backend, "supports_return_generator", False):
        yield from joblib.Parallel(n_jobs, return_as="generator_unordered", batch_size=1)(calls)
        return
    # multiprocessing gives the results of a call all at once: so one run for each process a call
    step = joblib.effective_n_jobs(n_jobs)
    with joblib.Parallel(n_jobs, batch_size=1) as parallel:
        for i in range(0, len(calls), step):
            yield from parallel(calls[i : i + step])


def _alone(key: Key, task: Task, n_jobs: int | None) -> Result:
    try:
        ((_, result),) = _results({key: task}, n_jobs)
    except _deaths() as error:
        return Failure(f"its process died: {type(error).__name__}")
    return result


def _keyed(key: Key, task: Task) -> tuple[Key, Result]:
    return key, run(task)


def _deaths() -> tuple[type[Exception], ...]:
    """What joblib raises when a process died, and Dask when it did so several times."""
    if "distributed" not in sys.modules:
        return (BrokenProcessPool,)
    from distributed.scheduler import KilledWorker

    return BrokenProcessPool, KilledWorker
