"""What is hardly a reading, seen before any attitude is known."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Bools, Floats

from mgeo_calibration.estimation.batch import Batch

#: Times the scatter of its sensor by which a vector is too long or too short.
_FAR = 20.0
_NORMAL = 1.4826  # 1-sigma of normal numbers over their median absolute deviation


def implausible(batch: Batch) -> Bools:
    """Vectors whose lengths stand apart from all others of their sensor, shape (s, N).

    Lengths need no attitude. A bias changes them less than they scatter, or all of them alike.
    """
    found = np.zeros((len(batch.sensors), len(batch.times)), dtype=bool)
    for index, rows in enumerate(batch.sensors):
        seen = np.isfinite(rows[:, 0, 0])
        if rows.shape[1] > 1 or not seen.any():
            continue
        off = _length(rows[seen, 0]) - _length(batch.vectors[seen, index])
        off -= np.median(off)
        scatter = max(_NORMAL * float(np.median(np.abs(off))), float(batch.noise[index].max()))
        found[index, seen] = np.abs(off) > _FAR * scatter
    return found


def _length(vectors: Floats) -> Floats:
    with np.errstate(over="ignore"):
        length: Floats = np.linalg.norm(vectors, axis=1)
    return length
