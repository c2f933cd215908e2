"""Pareto dominance on arrays: every objective is minimized.

A vector dominates another when it is nowhere larger and somewhere smaller. It weakly dominates
another when it is nowhere larger, so that equal vectors weakly dominate each other.
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


def front_rows(F: FloatArray) -> NDArray[np.intp]:
    """Numbers of the rows that are `nondominated`, by ascending first objective."""
    rows = np.flatnonzero(nondominated(F))
    return rows[np.argsort(F[rows, 0], kind="stable")]


def not_weakly_dominated(F: FloatArray, front: FloatArray) -> BoolArray:
    """Rows of `F` that no row of `front` weakly dominates.

    Parameters
    ----------
    F : (n, n_obj) finite objective vectors.
    front : (m, n_obj) mutually nondominated, distinct vectors, ascending in the first objective.

    Returns
    -------
    (n,) mask. With two objectives the second descends along the front, so a binary search finds
    the only row that needs comparing, O(n log m). Otherwise all n x m pairs are compared, but for
    rows that a sample of a long front weakly dominates: during a search these are most.
    """
    if F.shape[1] == 2 and len(front):
        not_right = np.searchsorted(front[:, 0], F[:, 0], side="right")
        free: BoolArray = (front[:, 1].take(not_right - 1) > F[:, 1]) | (not_right == 0)
        return free
    if len(front) <= _LONG:
        return ~_weakly_dominated(F, front)
    free = ~_weakly_dominated(F, front[::_SAMPLE])
    free[free] = ~_weakly_dominated(F[free], front)
    return free


def weakly_dominated_rows(front: FloatArray, F: FloatArray) -> NDArray[np.intp]:
    """Rows of `front` that a row of `F` weakly dominates.

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
        return np.flatnonzero(~not_weakly_dominated(front, F))
    first = np.searchsorted(front[:, 0], F[:, 0], side="left")
    last = len(front) - np.searchsorted(front[::-1, 1], F[:, 1], side="left")
    runs = [np.arange(begin, end) for begin, end in zip(first, last, strict=True) if begin < end]
    return np.unique(np.concatenate(runs)) if runs else np.empty(0, dtype=np.intp)


def _weakly_dominated(F: FloatArray, front: FloatArray) -> BoolArray:
    # With objectives as rows, the longer set runs along the inner axis, where numpy is fast.
    a, b = np.ascontiguousarray(F.T), np.ascontiguousarray(front.T)
    n, m = len(F), len(front)
    found = np.zeros(n, dtype=np.bool_)
    step = max(1, _BLOCK // max(1, n, m))
    if n < m:
        for i in range(0, n, step):
            pairs = _all_below(b[:, None, :], a[:, i : i + step, None])
            found[i : i + step] = pairs.any(axis=1)
    else:
        for i in range(0, m, step):
            found |= _all_below(b[:, i : i + step, None], a[:, None, :]).any(axis=0)
    return found


def _all_below(a: FloatArray, b: FloatArray) -> BoolArray:
    below: BoolArray = a[0] <= b[0]
    for objective in range(1, len(a)):
        below &= a[objective] <= b[objective]
    return below
