"""Checkpoints of runs of the MGEO family, and their continuation by `resume`.

A checkpoint is an .npz archive with the arrays of the algorithm's state. The entry ``json``
contains all other data as text, so that no objects are unpickled.
"""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.callback import Callback
from pymoo.core.problem import Problem

from mgeo import algorithms
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.state import SavedState, capture, get_qualified_name, restore
from mgeo.evaluation.evaluator import describe_changed_value
from mgeo.store.atomic import encode_npz, write_file
from mgeo.store.provenance import describe_difference, identify_problem, list_versions
from mgeo.store.readers import decode_npz, parse_json
from mgeo.store.recorder import Recorder
from mgeo.validation.arguments import validate_number
from mgeo.validation.entries import convert_file_errors, get_entry


class Checkpoint(Callback):
    """Callback that saves the state of an MGEO run at intervals, so that `resume` can continue it.

    The first and the last generation are always saved, and generations between them at intervals of
    `every_seconds`. If a checkpoint cannot be written, the previous checkpoint stays, a
    RuntimeWarning is issued, and the run continues. The warning is issued again only after a
    successful checkpoint. A `Recorder` of the same run (in a pymoo `CallbackCollection`) is flushed
    before each checkpoint.

    Parameters
    ----------
    path : path
        File to write; its folder must exist.
    every_seconds : float
        Minimum time between two checkpoints [s], counted from the latest attempt; 0 saves every
        generation. Until the first checkpoint of a run is written, every generation is an attempt.
    build_metadata : function
        Returns further JSON values to save, see `read_checkpoint_metadata`.
    warn : bool
        Whether to warn if a checkpoint cannot be written.

    Attributes
    ----------
    error : OSError or None
        Error of the latest attempt to write a checkpoint, None if it succeeded.
    generation : int or None
        Number of the last saved generation, None before the first.

    Raises
    ------
    FileNotFoundError
        If the folder does not exist.
    ValueError, TypeError
        If `every_seconds` is not a finite number of at least 0.

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
        every_seconds: float = 5.0,
        build_metadata: Callable[[], Mapping[str, Any]] = dict,
        warn: bool = True,
    ) -> None:
        super().__init__()
        self.path = Path(path)
        if not self.path.parent.is_dir():
            raise FileNotFoundError(
                f"{self.path.parent} is not a folder: create it to save checkpoints"
            )
        self.every_seconds = validate_number("every_seconds", every_seconds, low=0)
        self.build_metadata = build_metadata
        self.warn = warn
        self.error: OSError | None = None
        self.generation: int | None = None
        self._start_time: float | None = None  # Identifies the saved run.
        self._next_time = 0.0

    def _update(self, algorithm: Any) -> None:
        is_other_run = algorithm.start_time != self._start_time
        is_due = is_other_run or time.monotonic() >= self._next_time
        if is_due or algorithm.termination.has_terminated():
            self.write(algorithm)

    def write(self, algorithm: ExtremalOptimization) -> None:
        """Write the current state of an algorithm into the checkpoint file.

        A `Recorder` of the run first records the current generation and is flushed.

        An OSError is caught: it is stored in the attribute `error`, the previous checkpoint stays,
        and a RuntimeWarning is issued unless `warn` is False or the previous attempt also failed.

        Raises
        ------
        ValueError, TypeError
            If the state of the algorithm cannot be saved, see `mgeo.algorithms.state.capture`; if
            the metadata are not JSON values; or if the recorder rejects the run.
        """
        content = _encode_state(algorithm, self.build_metadata())
        callbacks = getattr(algorithm.callback, "callbacks", [algorithm.callback])
        try:
            for recorder in callbacks:
                if isinstance(recorder, Recorder):
                    recorder.record(algorithm)
                    recorder.flush()
            write_file(self.path, content)
        except OSError as error:
            if self.warn and self.error is None:
                warnings.warn(
                    f"checkpoint not written: {error}; the run continues",
                    RuntimeWarning,
                    stacklevel=2,
                )
            self.error = error
        else:
            self.error = None
            self.generation = algorithm.n_generations
            self._start_time = algorithm.start_time
        self._next_time = time.monotonic() + self.every_seconds


def resume(
    path: Path | str,
    problem: Problem,
    termination: Any = None,
    *,
    algorithm: Algorithm | None = None,
    check: bool = True,
    **options: Any,
) -> ExtremalOptimization:
    """Resume a run from a checkpoint, as if the run had never been interrupted.

    Parameters
    ----------
    path : path
        File of a `Checkpoint`.
    problem : Problem
        Problem of the run.
    termination : optional
        New termination criterion in any form that pymoo accepts, counted from the start of the run.
        Default: the termination criterion of the run.
    algorithm : Algorithm, optional
        Algorithm of the same class with the same parameters. Not required for algorithms of mgeo,
        which are built from the checkpoint.
    check : bool
        Whether to require equal versions of the software, and to reevaluate up to three points of
        the archive and require equal values. These evaluations are not counted. Use False for a
        problem with random values, and to continue with other versions, where results may differ.
    **options
        Keyword arguments of pymoo's `setup`, such as ``callback`` (to continue with checkpoints)
        and ``verbose``.

    Returns
    -------
    ExtremalOptimization
        Algorithm. Call ``run()`` for its result, or use ``next`` or ask and tell.

    Raises
    ------
    FileNotFoundError
        If there is no file at `path`.
    ValueError
        If the file is damaged; if the problem, algorithm, parameters or versions differ from those
        of the run (the message contains the first difference); or if the run has no saved
        termination criterion and none is given.
    TypeError
        If `setup` has no option of a given name.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import Checkpoint, MGEOReal, resume
    >>> save, problem = Checkpoint("run.checkpoint"), ZDT1(n_var=4)
    >>> _ = minimize(problem, MGEOReal(0.1), ("n_gen", 5), seed=1, callback=save)
    >>> resumed = resume("run.checkpoint", problem, ("n_gen", 10)).run()
    >>> uninterrupted = minimize(problem, MGEOReal(0.1), ("n_gen", 10), seed=1)
    >>> bool((resumed.F == uninterrupted.F).all())
    True
    """
    state, data = _read_checkpoint(path)
    if difference := describe_difference(data["problem"], identify_problem(problem)):
        raise ValueError(f"{path} belongs to another problem: {difference}")
    if check and (difference := describe_difference(data["versions"], list_versions())):
        raise ValueError(
            f"{path} was written with another version: {difference}. Install this version, or "
            "continue without this check (check=False, --no-check); results may then differ"
        )
    if algorithm is None:
        with convert_file_errors(path):
            algorithm = _build_algorithm(state)
    run = restore(state, problem, algorithm, termination=termination, **options)
    if check and (
        difference := describe_changed_value(run.problem, run.front.individuals, {"algorithm": run})
    ):
        raise ValueError(
            f"{path} belongs to another problem: {difference}. Continue a problem whose values are "
            "random without this check (check=False, --no-check)"
        )
    return run


def read_checkpoint_metadata(path: Path | str) -> Mapping[str, Any]:
    """Return the metadata that `Checkpoint` stored beside the state of the algorithm.

    The argument `build_metadata` of `Checkpoint` defines these data.

    Raises
    ------
    FileNotFoundError
        If there is no file at `path`.
    ValueError
        If the file is damaged.
    """
    metadata: Mapping[str, Any] = _read_checkpoint(path)[1]["metadata"]
    return metadata


def _build_algorithm(state: SavedState) -> ExtremalOptimization:
    """Build an algorithm from the class name and parameters in a saved state."""
    name = get_entry(state.data, "class", str)
    cls = getattr(algorithms, name.rpartition(".")[2], None)
    if not isinstance(cls, type) or get_qualified_name(cls) != name:
        raise ValueError(
            f"class = {name!r:.80} is not an algorithm of mgeo: pass the argument algorithm"
        )
    algorithm: ExtremalOptimization = cls(**get_entry(state.data, "parameters", dict))
    return algorithm


def _encode_state(algorithm: ExtremalOptimization, metadata: Mapping[str, Any]) -> bytes:
    """Encode the state of a run and its metadata as the content of a checkpoint file."""
    state = capture(algorithm)
    data = {
        "versions": list_versions(),
        "problem": identify_problem(algorithm.problem),
        "metadata": dict(metadata),
        "state": dict(state.data),
    }
    text = np.frombuffer(json.dumps(data, allow_nan=False).encode(), dtype=np.uint8)
    return encode_npz({"json": text, **state.arrays})


def _read_checkpoint(path: Path | str) -> tuple[SavedState, dict[str, Any]]:
    """Read the state of a run, the software versions and the metadata from a checkpoint file.

    All data except the state are in a dict with the keys ``versions``, ``problem`` and
    ``metadata``. A damaged file raises ValueError.
    """
    content = Path(path).read_bytes()
    with convert_file_errors(path):
        try:
            arrays = decode_npz(content)
        except ValueError as error:
            raise ValueError(f"not a checkpoint, or a damaged one: {error}") from None
        if "json" not in arrays:
            raise ValueError("not a checkpoint: json is missing")
        data = parse_json(arrays.pop("json").tobytes().decode("utf-8"))
        for key in ("state", "problem", "metadata", "versions"):
            get_entry(data, key, dict)
        return SavedState(arrays, data.pop("state"), path), data
