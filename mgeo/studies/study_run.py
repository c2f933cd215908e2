"""Record of one run of a study, from which its front after any evaluation count is computed."""

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
    """Finished run of a study.

    Attributes
    ----------
    evaluation_numbers : (k,) evaluation numbers of the points in `F`, counted from 1, ascending.
    F : (k, n_obj) objectives of the feasible points that no earlier batch weakly dominates; every
        front of the run is a subset.
    front_rows : (n,) rows of `F` that form the front after `n_eval` evaluations.
    X : (n, n_var) variables of the front; (n, 0) if the variables are not numbers.
    n_eval : budget of evaluations.
    n_evaluations : number of evaluations made; the last generation may exceed `n_eval`.
    n_failed : number of failures among the first `n_eval` evaluations.
    wall_time : duration of the run [s].
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
        """Yield the front after each evaluation count in `grid`, shape (n, n_obj) each.

        Parameters
        ----------
        grid : ascending evaluation counts, at most `n_eval`.
        """
        front, start = self.F[:0], 0
        for end in np.searchsorted(self.evaluation_numbers, grid, side="right"):
            both = np.concatenate([front, self.F[start:end]])
            front, start = both[find_nondominated(both)], end
            yield front

    def write(self, path: Path) -> None:
        """Write the run as a compressed NumPy archive; equal runs give equal bytes."""
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **vars(self))
        write_file(path, buffer.getvalue())

    @classmethod
    def read(cls, path: Path) -> StudyRun:
        """Read an archive of `write`; nothing is unpickled.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ValueError
            If the file is not the record of a run.
        """
        try:
            arrays: dict[str, Any] = decode_npz(path.read_bytes())
            return cls(**{name: a if a.ndim else a.item() for name, a in arrays.items()})
        except (ValueError, TypeError) as error:
            raise ValueError(
                f"{path}: not the record of a run: {error}; delete it to repeat the run"
            ) from error
