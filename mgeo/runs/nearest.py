"""What comes nearest to keeping all limits, of a run that finds nothing that does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mgeo._typing import FloatArray
from mgeo.algorithms.dominance import nondominated
from mgeo.evaluation.individuals import as_numbers, succeeded
from mgeo.runs.limits import excess

if TYPE_CHECKING:
    from pymoo.core.population import Population
    from pymoo.core.problem import Problem

MOST = 10  # solutions are remembered


@dataclass(frozen=True, eq=False)
class Nearest:
    """Solutions that violate constraints, the nearest first.

    Those come first that no other beats in every constraint, and of these the one with the least
    sum of violations. No two have the same objectives and violations.

    Attributes
    ----------
    X, F, violation : arrays, shapes (n, n_var), (n, n_obj) and (n, n_constraints)
        n is 0 for a run that found what keeps all constraints. A violation is at least 0, in what
        the constraint is computed in; inequalities first, then equalities beyond their tolerance.
    """

    X: FloatArray
    F: FloatArray
    violation: FloatArray

    @classmethod
    def none(cls) -> Nearest:
        return cls(*(np.empty((0, 0)) for _ in range(3)))

    def __len__(self) -> int:
        return len(self.X)


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
