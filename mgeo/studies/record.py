"""What is kept of one run: enough for its front after any number of evaluations."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mgeo.dominance import FloatArray, nondominated
from mgeo.files import from_npz

_INTEGERS = ("n_eval", "evaluations", "failed")


@dataclass(frozen=True, eq=False)
class Record:
    """One finished run.

    Attributes
    ----------
    numbers : (k,) at which evaluation, counted from 1, each point of `F` was found; ascending.
    F : (k, n_obj) every feasible point that was on the front of all evaluations at some time.
    front : (n,) rows of `F` that are the front after `n_eval` evaluations.
    X : (n, n_var) solutions of that front; (n, 0) if the variables are no numbers.
    n_eval : the evaluations that count.
    evaluations : how many were made; a last generation may go beyond `n_eval`.
    failed : how many of the first `n_eval` failed.
    wall_time : duration of the run [s].
    """

    numbers: NDArray[np.int64]
    F: FloatArray
    front: NDArray[np.int64]
    X: FloatArray
    n_eval: int
    evaluations: int
    failed: int
    wall_time: float

    @property
    def front_F(self) -> FloatArray:
        """(n, n_obj) the front after `n_eval` evaluations, ascending in the first objective."""
        return self.F[self.front]

    def fronts(self, grid: Sequence[int]) -> Iterator[FloatArray]:
        """The nondominated set of all evaluations after each number of them.

        Parameters
        ----------
        grid : ascending numbers of evaluations, at most `n_eval`.
        """
        front, start = self.F[:0], 0
        for end in np.searchsorted(self.numbers, grid, side="right"):
            both = np.concatenate([front, self.F[start:end]])
            front, start = both[nondominated(both)], end
            yield front

    def to_bytes(self) -> bytes:
        """As a compressed NumPy archive without pickles; equal records give equal bytes."""
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **vars(self))
        return buffer.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes) -> Record:
        """What `to_bytes` wrote; nothing is unpickled.

        Raises
        ------
        ValueError
            If it is something else.
        """
        try:
            data = from_npz(content)
            values: dict[str, Any] = {name: data[name] for name in cls.__dataclass_fields__}
        except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile) as error:
            raise ValueError(f"not the record of a run: {error}") from error
        for name in _INTEGERS:
            values[name] = int(values[name])
        return cls(**{**values, "wall_time": float(values["wall_time"])})
