"""Local refinement of the front by the problem, after the search."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pymoo.core.individual import Individual
from pymoo.core.population import Population

from mgeo._typing import FloatArray
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.variables import convert_numbers_to_designs
from mgeo.evaluation.evaluator import EvaluationError, TolerantEvaluator
from mgeo.evaluation.individuals import (
    build_population,
    convert_designs_to_numbers,
    find_successful,
)
from mgeo.plugins.discovery import PluginError
from mgeo.plugins.protocol import iterate_refinement

if TYPE_CHECKING:
    from pymoo.core.problem import Problem


class Refinement:
    """Local refinement of a front by its problem. Iterating performs one step at a time.

    A refined design replaces a solution of the front if it is feasible and no objective is worse.
    Further designs are added if they are feasible. The refinement is deterministic.

    Parameters
    ----------
    problem : Problem
        Problem of the front.
    front : Population
        Evaluated individuals that satisfy all constraints.

    Attributes
    ----------
    is_replaced : array of bool, shape (n,)
        Mask of the solutions of the front that were replaced.
    error : str
        Reason for an early end, otherwise empty.
    """

    def __init__(self, problem: Problem, front: Population) -> None:
        self.is_replaced = np.zeros(len(front), dtype=np.bool_)
        self.error = ""
        self._problem = problem
        # The refinement is not part of the evaluation budget of the search.
        self._evaluator = TolerantEvaluator(warn=False)
        self._solutions: dict[int, Individual] = dict(enumerate(front))  # Keyed by row of X.

    def __iter__(self) -> Iterator[Population]:
        """Refine the front step by step, and yield the designs evaluated in each step."""
        if not self._solutions:
            return
        previous = convert_designs_to_numbers(self._problem, self.solutions.get("X")).astype(float)
        try:
            with closing(iterate_refinement(self._problem, previous)) as steps:
                for X in steps:
                    added = np.full((len(X) - len(previous), previous.shape[1]), np.nan)
                    rows = np.flatnonzero((np.vstack([previous, added]) != X).any(axis=1))
                    previous = X
                    if len(rows):
                        yield self._evaluate_and_replace(rows, X[rows])
        except (PluginError, EvaluationError) as error:
            self.error = str(error)

    @property
    def solutions(self) -> Population:
        """Solutions of the original front, improved where possible, followed by added solutions."""
        return Population.create(*(self._solutions[row] for row in sorted(self._solutions)))

    @property
    def n_added(self) -> int:
        return len(self._solutions) - len(self.is_replaced)

    @property
    def front(self) -> Population:
        """Nondominated solutions after the refinement."""
        archive, solutions = ParetoArchive(self._problem.n_obj), self.solutions
        archive.add(solutions.get("F").astype(float), solutions)
        return archive.individuals

    def _evaluate_and_replace(self, rows: NDArray[np.intp], X: FloatArray) -> Population:
        designs = build_population(convert_numbers_to_designs(self._problem, X))
        self._evaluator.eval(self._problem, designs)
        is_feasible = designs.get("feas").astype(bool) & find_successful(designs)
        accepted = zip(rows[is_feasible].tolist(), designs[is_feasible], strict=True)
        for row, solution in accepted:
            before = self._solutions.get(row)
            if before is None or (solution.F <= before.F).all():
                self._solutions[row] = solution
                if row < len(self.is_replaced):
                    self.is_replaced[row] = True
        return designs
