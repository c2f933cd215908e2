"""Selection of the infeasible solutions of a run that are nearest to feasibility."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pymoo.core.population import Population

from mgeo.algorithms.staged import MGEOStaged
from mgeo.evaluation.dominance import find_nondominated
from mgeo.evaluation.individuals import convert_designs_to_numbers, find_successful
from mgeo.plugins.view import compute_violations
from mgeo.store.run import NearestSolutions

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm

#: Maximum number of solutions that are reported.
MAX_SOLUTIONS = 10


def select_nearest_solutions(algorithm: Algorithm) -> NearestSolutions:
    """Return the infeasible solutions that are closest to feasibility, closest first.

    Candidates are the optimum and the last population of the algorithm. Solutions with nondominated
    constraint violations come first, sorted by their total violation. Solutions with equal
    objectives and violations are included once. At most `MAX_SOLUTIONS` are returned.
    """
    problem, candidates = algorithm.problem, algorithm.opt
    if not isinstance(algorithm, MGEOStaged):  # Its population may have low-fidelity values.
        candidates = Population.merge(candidates, algorithm.pop)
    if candidates is None or not len(candidates):
        return NearestSolutions.empty()
    candidates = candidates[find_successful(candidates)]
    if not len(candidates):
        return NearestSolutions.empty()
    X = convert_designs_to_numbers(problem, candidates.get("X")).astype(float)
    F = candidates.get("F").astype(float)
    violation = np.maximum(compute_violations(*candidates.get("G", "H")), 0.0)
    values = np.hstack([F, violation])
    rows = np.sort(np.unique(values, axis=0, return_index=True)[1])
    order = np.lexsort([violation[rows].sum(axis=1), ~find_nondominated(violation[rows])])
    rows = rows[order[:MAX_SOLUTIONS]]
    return NearestSolutions(X[rows], F[rows], violation[rows])
