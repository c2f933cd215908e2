"""Stored run of a study, from which its front after any evaluation count is computed."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mgeo._typing import FloatArray
from mgeo.evaluation.dominance import find_nondominated
from mgeo.store.atomic import write_file
from mgeo.store.readers import decode_npz


@dataclass(frozen=True, eq=False)
class StudyRun:
    """Finished run of a study, from which its front after any evaluation count can be computed.

    Attributes
    ----------
    evaluation_numbers : array of int, shape (k,)
        Evaluation numbers of the points in `F`, counted from 1, ascending.
    F : array, shape (k, n_obj)
        Objectives of the feasible points that no point of an earlier batch weakly dominates. Every
        front of the run is a subset.
    front_rows : array of int, shape (n,)
        Rows of `F` that form the front after `n_eval` evaluations.
    X : array, shape (n, n_var)
        Variables of the front after `n_eval` evaluations; shape (n, 0) if they are not numeric.
    n_eval : int
        Budget of evaluations.
    n_evaluations : int
        Number of evaluations made. The last generation may exceed `n_eval`.
    n_failed : int
        Number of failures among the first `n_eval` evaluations.
    wall_time : float
        Duration of the run [s].
    """

    evaluation_numbers: NDArray[np.int64]
    F: FloatArray
    front_rows: NDArray[np.int64]
    X: FloatArray
    n_eval: int
    n_evaluations: int
    n_failed: int
    wall_time: float

    @property
    def front_F(self) -> FloatArray:
        """Objectives of the front after `n_eval` evaluations, shape (n, n_obj)."""
        return self.F[self.front_rows]

    def iterate_fronts(self, grid: Sequence[int]) -> Iterator[FloatArray]:
        """Yield the objectives of the front after each evaluation count in `grid`.

        Parameters
        ----------
        grid : sequence of int
            Ascending evaluation counts, at most `n_eval`.

        Yields
        ------
        array, shape (n, n_obj)
            Objectives of the nondominated feasible points.
        """
        front, start = self.F[:0], 0
        for end in np.searchsorted(self.evaluation_numbers, grid, side="right"):
            both = np.concatenate([front, self.F[start:end]])
            front, start = both[find_nondominated(both)], end
            yield front

    def write(self, path: Path) -> None:
        """Write the run to a compressed NumPy archive.

        Equal runs give equal bytes.
        """
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **vars(self))
        write_file(path, buffer.getvalue())

    @classmethod
    def read(cls, path: Path) -> StudyRun:
        """Read a run from an archive created by `write`.

        Raises
        ------
        FileNotFoundError
            If there is no file at `path`.
        ValueError
            If the file does not contain a run.
        """
        try:
            arrays: dict[str, Any] = decode_npz(path.read_bytes())
            return cls(**{name: a if a.ndim else a.item() for name, a in arrays.items()})
        except (ValueError, TypeError) as error:
            raise ValueError(
                f"{path}: not a stored run: {error}; delete the file to repeat the run"
            ) from error
