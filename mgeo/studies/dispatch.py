"""Runs handed to processes, here or on a cluster, whatever becomes of these; and their progress."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import joblib
from joblib.parallel import get_active_backend

from mgeo.store.study_run import StudyRun
from mgeo.studies.fingerprint.modules import source_file
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


class WorkerError(ValueError):
    """A worker that cannot load a problem or an algorithm."""


def prepare_workers(client: Any, parts: Iterable[Any]) -> None:
    """Have every worker of a `distributed.Client` load problems and algorithms.

    A module that one lacks is sent to all, and to those that come later, if it is no installed
    distribution's: a file beside the study, or a package under development, as a zip file.

    Raises
    ------
    WorkerError
        If one still cannot; the message names the worker and the module.
    """
    from distributed.diagnostics.plugin import UploadFile
    from distributed.protocol.pickle import dumps

    content = dumps(list(parts))
    sent: set[str] = set()
    while lacking := _lacking(client, content):
        worker, module, error = lacking
        top = module.partition(".")[0]
        place = source_file(top) if top and top not in sent else None
        if place is None:
            raise WorkerError(
                f"worker {worker} cannot load {module or 'what it is to run'}: {error}; expected "
                "the same distributions on every worker as here"
            )
        sent.add(top)
        with TemporaryDirectory() as folder:
            try:
                client.register_plugin(
                    UploadFile(_whole(place, folder), load=place.stem == "__init__")
                )
            except Exception as failed:  # what importing it there raises
                raise WorkerError(f"worker {worker} cannot load {module}: {failed}") from failed


def _whole(place: Path, folder: str) -> str:
    """The file to send for a module: its own, or of a package a zip of its folder."""
    if place.stem != "__init__":
        return str(place)
    package = place.parent
    target = str(Path(folder, package.name))
    return shutil.make_archive(target, "zip", root_dir=package.parent, base_dir=package.name)


def _lacking(client: Any, content: bytes) -> tuple[str, str, str] | None:
    """The first worker that cannot load this, the module that it lacks, if any, and its error."""
    told = client.run(_loaded, content)
    return next(((worker, *found) for worker, found in told.items() if found), None)


def _loaded(content: bytes) -> tuple[str, str] | None:
    """On a worker: why this cannot be loaded."""
    from distributed.protocol.pickle import loads

    try:
        loads(content)
    except Exception as error:  # whatever foreign code raises while it is imported
        return getattr(error, "name", None) or "", f"{type(error).__name__}: {error}"
    return None


_LINES_EVERY = 1.0  # seconds at least between two lines about runs that finished

Done = Callable[[str, int, str], None]  # hears of each run that ends: algorithm, seed, its error


@contextmanager
def progress(title: str, total: int, found: int, shown: bool | None) -> Iterator[Done]:
    """A bar on a terminal; elsewhere a line per run, or per second if they are shorter.

    Parameters
    ----------
    total, found : how many runs there are, and how many of them were made before.
    shown : False for nothing, None for something only if stderr is a terminal.
    """
    terminal = sys.stderr.isatty()
    if shown is False or (shown is None and not terminal):
        yield lambda name, seed, error: None
    elif not terminal:
        yield _lines(title, total, found)
    else:
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
        )
        from rich.progress import TimeRemainingColumn as TimeLeftColumn

        from mgeo.terminal import console

        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[failed]}", style="red", markup=False),
            TimeElapsedColumn(),
            TimeLeftColumn(elapsed_when_finished=False),
        )
        with Progress(*columns, console=console(stderr=True)) as bar:
            yield _bar(bar, title, total, found)


def _lines(title: str, total: int, found: int) -> Done:
    print(f"{title}: {total} runs, {found} of them found on disk", file=sys.stderr)
    ended, soonest = found, 0.0

    def done(name: str, seed: int, error: str) -> None:
        nonlocal ended, soonest
        ended += 1
        if error or time.monotonic() >= soonest or ended == total:
            soonest = time.monotonic() + _LINES_EVERY
            outcome = f"failed: {error}" if error else "finished"
            line = f"{ended}/{total}  {name}, seed {seed}: {outcome}"
            print(line, file=sys.stderr, flush=True)

    return done


def _bar(bar: Any, title: str, total: int, found: int) -> Done:
    task = bar.add_task(title, total=total, completed=found, failed="")
    failed = 0

    def done(name: str, seed: int, error: str) -> None:
        nonlocal failed
        if error:
            failed += 1
            bar.update(task, failed=f"{failed} failed")
            bar.console.print(f"{name}, seed {seed}: {error}", markup=False, style="red")
        bar.advance(task)

    return done
