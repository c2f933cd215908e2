"""What a search has found, refined by the problem's own means: the last stage of a run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mgeo._typing import FloatArray
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.variables import designs_of
from mgeo.evaluation.evaluator import EvaluationError, TolerantEvaluator
from mgeo.evaluation.individuals import as_numbers, individuals, succeeded
from mgeo.plugins.discovery import PluginError
from mgeo.plugins.protocol import refinement

if TYPE_CHECKING:
    from pymoo.core.population import Population
    from pymoo.core.problem import Problem


class Refinement:
    """Takes what a problem gives in the place of the solutions of a front, if it is as good.

    That is, if it is feasible and in no objective worse; else the solution stays as it is. Nothing
    is random: of the same front it is the same.

    Parameters
    ----------
    front : evaluated individuals that keep all constraints.

    Attributes
    ----------
    solutions : of the front, each of them or what has taken its place.
    changed : (n,) mask of the places that were taken.
    error : why it has come to no end, empty if it has or is under way.
    """

    def __init__(self, problem: Problem, front: Population) -> None:
        self.solutions = front.copy()
        self.changed = np.zeros(len(front), dtype=np.bool_)
        self.error = ""
        self._problem = problem
        # not that of the search, whose budget this is no part of
        self._evaluator = TolerantEvaluator(warn=False)

    def __iter__(self) -> Iterator[Population]:
        """What was evaluated, after each step."""
        if not len(self.solutions):
            return
        last = as_numbers(self._problem, self.solutions.get("X")).astype(float)
        try:
            with closing(refinement(self._problem, last)) as tables:
                for table in tables:
                    rows = np.flatnonzero((table != last).any(axis=1))
                    last = table
                    if len(rows):
                        yield self._take(rows, table[rows])
        except (PluginError, EvaluationError) as error:
            self.error = str(error)

    @property
    def front(self) -> Population:
        """Those of the solutions that none of the others is better than."""
        archive = ParetoArchive(self._problem.n_obj)
        archive.add(self._objectives(self.solutions), self.solutions)
        return archive.individuals

    def _take(self, rows: NDArray[np.intp], X: FloatArray) -> Population:
        tried = individuals(designs_of(self._problem, X))
        self._evaluator.eval(self._problem, tried)
        before, after = map(self._objectives, (self.solutions[rows], tried))
        good = tried.get("feas").astype(bool) & succeeded(tried) & (after <= before).all(axis=1)
        self.solutions[rows[good]] = tried[good]
        self.changed[rows[good]] = True
        return tried

    def _objectives(self, solutions: Population) -> FloatArray:
        F: FloatArray = solutions.get("F").astype(float).reshape(-1, self._problem.n_obj)
        return F
