"""Refinement of the front by the problem: the last stage of a run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pymoo.core.population import Population

from mgeo._typing import FloatArray
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.variables import designs_of
from mgeo.evaluation.evaluator import EvaluationError, TolerantEvaluator
from mgeo.evaluation.individuals import as_numbers, individuals, succeeded
from mgeo.plugins.discovery import PluginError
from mgeo.plugins.protocol import refinement

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


class Refinement:
    """Refinement of a front by the problem's method ``refine``.

    A refined design replaces a solution of the front if it is feasible and no objective is worse.
    Further designs are added if they are feasible. The refinement is deterministic.

    Parameters
    ----------
    front : evaluated individuals that satisfy all constraints.

    Attributes
    ----------
    solutions : the solutions of the front or their replacements, then those added.
    changed : (n,) mask of the solutions of the front that were replaced.
    error : why the refinement ended early, empty if it did not.
    """

    def __init__(self, problem: Problem, front: Population) -> None:
        self.solutions = front.copy()
        self.changed = np.zeros(len(front), dtype=np.bool_)
        self.error = ""
        self._problem = problem
        # the refinement is not part of the budget of the search
        self._evaluator = TolerantEvaluator(warn=False)
        # row of each solution in the tables of the problem
        self._row = np.arange(len(front))

    def __iter__(self) -> Iterator[Population]:
        """Yield the evaluated designs after each step."""
        if not len(self.solutions):
            return
        last = as_numbers(self._problem, self.solutions.get("X")).astype(float)
        try:
            with closing(refinement(self._problem, last)) as tables:
                for table in tables:
                    new = np.full((len(table) - len(last), last.shape[1]), np.nan)
                    rows = np.flatnonzero((table != np.vstack([last, new])).any(axis=1))
                    last = table
                    if len(rows):
                        yield self._take(rows, table[rows])
        except (PluginError, EvaluationError) as error:
            self.error = str(error)

    @property
    def added(self) -> int:
        """Number of solutions added to those of the front."""
        return len(self.solutions) - len(self.changed)

    @property
    def front(self) -> Population:
        """Nondominated solutions."""
        archive = ParetoArchive(self._problem.n_obj)
        archive.add(self._objectives(self.solutions), self.solutions)
        return archive.individuals

    def _take(self, rows: NDArray[np.intp], X: FloatArray) -> Population:
        tried = individuals(designs_of(self._problem, X))
        self._evaluator.eval(self._problem, tried)
        good = tried.get("feas").astype(bool) & succeeded(tried)
        known = np.isin(rows, self._row)
        at = np.searchsorted(self._row, rows[known])
        before, after = map(self._objectives, (self.solutions[at], tried[known]))
        better = good[known] & (after <= before).all(axis=1)
        self.solutions[at[better]] = tried[known][better]
        self.changed[at[better & (at < len(self.changed))]] = True
        new = good & ~known
        order = np.argsort(np.append(self._row, rows[new]), kind="stable")
        self._row = np.append(self._row, rows[new])[order]
        self.solutions = Population.merge(self.solutions, tried[new])[order]
        return tried

    def _objectives(self, solutions: Population) -> FloatArray:
        F: FloatArray = solutions.get("F").astype(float).reshape(-1, self._problem.n_obj)
        return F
