"""Pareto dominance on arrays of objective vectors; all objectives are minimized.

Vector a weakly dominates vector b if a is less than or equal to b in every objective. Vector a
dominates b if, in addition, a is less than b in at least one objective.
"""

import numpy as np
from moocore import is_nondominated
from numpy.typing import NDArray

from mgeo._typing import BoolArray, FloatArray

#: Number of pairs that are compared at once. A block of booleans of this size fits into the cache.
_BLOCK_SIZE = 1 << 18
#: With a front of more rows than `_MAX_UNSAMPLED_ROWS`, a sample of every `_SAMPLING_STRIDE`-th row
#: is compared first.
_SAMPLING_STRIDE, _MAX_UNSAMPLED_ROWS = 16, 4096


def find_nondominated(F: FloatArray) -> BoolArray:
    """Return a boolean mask of the nondominated rows of an array of objectives.

    The cost is O(n log n) for up to three objectives (Kung, Luccio & Preparata 1975, as implemented
    by moocore).

    Parameters
    ----------
    F : array, shape (n, n_obj)
        Objective vectors. A row with a NaN or infinite value is never selected and never dominates
        another row.

    Returns
    -------
    array of bool, shape (n,)
        True for each finite row that no other row dominates. Among equal rows only the first is
        selected.
    """
    selected: BoolArray = np.all(np.isfinite(F), axis=1)
    selected[selected] = is_nondominated(F[selected], keep_weakly=False)
    return selected


def find_front_rows(F: FloatArray) -> NDArray[np.intp]:
    """Return the indices of the nondominated rows, sorted by the first objective."""
    rows = np.flatnonzero(find_nondominated(F))
    return rows[np.argsort(F[rows, 0], kind="stable")]


def find_not_weakly_dominated(F: FloatArray, front: FloatArray) -> BoolArray:
    """Return a boolean mask of the rows of `F` that no row of `front` weakly dominates.

    Parameters
    ----------
    F : array, shape (n, n_obj)
        Finite objective vectors.
    front : array, shape (m, n_obj)
        Finite, distinct and mutually nondominated vectors, sorted by the first objective in
        ascending order.

    Returns
    -------
    array of bool, shape (n,)

    Notes
    -----
    The cost is O(n log m) for two objectives and O(n m) for more.
    """
    # With two objectives, the second descends along the front. Only the last row of the front whose
    # first objective is not larger needs to be compared.
    if F.shape[1] == 2 and len(front):
        n_left = np.searchsorted(front[:, 0], F[:, 0], side="right")
        selected: BoolArray = (front[:, 1].take(n_left - 1) > F[:, 1]) | (n_left == 0)
        return selected
    if len(front) <= _MAX_UNSAMPLED_ROWS:
        return ~_is_weakly_dominated(F, front)
    # During a search, a sample of a long front already dominates most candidates.
    selected = ~_is_weakly_dominated(F, front[::_SAMPLING_STRIDE])
    selected[selected] = ~_is_weakly_dominated(F[selected], front)
    return selected


def find_weakly_dominated_rows(front: FloatArray, F: FloatArray) -> NDArray[np.intp]:
    """Return the indices of the rows of `front` that at least one row of `F` weakly dominates.

    Parameters
    ----------
    front : array, shape (m, n_obj)
        Finite, distinct and mutually nondominated vectors, sorted by the first objective in
        ascending order.
    F : array, shape (n, n_obj)
        Finite objective vectors.

    Returns
    -------
    array of int, shape (k,)
        Row indices in ascending order.

    Notes
    -----
    The cost is O(n log m) for two objectives and O(n m) for more.
    """
    if F.shape[1] != 2:
        return np.flatnonzero(~find_not_weakly_dominated(front, F))
    # With two objectives, each row of F dominates a contiguous section of the front.
    first = np.searchsorted(front[:, 0], F[:, 0], side="left")
    last = len(front) - np.searchsorted(front[::-1, 1], F[:, 1], side="left")
    sections = [np.arange(i, end) for i, end in zip(first, last, strict=True) if i < end]
    return np.unique(np.concatenate(sections)) if sections else np.empty(0, dtype=np.intp)


def _is_weakly_dominated(F: FloatArray, front: FloatArray) -> BoolArray:
    # The longer set lies along the inner axis of the comparison, where NumPy is fast.
    a, b = np.ascontiguousarray(F.T), np.ascontiguousarray(front.T)
    n, m = len(F), len(front)
    mask = np.zeros(n, dtype=np.bool_)
    step = max(1, _BLOCK_SIZE // max(1, n, m))
    if n < m:
        for i in range(0, n, step):
            pairs = _is_weakly_below(b[:, None, :], a[:, i : i + step, None])
            mask[i : i + step] = pairs.any(axis=1)
    else:
        for i in range(0, m, step):
            mask |= _is_weakly_below(b[:, i : i + step, None], a[:, None, :]).any(axis=0)
    return mask


def _is_weakly_below(a: FloatArray, b: FloatArray) -> BoolArray:
    below: BoolArray = a[0] <= b[0]
    for objective in range(1, len(a)):
        below &= a[objective] <= b[objective]
    return below
