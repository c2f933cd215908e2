"""An algorithm made ready for a run."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.runs.operators import fitted, with_suggested
from mgeo.runs.pymoo_algorithms import seed_archives

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

#: Steps without an evaluation, after which an algorithm has no new candidate.
IDLE_STEPS = 100


def set_up(
    problem: Problem, algorithm: Algorithm, evaluations: int, seed: int, starts: int = 0
) -> Algorithm:
    """A copy of `algorithm`, ready for its first step; nothing is evaluated yet.

    It begins with so many of the designs that the problem suggests as `starts` says.

    Raises
    ------
    ValueError
        If `evaluations` or `seed` is out of range, or the algorithm refuses the problem, or the
        designs.
    """
    if evaluations < 1:
        raise ValueError(f"evaluations = {evaluations}: expected >= 1")
    if seed < 0:
        raise ValueError(f"seed = {seed}: expected >= 0")
    ready = fitted(algorithm, problem)
    ready = copy.deepcopy(with_suggested(ready, starts) if starts else ready)
    ready.evaluator = TolerantEvaluator.like(ready.evaluator)
    ready.evaluator.warn = False  # the outcome tells
    ready.setup(problem, termination=("n_eval", evaluations), seed=seed)
    seed_archives(ready)
    return ready
