"""What a search has found, refined by the problem's own means: the last stage of a run."""

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
    """Takes what a problem gives in the place of the solutions of a front, if it is as good.

    That is, if it is feasible and in no objective worse; else the solution stays as it is. What it
    gives beyond these is taken if it is feasible. Nothing is random: of the same front it is the
    same.

    Parameters
    ----------
    front : evaluated individuals that keep all constraints.

    Attributes
    ----------
    solutions : of the front, each of them or what has taken its place; then those added.
    changed : (n,) mask of the places of the front that were taken.
    error : why it has come to no end, empty if it has or is under way.
    """

    def __init__(self, problem: Problem, front: Population) -> None:
        self.solutions = front.copy()
        self.changed = np.zeros(len(front), dtype=np.bool_)
        self.error = ""
        self._problem = problem
        # not that of the search, whose budget this is no part of
        self._evaluator = TolerantEvaluator(warn=False)
        # row of the tables that each solution is from
        self._row = np.arange(len(front))

    def __iter__(self) -> Iterator[Population]:
        """What was evaluated, after each step."""
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
        """How many were taken beyond those of the front."""
        return len(self.solutions) - len(self.changed)

    @property
    def front(self) -> Population:
        """Those of the solutions that none of the others is better than."""
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
