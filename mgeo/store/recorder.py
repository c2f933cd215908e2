"""Record of every evaluation of a run, in .npz files that are readable while the run continues."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.callback import Callback
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.evaluation.individuals import convert_designs_to_numbers, find_successful
from mgeo.plugins.protocol import get_column_names
from mgeo.store.atomic import encode_npz, write_file
from mgeo.store.readers import decode_npz
from mgeo.validation.arguments import validate_number
from mgeo.validation.entries import FileError, convert_file_errors

if TYPE_CHECKING:
    import pandas as pd


class Recorder(Callback):
    """Callback that records every evaluated candidate of a run in files for `read_record`.

    The recorder replaces pymoo's ``save_history``, which keeps a copy of the algorithm in memory
    for each generation. It supports algorithms that evaluate all candidates of a generation as
    offspring.

    If a run is resumed (see `mgeo.resume`) with a recorder on the same folder, the rows after the
    checkpoint are replaced by those of the resumed run.

    Parameters
    ----------
    folder : path
        Folder to write into, created if it does not exist.
    every_seconds : float
        Minimum time between two writes [s]. Rows are buffered in memory until then.
    overwrite : bool
        Whether a new run may replace a record in the folder.

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
        overwrite: bool = False,
    ) -> None:
        super().__init__()
        self.folder = Path(folder)
        self.every_seconds = validate_number("every_seconds", every_seconds, low=0)
        self.overwrite = overwrite
        self._columns: list[str] = []
        self._buffer: list[FloatArray] = []  # Rows of generations that are not written yet.
        self._start_time: float | None = None  # Identifies the recorded run.
        self._generation = 0
        self._n_eval = 0
        self._next_time = 0.0

    def _update(self, algorithm: Any) -> None:
        self.record(algorithm)

    def record(self, algorithm: Any) -> None:
        """Record the evaluations of the last generation of an algorithm.

        A generation that is already recorded is ignored.

        Raises
        ------
        ValueError
            If the folder contains the record of another run, or the algorithm evaluated candidates
            that are not among its offspring.
        OSError
            If a file cannot be written.
        """
        generation = int(algorithm.n_iter)
        is_same_run = algorithm.start_time == self._start_time
        if is_same_run and generation == self._generation:
            return
        candidates = algorithm.pop if algorithm.off is None else algorithm.off
        n_new = algorithm.evaluator.n_eval - self._n_eval
        if not is_same_run:
            self._start_record(algorithm.problem, generation)
        elif n_new > np.size(candidates):  # The offspring may be a single individual.
            raise ValueError(
                f"{type(algorithm).__name__} made {n_new} evaluations in generation "
                f"{generation} and has {np.size(candidates)} offspring: "
                "expected all evaluated candidates among the offspring"
            )
        self._buffer.append(_build_rows(algorithm.problem, candidates, generation))
        self._start_time = algorithm.start_time
        self._generation, self._n_eval = generation, algorithm.evaluator.n_eval
        if time.monotonic() >= self._next_time or algorithm.termination.has_terminated():
            self.flush()

    def flush(self) -> None:
        """Write all buffered evaluations to a new file of the record.

        The file is named by the number of its first generation.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        if not self._buffer:
            return
        rows = np.concatenate(self._buffer)
        self.folder.mkdir(parents=True, exist_ok=True)
        content = encode_npz({"columns": np.array(self._columns), "rows": rows})
        write_file(self.folder / f"{int(rows[0, 0]):09d}.npz", content)
        self._buffer = []
        self._next_time = time.monotonic() + self.every_seconds

    def _start_record(self, problem: Problem, generation: int) -> None:
        self._buffer, self._next_time = [], 0.0
        variables, objectives = get_column_names(problem)
        G = (f"g{j + 1}" for j in range(problem.n_ieq_constr))
        H = (f"h{j + 1}" for j in range(problem.n_eq_constr))
        self._columns = ["generation", *variables, *objectives, *G, *H, "failed"]
        if generation > 1:
            _truncate_record(self.folder, self._columns, generation)
        elif not self.overwrite and _list_files(self.folder):
            raise FileError(
                f"{self.folder} holds a record: choose another folder, or allow overwrite=True"
            )
        else:
            remove_record(self.folder)


def read_record(folder: Path | str) -> pd.DataFrame:
    """Read the recorded evaluations of a run into a table, with one row per evaluation.

    The run may still continue. Columns are ``generation`` (from 1), each variable and objective by
    name, the constraints ``g1``, ..., ``h1``, ..., and ``failed``. Objectives of failed evaluations
    are NaN.

    Parameters
    ----------
    folder : path
        Folder of a `Recorder`.

    Returns
    -------
    DataFrame
        Evaluations in their order.

    Raises
    ------
    FileNotFoundError
        If the folder contains no record.
    ValueError
        If a file is damaged.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOReal, Recorder, read_record
    >>> record = Recorder("evaluations")
    >>> result = minimize(ZDT1(n_var=2), MGEOReal(), ("n_gen", 3), seed=1, callback=record)
    >>> read_record("evaluations").groupby("generation").size().to_list()
    [60, 60, 60]
    """
    import pandas as pd

    parts = _list_files(Path(folder))
    if not parts:
        raise FileNotFoundError(f"{folder} holds no record of evaluations")
    names, rows = _read_part(parts[0])
    rows = np.concatenate([rows, *(_read_part(path, names)[1] for path in parts[1:])])
    return pd.DataFrame(rows, columns=names).astype({"generation": int, "failed": bool})


def remove_record(folder: Path) -> None:
    """Delete the files that a `Recorder` wrote, and their folder if nothing else remains."""
    for path in _list_files(folder):
        path.unlink()
    if folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()


def _list_files(folder: Path) -> list[Path]:
    # Each file is named by its first generation, so that this order is chronological.
    return sorted(path for path in folder.glob("*.npz") if path.stem.isdecimal())


def _read_part(path: Path, columns: list[str] | None = None) -> tuple[list[str], FloatArray]:
    """Read the column names and the rows of one file of a record.

    Raises FileError if the names differ from `columns`, unless `columns` is None.
    """
    with convert_file_errors(path):
        arrays = decode_npz(path.read_bytes())
        names: list[str] = arrays.get("columns", np.empty(0)).tolist()
        rows = arrays.get("rows", np.empty(0))
        if not {"generation", "failed"} <= set(names) or rows.shape[1:] != (len(names),):
            raise ValueError(f"columns {names!r:.80} and rows of shape {rows.shape}: not a record")
        if columns not in (None, names):
            raise ValueError(f"columns {names!r:.80}: expected {columns!r:.80}")
        return names, rows


def _truncate_record(folder: Path, columns: list[str], generation: int) -> None:
    """Remove the evaluations of `generation` and of all later generations from a record.

    Rows are written before each checkpoint, so the generation after a checkpoint is always the
    first one of a file.
    """
    last = 0
    for path in _list_files(folder):
        _, rows = _read_part(path, columns)
        if int(path.stem) >= generation:
            path.unlink()
        else:
            last = int(rows[-1, 0])
    if last != generation - 1:
        raise FileError(
            f"the record in {folder} ends with generation {last}: expected the record of the "
            f"generations before {generation}"
        )


def _build_rows(problem: Problem, candidates: Population, generation: int) -> FloatArray:
    n, failed = len(candidates), ~find_successful(candidates)
    X = convert_designs_to_numbers(problem, candidates.get("X")).astype(float)
    F, G, H = (candidates.get(key).astype(float).reshape(n, -1) for key in "FGH")
    F[failed] = np.nan
    return np.column_stack([np.full(n, generation), X, F, G, H, failed])
