"""The comparison itself: which runs there are, making those that are missing, measuring all."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo.runs.operators import fitted
from mgeo.store.study_run import StudyRun
from mgeo.studies.comparison import Comparison
from mgeo.studies.dispatch import Key, Result, run_all
from mgeo.studies.dispatch import progress as progress_display
from mgeo.studies.fingerprint.modules import UncertainError
from mgeo.studies.fingerprint.parts import fingerprint
from mgeo.studies.indicators import NothingToCompareError, check_space, indicator_space, trace
from mgeo.studies.labels import folder_name
from mgeo.studies.results import FailedRunsWarning, NotReusedWarning, failures
from mgeo.studies.run import CocoFolder, Failure, Task
from mgeo.validation.arguments import validate_integer

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

GRID_POINTS = 50
MOST = 100_000  # runs of a kind: more are a slip

_OLD = re.compile(r"-[0-9a-f]{12,20}-seed\d+\.npz$")  # fingerprints of earlier versions


def compare(
    problem: Problem,
    algorithms: Mapping[str, Algorithm] | Iterable[Algorithm],
    n_eval: int,
    seeds: int | Iterable[int] = 10,
    *,
    folder: Path | str | None = None,
    grid: int | Sequence[int] = GRID_POINTS,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    reference_front: ArrayLike | None = None,
    parts: Sequence[float] | None = None,
    n_jobs: int | None = None,
    progress: bool | None = None,
    title: str | None = None,
    coco_data: Path | str | None = None,
) -> Comparison:
    """Run every algorithm with every seed, and measure all fronts in one space, or the best value
    that each run finds if there is a single objective.

    The front of a run is the set of nondominated points among *all* its evaluations, whatever
    the algorithm keeps or returns itself; it is measured after each number of evaluations in
    `grid`, to the exact evaluation. A run that fails is reported and the others go on.

    Runs are spread by joblib: over processes with `n_jobs`, or as ``joblib.parallel_config``
    says, such as over a Dask cluster. The table does not depend on it, if ``OPENBLAS_NUM_THREADS``
    is the same everywhere: the command sets it to 1, loky to a share of the processors. The default
    backend (loky) and Dask survive a process that dies.

    Parameters
    ----------
    problem : any pymoo problem.
    algorithms : pymoo algorithms by the label to show; without labels, their classes' names. Those
        of pymoo get operators for the problem's variables (see `mgeo.runs.operators.fitted`).
    n_eval : evaluations of each run.
    seeds : how many (1, 2, ...), or which.
    folder : where finished runs are kept, and found when the same comparison (or a larger one)
        is made again; None to keep nothing. A run is known by what its problem and its algorithm
        compute (see `mgeo.studies.fingerprint`), not by their names.
    grid : how many equal steps, or at which numbers of evaluations; `n_eval` always belongs to it.
    bounds, reference_front, parts : of the indicators' space, see `mgeo.studies.indicators`.
    n_jobs : processes, as joblib counts them: -1 for one per processor.
    progress : False for no display; None for one only if stderr is a terminal.
    title : of that display; default: the problem's class.
    coco_data : where COCO's observer writes of each run, a folder for each algorithm, which
        ``cocopp`` reads; the problem is one of COCO's then, and all processes of this machine. A
        run is found in `folder` only if its data are there, too.

    Warns
    -----
    NotReusedWarning
        If a problem or an algorithm cannot be identified for certain: its runs are made, but
        neither kept nor found.
    FailedRunsWarning
        For each algorithm of which all runs failed, with its first error.

    Raises
    ------
    TypeError, ValueError
        For an argument that cannot be used.
    NothingToCompareError
        If every run failed (with the message of one of them), or none found a feasible solution.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEODirected, compare
    >>> algorithms = {"directed": MGEODirected(), "nsga2": NSGA2(20)}
    >>> found = compare(ZDT1(n_var=4), algorithms, n_eval=500, seeds=3, n_jobs=1, progress=False)
    >>> found.overview().index.to_list()
    ['directed', 'nsga2']
    """
    named = _labeled(algorithms)
    n_eval = validate_integer("n_eval", n_eval, low=1)
    steps = _grid(grid, n_eval)
    check_space(problem, bounds=bounds, reference_front=reference_front, parts=parts)
    keys = list(product(named, seed_numbers(seeds)))
    # here, and not in the processes that make the runs: what a run is known by includes it
    ready = {name: fitted(each, problem, f"algorithms[{name!r}]") for name, each in named.items()}
    places = {key: _coco_folder(coco_data, problem, *key) for key in keys}
    tasks = {(name, s): Task(problem, ready[name], n_eval, s, places[name, s]) for name, s in keys}
    title = title or type(problem).__name__
    results = _found_or_made(title, tasks, folder, n_jobs, progress)
    records = {key: r for key in keys if isinstance(r := results[key], StudyRun)}
    if not records:
        first = next(r.error for r in results.values() if isinstance(r, Failure))
        raise NothingToCompareError(f"all {len(keys)} runs failed, one of them with {first}")
    space = indicator_space(
        problem,
        [record.front_F for record in records.values()],
        bounds=bounds,
        reference_front=reference_front,
        parts=parts,
    )
    rows = [
        {"algorithm": name, "seed": seed, **row}
        for (name, seed), record in records.items()
        for row in trace(problem, record, steps, space)
    ]
    runs = pd.DataFrame([_run_row(key, results[key]) for key in keys])
    made = Comparison(problem, tuple(named), n_eval, pd.DataFrame(rows), runs, records, space)
    for message in failures(made.failures().query("failed == runs"), title):
        warnings.warn(message, FailedRunsWarning, stacklevel=2)
    return made


def _found_or_made(
    title: str,
    tasks: Mapping[Key, Task],
    folder: Path | str | None,
    n_jobs: int | None,
    shown: bool | None,
) -> dict[Key, Result]:
    files = {} if folder is None else run_files(Path(folder), tasks)
    results: dict[Key, Result] = {}
    for key, path in files.items():
        coco = tasks[key].coco
        with suppress(FileNotFoundError):
            if coco is None or coco.path.is_dir():
                results[key] = StudyRun.read(path)
    missing = {key: task for key, task in tasks.items() if key not in results}
    with progress_display(title, len(tasks), len(results), shown) as done:
        for key, result in run_all(missing, n_jobs):
            # kept by this process, as soon as it is there: workers need not share a file system
            if isinstance(result, StudyRun) and key in files:
                result.write(files[key])
            results[key] = result
            done(*key, result.error if isinstance(result, Failure) else "")
    return results


def _coco_folder(
    folder: Path | str | None, problem: Problem, algorithm: str, seed: int
) -> CocoFolder | None:
    if folder is None:
        return None
    from mgeo.benchmarks.coco import run_folder  # needs the extra

    below = Path(folder).absolute() / folder_name(algorithm)
    return CocoFolder(run_folder(below, problem, seed), algorithm)


def _run_row(key: Key, result: Result) -> dict[str, Any]:
    if isinstance(result, Failure):
        values = ("failed", np.nan, 0, result.error, "")
    else:
        versions = ", ".join(f"{name} {version}" for name, version in result.versions.items())
        values = ("finished", result.wall_time, result.failed, "", versions)
    columns = ("status", "wall_time", "failed_evaluations", "error", "versions")
    return {"algorithm": key[0], "seed": key[1], **dict(zip(columns, values, strict=True))}


def _labeled(algorithms: Mapping[str, Algorithm] | Iterable[Algorithm]) -> dict[str, Algorithm]:
    if isinstance(algorithms, Mapping):
        pairs = [(str(name), algorithm) for name, algorithm in algorithms.items()]
    else:
        pairs = [(type(algorithm).__name__, algorithm) for algorithm in algorithms]
    named = dict(pairs)
    if len(named) < len(pairs):
        raise ValueError(
            f"algorithms of equal names among {', '.join(named)}: expected labels, "
            "{'label': algorithm, ...}"
        )
    if not named:
        raise ValueError("algorithms is empty: expected at least one")
    for name, algorithm in named.items():
        if isinstance(algorithm, str) or not hasattr(algorithm, "setup"):
            raise TypeError(f"algorithms[{name!r}] = {algorithm!r}: expected a pymoo Algorithm")
    return named


def seed_numbers(seeds: int | Iterable[int]) -> tuple[int, ...]:
    """The seeds that are meant: so many from 1, or those listed.

    Raises
    ------
    TypeError, ValueError
        If they are no integers, none, or not different.
    """
    if not isinstance(seeds, Iterable):
        return tuple(range(1, validate_integer("seeds", seeds, low=1, high=MOST) + 1))
    listed = [validate_integer(f"seeds[{i}]", seed, low=0) for i, seed in enumerate(seeds)]
    if not listed or len(set(listed)) < len(listed):
        raise ValueError(f"seeds = {listed}: expected one or more different ones")
    return tuple(listed)


def _grid(grid: int | Sequence[int], n_eval: int) -> list[int]:
    if not isinstance(grid, Iterable):
        steps = validate_integer("grid", grid, low=1)
        return sorted({max(1, round(n_eval * i / steps)) for i in range(1, steps + 1)})
    listed = {validate_integer(f"grid[{i}]", step, low=1) for i, step in enumerate(grid)} | {n_eval}
    if max(listed) > n_eval:
        raise ValueError(f"grid goes to {max(listed)}: expected at most n_eval = {n_eval}")
    return sorted(listed)


def run_files(folder: Path, tasks: Mapping[Key, Task]) -> dict[Key, Path]:
    """The file of each run, without those whose problem or algorithm cannot be identified.

    A file is there whole or not at all, so a comparison can be killed at any time and go on from
    what is there; several may share a folder. Nothing is ever deleted.

    Warns
    -----
    NotReusedWarning
        Once for each problem or algorithm that cannot be identified, and if the folder holds runs
        of a version of mgeo with other fingerprints.
    """
    messages = []
    prints: dict[int, str] = {}
    parts = {id(part): part for task in tasks.values() for part in (task.problem, task.algorithm)}
    for part in parts.values():
        try:
            prints[id(part)] = fingerprint(part)
        except UncertainError as error:
            name = type(part).__name__
            messages.append(
                f"{error}: nobody knows whether a run of {name} is the one asked for, so such runs "
                f"are made, but neither kept nor found again; vouch by an attribute fingerprint of "
                f"{name}, a text that says what it computes"
            )
    found = {}
    for key, task in tasks.items():
        if id(task.problem) in prints and id(task.algorithm) in prints:
            name = type(task.algorithm).__name__
            both = prints[id(task.problem)], prints[id(task.algorithm)]
            run = fingerprint(*both, task.n_eval)
            found[key] = folder / f"{name}-{run}-seed{task.seed}.npz"
    if old := sum(_OLD.search(path.name) is not None for path in folder.glob("*.npz")):
        messages.append(f"{folder} holds runs of an earlier mgeo ({old}): they are not used")
    for message in messages:
        warnings.warn(message, NotReusedWarning, stacklevel=4)  # where `compare` was called
    return found
