"""How long a run will take, told by its beginning."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mgeo.runs.solve import set_up

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem


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

    The first of all, in which much is done for the first time, counts once. Whatever the run
    makes is forgotten.

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
    left = max(0, evaluations - made) / max(1, made - first)
    elapsed, processor = (
        end - start + left * (end - second) for start, second, end in zip(*clocks, strict=True)
    )
    return Estimate(elapsed, processor, made)


def _clocks() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()
