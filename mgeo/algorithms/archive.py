"""The set of the best points found: exact, in a fixed order, cheap to extend, or truncated."""

import heapq

import numpy as np
from numpy.typing import NDArray
from pymoo.core.population import Population

from mgeo._typing import BoolArray, FloatArray
from mgeo.evaluation.dominance import (
    find_nondominated,
    find_not_weakly_dominated,
    find_weakly_dominated_rows,
)

_N_NEIGHBORS = 8  # looked up at once, the point itself among them; at least 3


def truncate(F: FloatArray, size: int) -> BoolArray:
    """Keep `size` rows of a front, removing the most crowded one at a time.

    The most crowded is the row that has its nearest neighbor at the smallest distance, and of the
    two rows that have so, the one whose second neighbor is nearer: the truncation of SPEA2
    (Zitzler, Laumanns & Thiele 2001), which looks at two neighbors here. Distances are Euclidean
    in objectives scaled to the front's range. The first rows that are least and greatest in an
    objective are never removed; of equally crowded rows, the first goes. Nothing is random.

    Neighbors come from a k-d tree, which is built again whenever too many of those that were
    looked up are gone. To choose 500 of 50,000 rows takes about 0.6 s with two or three
    objectives, 1 s with five and 5 s with eight; to remove 300 of 50,000, at most a third of it.

    Parameters
    ----------
    F : (n, n_obj) mutually nondominated finite vectors.
    size : number of rows to keep, at least 2 n_obj.

    Returns
    -------
    (n,) mask with min(n, size) rows selected.
    """
    kept = np.ones(len(F), dtype=np.bool_)
    if len(F) <= size:
        return kept
    halves = F / 2.0  # whose differences cannot overflow
    span = np.ptp(halves, axis=0)
    points = (halves - halves.min(axis=0)) / np.where(span > 0, span, 1.0)
    free = np.ones(len(F), dtype=np.bool_)
    free[[*F.argmin(axis=0), *F.argmax(axis=0)]] = False
    while surplus := int(np.count_nonzero(kept)) - size:
        rows = np.flatnonzero(kept)
        kept[rows[_find_most_crowded(points[rows], free[rows], surplus)]] = False
    return kept


def _find_most_crowded(points: FloatArray, is_removable: BoolArray, count: int) -> list[int]:
    """The first of the `count` free rows to remove: at least one, all if their neighbors suffice.

    Distances to the nearest rows that remain only grow. So a row that was the most crowded one
    some time ago is so still, unless a neighbor of its own is gone: only then they are updated.
    """
    from scipy.spatial import KDTree  # takes longer to import than all of mgeo

    near, neighbors = KDTree(points).query(points, min(_N_NEIGHBORS, len(points)))
    remains = [True] * len(points)
    rows = np.flatnonzero(is_removable)
    # a row is its own first neighbor, or one that coincides with it is
    heap = list(zip(near[rows, 1].tolist(), near[rows, 2].tolist(), rows.tolist(), strict=True))
    heapq.heapify(heap)
    gone: list[int] = []
    while len(gone) < count:
        row = heap[0][2]
        pairs = zip(near[row].tolist(), neighbors[row].tolist(), strict=True)
        distances = [d for d, other in pairs if remains[other] and other != row][:2]
        known = len(distances) == 2
        farthest = float(near[row, -1])  # no neighbor that was not looked up is nearer
        first, second = distances if known else [*distances, farthest, farthest][:2]
        if (first, second) != heap[0][:2]:
            heapq.heapreplace(heap, (first, second, row))
        elif known:
            heapq.heappop(heap)
            remains[row] = False
            gone.append(row)
        else:
            break
    return gone


