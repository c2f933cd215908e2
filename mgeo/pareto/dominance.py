"""Pareto dominance on arrays: every objective is minimized.

A vector dominates another when it is nowhere larger and somewhere smaller. It *covers* another
when it is nowhere larger, so that equal vectors cover each other.
"""

import numpy as np
from moocore import is_nondominated
from numpy.typing import NDArray

from mgeo._typing import BoolArray, FloatArray

_BLOCK = 1 << 18  # comparisons at once: a block of booleans that stays in a core's cache
_SAMPLE, _LONG = 16, 4096  # of a front longer than this, each 16th row is compared first


def nondominated(F: FloatArray) -> BoolArray:
    """Rows of `F` that no other row dominates; of equal rows, the first.

    Parameters
    ----------
    F : (n, n_obj) objective vectors. Rows with a NaN or an infinity are never selected, and
        never dominate another row.

    Returns
    -------
    (n,) mask. The cost is O(n log n) up to three objectives (Kung, Luccio & Preparata 1975, as
    implemented by moocore).
    """
    selected: BoolArray = np.all(np.isfinite(F), axis=1)
    selected[selected] = is_nondominated(F[selected], keep_weakly=False)
    return selected


def uncovered(F: FloatArray, front: FloatArray) -> BoolArray:
    """Rows of `F` that no row of `front` covers.

    Parameters
    ----------
    F : (n, n_obj) finite objective vectors.
    front : (m, n_obj) mutually nondominated, distinct vectors, ascending in the first objective.

    Returns
    -------
    (n,) mask. With two objectives the second descends along the front, so a binary search finds
    the only row that needs comparing, O(n log m). Otherwise all n x m pairs are compared, but for
    rows that a sample of a long front covers: during a search these are most.
    """
    if F.shape[1] == 2 and len(front):
        not_right = np.searchsorted(front[:, 0], F[:, 0], side="right")
        free: BoolArray = (front[:, 1].take(not_right - 1) > F[:, 1]) | (not_right == 0)
        return free
    if len(front) <= _LONG:
        return ~_covered(_rows(F), _rows(front))
    free = ~_covered(_rows(F), _rows(front[::_SAMPLE]))
    free[free] = ~_covered(_rows(F[free]), _rows(front))
    return free


def covered_rows(front: FloatArray, F: FloatArray) -> NDArray[np.intp]:
    """Rows of `front` that a row of `F` covers.

    Parameters
    ----------
    front : (m, n_obj) mutually nondominated, distinct vectors, ascending in the first objective.
    F : (n, n_obj) finite objective vectors.

    Returns
    -------
    (k,) ascending. With two objectives they are runs of the front, whose ends binary search
    finds, O(n log m).
    """
    if F.shape[1] != 2:
        return np.flatnonzero(~uncovered(front, F))
    first = np.searchsorted(front[:, 0], F[:, 0], side="left")
    last = len(front) - np.searchsorted(front[::-1, 1], F[:, 1], side="left")
    runs = [np.arange(begin, end) for begin, end in zip(first, last, strict=True) if begin < end]
    return np.unique(np.concatenate(runs)) if runs else np.empty(0, dtype=np.intp)


def _rows(F: FloatArray) -> FloatArray:
    return np.ascontiguousarray(F.T)


def _covered(F: FloatArray, front: FloatArray) -> BoolArray:
    # Objectives are rows here. The longer set runs along the inner axis, where numpy is fast.
    n, m = F.shape[1], front.shape[1]
    covered = np.zeros(n, dtype=np.bool_)
    if n < m:
        step = max(1, _BLOCK // m)
        for i in range(0, n, step):
            pairs = _all_below(front[:, None, :], F[:, i : i + step, None])
            covered[i : i + step] = pairs.any(axis=1)
    else:
        step = max(1, _BLOCK // max(1, n))
        for i in range(0, m, step):
            covered |= _all_below(front[:, i : i + step, None], F[:, None, :]).any(axis=0)
    return covered


def _all_below(a: FloatArray, b: FloatArray) -> BoolArray:
    below: BoolArray = a[0] <= b[0]
    for objective in range(1, len(a)):
        below &= a[objective] <= b[objective]
    return below
