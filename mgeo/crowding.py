"""Thinning of a front: which points to give up when only so many may be kept."""

import numpy as np

from mgeo.dominance import BoolArray, FloatArray


def thin(F: FloatArray, size: int) -> BoolArray:
    """Keep `size` rows of a front, giving up the most crowded one at a time.

    A point's room is the distance between its two neighbors in each objective, as a fraction of
    the front's range there, summed over the objectives: the crowding distance of Deb et al.
    (2002), brought up to date after every removal. The first and the last point of each
    objective have infinite room and are never given up; of points with equal room, the first
    row goes. Nothing is random.

    Parameters
    ----------
    F : (n, n_obj) mutually nondominated finite vectors.
    size : number of rows to keep, at least 2 n_obj.

    Returns
    -------
    (n,) mask with min(n, size) rows selected.
    """
    n, n_obj = F.shape
    kept = np.ones(n, dtype=np.bool_)
    if n <= size:
        return kept
    span = np.ptp(F, axis=0)
    scaled = F / np.where(span > 0, span, 1.0)
    # Rows n and n + 1 stand below the first and above the last point of every objective.
    scaled = np.vstack([scaled, np.full(n_obj, -np.inf), np.full(n_obj, np.inf)])
    order = np.argsort(F, axis=0, kind="stable")
    objectives = np.arange(n_obj)
    below, above = np.full((n, n_obj), n), np.full((n, n_obj), n + 1)
    below[order[1:], objectives] = order[:-1]
    above[order[:-1], objectives] = order[1:]
    room = (scaled[above, objectives] - scaled[below, objectives]).sum(axis=1)
    for _ in range(n - size):
        row = int(room.argmin())
        kept[row] = False
        room[row] = np.inf
        low, high = below[row], above[row]  # real points: the row is first or last in nothing
        above[low, objectives] = high
        below[high, objectives] = low
        near = np.concatenate([low, high])
        gaps = scaled[above[near], objectives] - scaled[below[near], objectives]
        room[near] = gaps.sum(axis=1)
    return kept
