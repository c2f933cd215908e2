"""What a run measures of all that it evaluates: hypervolume, and what is nearest to its limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pymoo.indicators.hv import HV

from mgeo.evaluation.dominance import nondominated
from mgeo.evaluation.individuals import as_numbers, succeeded
from mgeo.plugins.protocol import indicator_space
from mgeo.plugins.view import excess

if TYPE_CHECKING:
    from pymoo.core.population import Population
    from pymoo.core.problem import Problem

    from mgeo.store.run import Hypervolume, Nearest

MOST = 10  # solutions are remembered
# The exact hypervolume takes 1 ms for 300 points in 5 objectives, 40 ms in 6, a minute in 8.
MAX_OBJECTIVES = 5


class HypervolumeMeter:
    """Measures fronts of one problem; watches what a run evaluates where it needs the range."""

    def __init__(self, problem: Problem) -> None:
        self._n_obj: int = problem.n_obj
        self._indicator_space = indicator_space(problem)
        #: Least values of the objectives seen, and greatest; empty before there are any.
        self.seen: list[list[float]] = []

    def see(self, population: Population) -> None:
        """Take evaluated solutions into the range seen (the finite, feasible, not failed ones)."""
        if self._indicator_space is not None or not len(population):
            return
        F = population.get("F")[population.get("feas") & succeeded(population)]
        F = F[np.isfinite(F).all(axis=1)]
        if len(F):
            F = np.vstack([*self.seen, F])
            self.seen = [F.min(axis=0).tolist(), F.max(axis=0).tolist()]

    def __call__(self, F: ArrayLike) -> Hypervolume | None:
        """Hypervolume of a front, shape (n, n_obj).

        None where there is only one objective, or more than `MAX_OBJECTIVES`.
        """
        from mgeo.store.run import Hypervolume

        front = np.asarray(F, dtype=float)
        if not 1 < self._n_obj <= MAX_OBJECTIVES:
            return None
        if self._indicator_space is not None:
            value = _hypervolume(self._indicator_space(front)) if len(front) else 0.0
            return Hypervolume(value=value, space="problem")
        if not len(front):
            return Hypervolume(value=0.0, space="seen")
        ideal, nadir = self.seen
        value = _hypervolume(scaled(front, np.array(ideal), np.array(nadir)))
        return Hypervolume(value=value, space="seen", ideal=tuple(ideal), nadir=tuple(nadir))


def scaled(
    F: NDArray[np.float64], ideal: NDArray[np.float64], nadir: NDArray[np.float64]
) -> NDArray[np.float64]:
    """`F` with `ideal` at 0 and `nadir` at 1; an objective without extent only moves to 0."""
    extent = nadir - ideal
    return (F - ideal) / np.where(extent > 0, extent, 1.0)


def _hypervolume(points: NDArray[np.float64]) -> float:
    return float(HV(ref_point=np.ones(points.shape[1]))(points))


class NearestMeter:
    """Watches what a run evaluates until something keeps all constraints."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._searching = problem.n_ieq_constr + problem.n_eq_constr > 0
        self._sizes = problem.n_var, problem.n_var + problem.n_obj
        #: A row of X, F and violation for each solution, empty before there is any.
        self.seen: list[list[float]] = []

    @property
    def nearest(self) -> Nearest:
        """What is nearest so far."""
        from mgeo.store.run import Nearest

        if not self.seen:
            return Nearest.none()
        return Nearest(*np.hsplit(np.array(self.seen), self._sizes))

    def stop(self) -> None:
        """Forget what was seen: something keeps all constraints."""
        self._searching, self.seen = False, []

    def see(self, population: Population) -> None:
        """Take evaluated solutions into account, if none yet has kept all constraints."""
        if not self._searching or not len(population):
            return
        if (population.get("feas") & succeeded(population)).any():
            self.stop()
            return
        X = as_numbers(self._problem, population.get("X")).astype(float)
        violation = np.maximum(excess(*population.get("G", "H")), 0.0)
        rows = np.hstack([X, population.get("F").astype(float), violation])
        rows = rows[np.isfinite(rows).all(axis=1) & succeeded(population)]
        if len(rows):
            rows = np.vstack([np.reshape(self.seen, (-1, rows.shape[1])), rows])
            # such as plans that differ only in what is never flown: one of them tells it all
            told = rows[:, self._sizes[0] :]
            rows = rows[np.sort(np.unique(told, axis=0, return_index=True)[1])]
            violation = rows[:, self._sizes[1] :]
            order = np.lexsort([violation.sum(axis=1), ~nondominated(violation)])
            self.seen = rows[order[:MOST]].tolist()
