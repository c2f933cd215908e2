"""How long a run will take, told by its beginning."""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from mgeo.algorithms.staged import MGEOStaged
from mgeo.runs.solve import set_up

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

#: Designs by which a later stage is timed.
_FEW = 8


@dataclass(frozen=True)
class Estimate:
    """Times in seconds: elapsed, and of the processors (more, where several work).

    They were measured on the first `timed` of the run's evaluations.
    """

    elapsed: float
    processor: float
    timed: int


def estimate(
    problem: Problem, algorithm: Algorithm, evaluations: int, seed: int, seconds: float = 1.0
) -> Estimate:
    """Make the first generations of a run for so many `seconds`, and think of them as typical.

    The first of all, in which much is done for the first time, counts once. The later stages of a
    staged search are timed by a few designs of its front. Whatever the run makes is forgotten.

    Raises
    ------
    ValueError
        As `mgeo.runs.solve.set_up`.
    """
    ready = set_up(problem, algorithm, evaluations, seed)
    clocks = [_clocks()]
    ready.next()
    first = ready.evaluator.n_eval
    clocks += [_clocks()] * 2
    while ready.has_next() and clocks[-1][0] - clocks[1][0] < seconds:
        ready.next()
        clocks[-1] = _clocks()
    made = ready.evaluator.n_eval
    staged = isinstance(ready, MGEOStaged) and not ready.is_precise and len(ready.front)
    rest = ready.stages[0] * evaluations if staged else evaluations
    left = max(0.0, rest - made) / max(1, made - first)
    later = _later_stages(ready, evaluations) if staged else (0.0, 0.0)
    elapsed, processor = (
        end - start + left * (end - second) + more
        for start, second, end, more in zip(*clocks, later, strict=True)
    )
    return Estimate(elapsed, processor, made)


def _later_stages(run: MGEOStaged, evaluations: int) -> tuple[float, float]:
    """Times of all stages but the first, with the front judged anew as each begins."""
    X, n = run.archived_designs(), len(run.front)
    few = X[1 : 1 + _FEW] if n > 1 else X
    total = np.zeros(2)
    for stage, (begin, end) in enumerate(pairwise([*run.stages, 1.0]), 1):
        run.state.stage = stage
        run.problem.evaluate(X[:1], algorithm=run)  # much is done for the first time
        start = _clocks()
        run.problem.evaluate(few, algorithm=run)
        total += np.subtract(_clocks(), start) / len(few) * (n + (end - begin) * evaluations)
    elapsed, processor = total.tolist()
    return elapsed, processor


def _clocks() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()
