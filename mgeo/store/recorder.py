"""Every evaluation of a run, in files that can be read while it goes on."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.callback import Callback
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo.evaluation.individuals import as_numbers, succeeded
from mgeo.plugins.protocol import column_names
from mgeo.store import record_file
from mgeo.validation.arguments import validate_integer, validate_number
from mgeo.validation.entries import FileError

if TYPE_CHECKING:
    import pandas as pd


class Recorder(Callback):
    """Callback that writes every candidate of a run into a folder, for `read_record`.

    It takes the place of pymoo's ``save_history``, which keeps a copy of the whole algorithm per
    generation in memory: here at most `chunk_rows` rows and one generation wait to be written.
    It works with every pymoo algorithm that hands its candidates over a generation at a time.

    With the callback of a resumed run (see `mgeo.resume`) on the same folder, rows recorded after
    the checkpoint are replaced by those the resumed run makes: none is lost or doubled.

    Parameters
    ----------
    folder : where to write; made if it does not exist.
    every_seconds : time after which rows are written though they are fewer than `chunk_rows`.
    chunk_rows : rows that are written at once.
    overwrite : whether a new run may replace a record in the folder.

    Raises
    ------
    NotADirectoryError : if `folder` is a file.

    Examples
    --------
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import Recorder, read_record
    >>> record = Recorder("evaluations")
    >>> result = minimize(ZDT1(n_var=2), NSGA2(20), ("n_gen", 3), seed=1, callback=record)
    >>> read_record("evaluations").shape
    (60, 6)
    """

    def __init__(
        self,
        folder: Path | str,
        *,
        every_seconds: float = 5.0,
        chunk_rows: int = 8192,
        overwrite: bool = False,
    ) -> None:
        super().__init__()
        self.folder = Path(folder)
        if self.folder.exists() and not self.folder.is_dir():
            raise NotADirectoryError(f"{folder} is a file: expected a folder to record into")
        self.every_seconds = validate_number("every_seconds", every_seconds, low=0)
        self.chunk_rows = validate_integer("chunk_rows", chunk_rows, low=1)
        self.overwrite = overwrite
        self._buffer: list[tuple[int, record_file.Rows]] = []  # generations not yet written
        self._names: record_file.Names = {}
        self._new = False  # its file is still to be made
        self._start_time: float | None = None  # of the run that is recorded
        self._generation = 0
        self._n_eval = 0
        self._next_time = 0.0

    def _update(self, algorithm: Any) -> None:
        # pymoo calls `update` alone within a CallbackCollection, and last of all elsewhere
        self.take(algorithm)

    def take(self, algorithm: Any) -> None:
        """Record the generation that has just ended, unless it has been.

        Raises
        ------
        ValueError : if the folder holds the record of another run, or the algorithm evaluates
            more than it hands over.
        OSError : if a file cannot be written; the record is then as it was.
        """
        generation = int(algorithm.n_iter)
        same_run = algorithm.start_time == self._start_time
        if same_run and generation == self._generation:
            return
        candidates = algorithm.pop if algorithm.off is None else algorithm.off
        if isinstance(candidates, Individual):
            candidates = Population.create(candidates)
        if not same_run:
            self._open(algorithm.problem, generation)
        elif algorithm.evaluator.n_eval - self._n_eval > len(candidates):
            raise ValueError(
                f"{type(algorithm).__name__} made {algorithm.evaluator.n_eval - self._n_eval} "
                f"evaluations in generation {generation} and hands over {len(candidates)}: a "
                "Recorder expects all of them"
            )
        self._buffer.append((generation, _rows(self._names, algorithm.problem, candidates)))
        self._start_time = algorithm.start_time
        self._generation, self._n_eval = generation, algorithm.evaluator.n_eval
        due = sum(len(rows) for _, rows in self._buffer) >= self.chunk_rows
        if due or time.monotonic() >= self._next_time or algorithm.termination.has_terminated():
            self.flush()

    def flush(self) -> None:
        """Write what waits to be written.

        Raises
        ------
        OSError : if a file cannot be written; the record is then as it was.
        """
        if self._buffer:
            if self._new:
                record_file.create(self.folder, self._names)
                self._new = False
            record_file.append(self.folder, self._buffer)
            self._buffer = []
            self._next_time = time.monotonic() + self.every_seconds

    def _open(self, problem: Problem, generation: int) -> None:
        variables, objectives = column_names(problem)
        self._names = {
            "X": list(variables),
            "F": list(objectives),
            "G": [f"g{j + 1}" for j in range(problem.n_ieq_constr)],
            "H": [f"h{j + 1}" for j in range(problem.n_eq_constr)],
        }
        self._buffer, self._next_time = [], 0.0
        self._new = generation == 1
        if not self._new:
            record_file.cut(self.folder, self._names, generation)
        elif not self.overwrite and (self.folder / record_file.NAME).exists():
            raise FileError(
                f"{self.folder} holds a record of {len(read_record(self.folder))} evaluations: "
                "choose another folder, or overwrite=True"
            )


def read_record(folder: Path | str, columns: Sequence[str] | None = None) -> pd.DataFrame:
    """A record as a table: one row per evaluation, in order; also while the run goes on.

    Parameters
    ----------
    folder : what a `Recorder` wrote.
    columns : which ones to read, None for all: ``generation`` (from 1), each variable and each
        objective by its name, the constraints ``g1``, ..., ``h1``, ..., and ``failed``. The
        objectives of a failed evaluation are NaN.

    Raises
    ------
    FileNotFoundError : if there is no record.
    ValueError : if the record is damaged, or has no such column.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOReal, Recorder, read_record
    >>> record = Recorder("evaluations")
    >>> result = minimize(ZDT1(n_var=2), MGEOReal(), ("n_gen", 3), seed=1, callback=record)
    >>> read_record("evaluations", ["generation", "f1"]).groupby("generation").size().to_list()
    [60, 60, 60]
    """
    import pandas as pd

    names, generations = record_file.read(Path(folder))
    rows = np.concatenate(generations or [np.empty(0, record_file.row_type(names))])
    numbers = np.arange(len(generations)) + 1
    values = {"generation": np.repeat(numbers, [len(each) for each in generations])}
    for key in names:
        values |= {name: rows[key][:, j] for j, name in enumerate(names[key])}
    values["failed"] = rows["failed"]
    if columns is not None:
        unknown = [name for name in columns if name not in values]
        if unknown:
            raise ValueError(
                f"{folder} has no column {unknown[0]!r}: expected one of {', '.join(values)}"
            )
        values = {name: values[name] for name in columns}
    return pd.DataFrame(values)


def _rows(names: record_file.Names, problem: Problem, candidates: Population) -> record_file.Rows:
    X = as_numbers(problem, candidates.get("X"))
    rows = np.empty(len(X), record_file.row_type(names, X.dtype.newbyteorder("<").str))
    rows["X"] = X
    for key in "FGH":
        rows[key] = candidates.get(key).reshape(rows[key].shape)
    rows["failed"] = ~succeeded(candidates)
    rows["F"][rows["failed"]] = np.nan
    return rows