class ParetoArchive:
    """Mutually nondominated points, every objective minimized.

    - Of equal objective vectors the first one found is kept.
    - A point with a NaN or an infinity among its objectives, or a NaN violation, is rejected.
    - Until a feasible point is found the archive holds those of the least violation seen (the
      nondominated among them, if several share it); from then on feasible points only.
    - Points stand in ascending order of the first objective, and where that is equal (possible
      with three objectives or more) in the order in which they were found.
    - With `max_size`, each batch is followed by `truncate`. The first and last point of each
      objective stay; what was removed may return, so the set is no longer exact.

    Parameters
    ----------
    n_obj : number of objectives. With one, the archive is the best point.
    max_size : largest number of points to keep, at least 2 n_obj; None for no limit.

    Attributes
    ----------
    F : (n, n_obj) objective vectors.
    individuals : (n,) the objects they belong to, a pymoo `Population`.
    violation : constraint violation that all points share; 0 if feasible, inf while empty.
    n_rejected : how many points were rejected as not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo import ParetoArchive
    >>> archive = ParetoArchive(n_obj=2)
    >>> points = np.array([[1.0, 3.0], [2.0, 2.0], [3.0, 2.5]])
    >>> archive.add(points, np.array(["a", "b", "c"], dtype=object))
    array([ True,  True, False])
    >>> archive.F
    array([[1., 3.],
           [2., 2.]])
    """

    def __init__(self, n_obj: int, max_size: int | None = None) -> None:
        if n_obj < 1:
            raise ValueError(f"n_obj = {n_obj}: expected at least 1 objective")
        if max_size is not None and max_size < 2 * n_obj:
            raise ValueError(
                f"max_size = {max_size}: expected at least {2 * n_obj}, the extremes of "
                f"{n_obj} objectives, or None"
            )
        self.max_size = max_size
        self.F: FloatArray = np.empty((0, n_obj))
        self.individuals: Population = np.empty(0, dtype=object).view(Population)
        self.violation = np.inf
        self.n_rejected = 0
        self._ideal_and_nadir: tuple[FloatArray, FloatArray] | None = None

    @property
    def ideal_and_nadir(self) -> tuple[FloatArray, FloatArray]:
        """(n_obj,) least and largest objectives of the points; 0 and 1 while there are none."""
        if self._ideal_and_nadir is None:
            columns = self.F.T  # numpy is slow at reducing a long array along its first axis
            self._ideal_and_nadir = (
                (np.array([f.min() for f in columns]), np.array([f.max() for f in columns]))
                if len(self.F)
                else (np.zeros(len(columns)), np.ones(len(columns)))
            )
        return self._ideal_and_nadir

    def __len__(self) -> int:
        return len(self.F)

    def add(
        self, F: FloatArray, individuals: NDArray[np.object_], violation: FloatArray | None = None
    ) -> BoolArray:
        """Update the archive with a batch.

        Parameters
        ----------
        F : (k, n_obj) objective vectors.
        individuals : (k,) the objects to keep with them.
        violation : (k,) constraint violations, 0 where feasible; None if all are.

        Returns
        -------
        (k,) mask of the points that entered (before truncation).

        Raises
        ------
        ValueError : if the shapes do not agree.
        """
        F = np.asarray(F, dtype=float)
        violation = np.zeros(len(F)) if violation is None else np.asarray(violation, dtype=float)
        self._check_shapes(F, individuals, violation)
        entered = np.isfinite(F).all(axis=1) & ~np.isnan(violation)
        self.n_rejected += len(F) - int(np.count_nonzero(entered))
        if not entered.any():
            return entered
        least = violation[entered].min()
        if least > self.violation:
            return np.zeros(len(F), dtype=np.bool_)
        if least < self.violation:
            self.violation = float(least)
            self._select_rows(np.empty(0, dtype=np.intp))
        entered &= violation == least
        entered[entered] = find_nondominated(F[entered])
        entered[entered] = find_not_weakly_dominated(F[entered], self.F)
        if entered.any():
            self._insert(F[entered], individuals[entered])
        return entered

    def _insert(self, F: FloatArray, individuals: NDArray[np.object_]) -> None:
        order = np.argsort(F[:, 0], kind="stable")
        F, individuals = F[order], individuals[order]
        kept = np.delete(np.arange(len(self.F)), find_weakly_dominated_rows(self.F, F))
        places = np.searchsorted(self.F[kept, 0], F[:, 0], side="right")
        rows = np.insert(kept, places, len(self.F) + np.arange(len(F)))
        self.F = np.concatenate([self.F, F])
        self.individuals = np.concatenate([self.individuals, individuals])
        self._select_rows(rows)
        if self.max_size is not None and len(self.F) > self.max_size:
            self._select_rows(np.flatnonzero(truncate(self.F, self.max_size)))

    def _select_rows(self, rows: NDArray[np.intp]) -> None:
        self.F = self.F.take(rows, axis=0)
        self.individuals = self.individuals.take(rows).view(Population)
        self._ideal_and_nadir = None

    def _check_shapes(
        self, F: FloatArray, individuals: NDArray[np.object_], violation: FloatArray
    ) -> None:
        if F.ndim != 2 or F.shape[1] != self.F.shape[1]:
            raise ValueError(f"F of shape {F.shape}: expected (k, {self.F.shape[1]})")
        for name, array in (("individuals", individuals), ("violation", violation)):
            if np.shape(array) != (len(F),):
                raise ValueError(f"{name} of shape {np.shape(array)}: expected ({len(F)},)")
