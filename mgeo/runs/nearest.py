"""The solutions of a run that are nearest to feasibility."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pymoo.core.population import Population

from mgeo.algorithms.staged import MGEOStaged
from mgeo.evaluation.dominance import nondominated
from mgeo.evaluation.individuals import as_numbers, succeeded
from mgeo.plugins.view import excess
from mgeo.store.run import Nearest

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm

MOST = 10  # solutions that are reported


def nearest_solutions(algorithm: Algorithm) -> Nearest:
    """Return up to `MOST` solutions of an algorithm that has found no feasible one.

    They are taken from its optimum and its last population. Solutions whose violations no other
    solution undercuts in every constraint come first, in ascending order of the total violation.
    Of solutions with the same objectives and violations one is kept.
    """
    problem, candidates = algorithm.problem, algorithm.opt
    if not isinstance(algorithm, MGEOStaged):  # whose population may have low-fidelity values
        candidates = Population.merge(candidates, algorithm.pop)
    if candidates is None or not len(candidates):
        return Nearest.none()
    candidates = candidates[succeeded(candidates)]
    if not len(candidates):
        return Nearest.none()
    X = as_numbers(problem, candidates.get("X")).astype(float)
    F = candidates.get("F").astype(float)
    violation = np.maximum(excess(*candidates.get("G", "H")), 0.0)
    values = np.hstack([F, violation])
    rows = np.sort(np.unique(values, axis=0, return_index=True)[1])
    order = np.lexsort([violation[rows].sum(axis=1), ~nondominated(violation[rows])])
    rows = rows[order[:MOST]]
    return Nearest(X[rows], F[rows], violation[rows])
