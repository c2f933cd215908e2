"""Pareto dominance on arrays: every objective is minimized.

A vector dominates another when it is nowhere larger and somewhere smaller. It *covers* another
when it is nowhere larger, so that equal vectors cover each other.
"""

import numpy as np
from moocore import is_nondominated
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_BLOCK = 1 << 20  # comparisons at once: a block of booleans that stays in a core's cache


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
    the only row that needs comparing, O(n log m); otherwise all n x m pairs are compared.
    """
    if len(front) == 0:
        return np.ones(len(F), dtype=np.bool_)
    if F.shape[1] == 2:
        not_right = np.searchsorted(front[:, 0], F[:, 0], side="right")
        free: BoolArray = (front[not_right - 1, 1] > F[:, 1]) | (not_right == 0)
        return free
    columns = np.ascontiguousarray(front.T)
    rows = max(1, _BLOCK // len(front))
    blocks = [_covered(F[i : i + rows], columns) for i in range(0, len(F), rows)]
    return ~np.concatenate(blocks, dtype=np.bool_) if blocks else np.ones(0, dtype=np.bool_)


def _covered(F: FloatArray, columns: FloatArray) -> BoolArray:
    covers = columns[0] <= F[:, :1]
    for objective in range(1, len(columns)):
        covers &= columns[objective] <= F[:, objective, None]
    covered: BoolArray = np.any(covers, axis=1)
    return covered
