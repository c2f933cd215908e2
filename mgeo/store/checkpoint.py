"""Runs that go on after a crash: checkpoints while they run, and `resume`.

A checkpoint is one file, written whole or not at all and read without unpickling: a first line
with the number of the format and the SHA-256 of the rest, then an .npz archive of the arrays and,
as its entry ``json``, of everything else.
"""

from __future__ import annotations

import hashlib
import json
import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.callback import Callback, CallbackCollection
from pymoo.core.problem import Problem

from mgeo import algorithms
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.state import SavedState, capture, full_name, restore
from mgeo.evaluation.evaluator import changed_value
from mgeo.store.atomic import remove_leftovers, to_npz, write_file
from mgeo.store.provenance import as_written_now, difference, identity, versions
from mgeo.store.reading import from_npz, parse_json, read_file
from mgeo.store.recorder import Recorder
from mgeo.validation.arguments import validate_integer, validate_number
from mgeo.validation.entries import entry, errors_of

FORMAT = 3
_MAGIC = b"mgeo checkpoint"
_MAX_SHARE = 0.02  # of the time of a run may go into checkpoints by the clock


class Checkpoint(Callback):
    """Callback that saves the state of a run of the MGEO family in a file, for `resume`.

    The first and the last generation are always saved, and in between whatever is due first. Where
    a new checkpoint cannot be written, the one before stays, a RuntimeWarning tells it once and
    the run goes on. A `Recorder` of the same run (in a pymoo `CallbackCollection`) is brought up to
    date before each checkpoint.

    Parameters
    ----------
    path : file to write; its folder must exist.
    every_seconds : time between two checkpoints, None for no limit. It is stretched where
        checkpoints would take more than 2 % of the time.
    every_generations : generations between two checkpoints, None for no limit.
    notes : called for each checkpoint; JSON values to save with it, see `read_notes`.
    warn : whether to warn when a checkpoint cannot be written.

    Attributes
    ----------
    error : why the latest checkpoint could not be written, None if it was.
    generation : the last one that is saved, None while there is none.

    Raises
    ------
    FileNotFoundError : if the folder does not exist.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import Checkpoint, MGEOReal
    >>> save = Checkpoint("run.checkpoint")
    >>> result = minimize(ZDT1(n_var=4), MGEOReal(0.1), ("n_gen", 5), seed=1, callback=save)
    >>> save.generation
    5
    """

    def __init__(
        self,
        path: Path | str,
        *,
        every_seconds: float | None = 5.0,
        every_generations: int | None = None,
        notes: Callable[[], Mapping[str, Any]] = dict,
        warn: bool = True,
    ) -> None:
        super().__init__()
        self.path = Path(path)
        if not self.path.parent.is_dir():
            raise FileNotFoundError(f"{self.path.parent} is no folder to write a checkpoint into")
        self.every_seconds = self.every_generations = math.inf
        if every_seconds is not None:
            self.every_seconds = validate_number("every_seconds", every_seconds, low=0)
        if every_generations is not None:
            self.every_generations = validate_integer("every_generations", every_generations, low=1)
        self.notes = notes
        self.warn = warn
        self.error: OSError | None = None
        self._start_time: float | None = None  # of the run that is saved
        self._next_time = -math.inf
        self.generation: int | None = None
        remove_leftovers(self.path)

    def _update(self, algorithm: Any) -> None:
        # pymoo calls `update` alone within a CallbackCollection, and last of all elsewhere
        for recorder in _recorders(algorithm.callback):
            recorder.take(algorithm)
        if self._due(algorithm) or algorithm.termination.has_terminated():
            self.write(algorithm)

    def write(self, algorithm: ExtremalOptimization) -> None:
        """Write a checkpoint now, unless this generation has one already.

        Raises
        ------
        ValueError, TypeError : if the algorithm has no state to keep, see
            `mgeo.algorithms.state.capture`.
        """
        same_run = algorithm.start_time == self._start_time
        if same_run and self.error is None and algorithm.n_generations == self.generation:
            return
        began = time.monotonic()
        saved = content(algorithm, self.notes())
        try:
            for recorder in _recorders(algorithm.callback):
                recorder.flush()
            write_file(self.path, saved)
        except OSError as error:
            if self.warn and self.error is None:
                warnings.warn(
                    f"no checkpoint was written: {error}; the run goes on",
                    RuntimeWarning,
                    stacklevel=2,
                )
            self.error = error
        else:
            self.error = None
            self.generation = algorithm.n_generations
            self._start_time = algorithm.start_time
        now = time.monotonic()
        self._next_time = now + max(self.every_seconds, (now - began) / _MAX_SHARE)

    def _due(self, algorithm: ExtremalOptimization) -> bool:
        if algorithm.start_time != self._start_time:
            return True
        since = algorithm.n_generations - (self.generation or 0)
        return bool(since >= self.every_generations) or time.monotonic() >= self._next_time


