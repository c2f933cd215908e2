"""What is kept of one run: enough for its front after any number of evaluations."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mgeo._typing import FloatArray
from mgeo.evaluation.dominance import nondominated
from mgeo.store.atomic import write_file
from mgeo.store.reading import from_npz, parse_json, read_file
from mgeo.validation.entries import entry

_ARRAYS = {  # kinds of entries, and dimensions
    "numbers": ("iu", 1),
    "F": ("f", 2),
    "front": ("iu", 1),
    "X": ("f", 2),
    "n_eval": ("iu", 0),
    "evaluations": ("iu", 0),
    "failed": ("iu", 0),
    "wall_time": ("f", 0),
    "versions": ("u", 1),  # JSON
}


@dataclass(frozen=True, eq=False)
class StudyRun:
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
    versions : of what it was made with, by name, where it was made.
    """

    numbers: NDArray[np.int64]
    F: FloatArray
    front: NDArray[np.int64]
    X: FloatArray
    n_eval: int
    evaluations: int
    failed: int
    wall_time: float
    versions: Mapping[str, str] = field(default_factory=dict)

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

    def write(self, path: Path) -> None:
        """As a compressed NumPy archive without pickles; equal records give equal bytes."""
        buffer = io.BytesIO()
        text = np.frombuffer(json.dumps(dict(self.versions)).encode(), dtype=np.uint8)
        np.savez_compressed(buffer, **{**vars(self), "versions": text})
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, buffer.getvalue())

    @classmethod
    def read(cls, path: Path) -> StudyRun:
        """What `write` wrote; nothing is unpickled.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ValueError
            If it is something else.
        """
        content = read_file(path)
        try:
            return cls(**_checked(from_npz(content)))
        except (ValueError, TypeError) as error:
            raise ValueError(
                f"{path}: not the record of a run: {error}; delete it to make the run again"
            ) from error


def _checked(data: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """The attributes of a record, from arrays that anybody may have written."""
    values: dict[str, Any] = {}
    for name, (kinds, ndim) in _ARRAYS.items():
        if name not in data:
            raise ValueError(f"{name} is missing")
        array = data[name]
        if array.dtype.kind not in kinds or array.ndim != ndim:
            raise ValueError(f"{name} is an array {array.shape} of {array.dtype}")
        values[name] = array if ndim else array.item()
    numbers, F, front, n_eval = (values[name] for name in ("numbers", "F", "front", "n_eval"))
    texts = {"versions": parse_json(values["versions"].tobytes().decode("utf-8"))}
    values["versions"] = entry(texts, "versions", dict[str, str])
    for expected, kept in {
        "one of numbers for each row of F": len(numbers) == len(F),
        "one row of X for each of front": len(values["X"]) == len(front),
        "finite numbers": np.isfinite(F).all() and np.isfinite(values["X"]).all(),
        "front within F": np.isin(front, np.arange(len(F))).all(),
        "numbers ascending from 1 to n_eval": (np.diff([1, *numbers, n_eval]) >= 0).all(),
        "counts": values["evaluations"] >= n_eval >= max(1, values["failed"]) >= 0
        and 0.0 <= values["wall_time"] < math.inf,
    }.items():
        if not kept:
            raise ValueError(f"expected {expected}")
    return values