def resume(
    path: Path | str,
    problem: Problem,
    termination: Any = None,
    *,
    algorithm: Algorithm | None = None,
    check: bool = True,
    **options: Any,
) -> ExtremalOptimization:
    """The algorithm of a checkpoint, ready to go on exactly as the run would have.

    Parameters
    ----------
    path : file that a `Checkpoint` wrote.
    problem : the problem of that run.
    termination : a new one, counted from the beginning of the run, in any form that pymoo
        takes; None for the one the run had.
    algorithm : the one of that run, made again: of the same class, with the same parameters. mgeo's
        own may be left out.
    check : whether up to three points of the archive are evaluated again and compared, so that
        the run does not go on with a problem that computes something else; False for a problem
        whose values are random. These evaluations are not counted, and the run is the same with
        and without them.
    options : as for pymoo's `setup`: ``callback`` (to go on with checkpoints), ``verbose``, ...

    Warns
    -----
    RuntimeWarning : if mgeo, pymoo or NumPy has another version than the run had.

    Returns
    -------
    The algorithm: call ``run()`` for its result, or go on by ``next`` or ask and tell.

    Raises
    ------
    FileNotFoundError : if there is no such file.
    ValueError : if it is no whole checkpoint of this version, of this problem, which is told by
        its class, sizes, bounds, options and values, and of this algorithm; or the termination
        cannot be saved in a file and no new one is given, or the new one is none.
    TypeError : for an option that `setup` does not take.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import Checkpoint, MGEOReal, resume
    >>> save, problem = Checkpoint("run.checkpoint"), ZDT1(n_var=4)
    >>> _ = minimize(problem, MGEOReal(0.1), ("n_gen", 5), seed=1, callback=save)
    >>> longer = resume("run.checkpoint", problem, ("n_gen", 10)).run()
    >>> at_once = minimize(problem, MGEOReal(0.1), ("n_gen", 10), seed=1)
    >>> bool((longer.F == at_once.F).all())
    True
    """
    state, data = _read(path)
    own = identity(problem)
    found = difference(data["problem"], own)
    if found and (found := difference(as_written_now(data["problem"], problem), own)):
        raise ValueError(f"{path} belongs to another problem: {found}")
    if changed := difference(data["versions"], versions()):
        warnings.warn(
            f"{path} was written with another version ({changed}); the run goes on, but perhaps "
            "not exactly as it would have",
            RuntimeWarning,
            stacklevel=2,
        )
    if algorithm is None:
        with errors_of(path):
            algorithm = _of_mgeo(state)
    run = restore(state, problem, algorithm, termination=termination, **options)
    if check:
        found = changed_value(run.problem, run.front.individuals, {"algorithm": run})
        if found:
            raise ValueError(
                f"{path} belongs to another problem: {found}; one whose values are random is "
                "resumed without this check (check=False, --no-check)"
            )
    return run


def read_notes(path: Path | str) -> Mapping[str, Any]:
    """The notes in a checkpoint.

    Raises
    ------
    FileNotFoundError, ValueError : as `resume`, of which it reads no more than it needs.
    """
    notes: Mapping[str, Any] = _read(path)[1]["notes"]
    return notes


def _of_mgeo(state: SavedState) -> ExtremalOptimization:
    """The algorithm of a run, if that is one of mgeo's own; nothing is imported for it."""
    name = entry(state.data, "class", str)
    found = [getattr(algorithms, each) for each in dir(algorithms)]
    for cls in (each for each in found if isinstance(each, type)):
        if issubclass(cls, ExtremalOptimization) and full_name(cls) == name:
            algorithm: ExtremalOptimization = cls(**entry(state.data, "parameters", dict))
            return algorithm
    raise ValueError(f"class = {name!r:.80} is none of mgeo's own: expected algorithm=... of it")


def content(algorithm: ExtremalOptimization, notes: Mapping[str, Any]) -> bytes:
    """What a checkpoint holds of a run as it is now, see `Checkpoint.write`."""
    state = capture(algorithm)
    data = {
        "versions": versions(),
        "problem": identity(algorithm.problem),
        "notes": dict(notes),
        "state": dict(state.data),
    }
    text = np.frombuffer(json.dumps(data, allow_nan=False).encode(), dtype=np.uint8)
    body = to_npz({"json": text, **state.arrays})
    return _MAGIC + f" {FORMAT} {hashlib.sha256(body).hexdigest()}\n".encode() + body


def _read(path: Path | str) -> tuple[SavedState, dict[str, Any]]:
    """The state, and ``problem``, ``notes`` and ``versions``; nothing in the file is executed."""
    head, _, body = read_file(path).partition(b"\n")
    words = head.removeprefix(_MAGIC).split()
    if not head.startswith(_MAGIC) or len(words) != 2:
        raise ValueError(f"{path} is no checkpoint of mgeo, or its beginning is damaged")
    if words[0] != str(FORMAT).encode():
        raise ValueError(
            f"{path} has format {words[0].decode(errors='replace'):.40}: this version of mgeo "
            f"reads format {FORMAT}"
        )
    if hashlib.sha256(body).hexdigest().encode() != words[1]:
        raise ValueError(f"{path} is damaged: it is cut short, or its content was changed")
    with errors_of(path):
        arrays = from_npz(body)
        if "json" not in arrays:
            raise ValueError("json is missing")
        data = parse_json(arrays.pop("json").tobytes().decode("utf-8"))
        for key in ("state", "problem", "notes"):
            entry(data, key, dict)
        entry(data, "versions", dict[str, str])
        return SavedState(arrays, data.pop("state"), path), data


def _recorders(callback: Any) -> Iterator[Recorder]:
    if isinstance(callback, Recorder):
        yield callback
    elif isinstance(callback, CallbackCollection):
        for each in callback.callbacks:
            yield from _recorders(each)
