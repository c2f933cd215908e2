"""How long a run will take, from a little of it."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.algorithms.staged import MGEOStaged
from mgeo.evaluation.individuals import as_numbers
from mgeo.plugins.protocol import refinement, refinement_steps
from mgeo.runs.solve import set_up


@dataclass(frozen=True)
class RunTime:
    """Times in seconds: elapsed, and of the processors (more, where several work).

    They were measured on `timed` evaluations. Of the elapsed time `polish` is that of a
    refinement, None where its problem does not say how long it will be.
    """

    elapsed: float
    processor: float
    timed: int
    polish: float | None = 0.0


def estimate(
    problem: Problem, algorithm: Algorithm, evaluations: int, seed: int, polish: bool = False
) -> RunTime:
    """Make two generations of a run, and think of the second as typical.

    The first, in which much is done for the first time, counts once. Of a staged search the second
    one's candidates tell what a later stage takes. Of a `polish` the first step is made, with what
    was found, and all are as long as the problem says. Whatever the run makes is forgotten.
    It raises as `mgeo.runs.solve.set_up`.
    """
    run = set_up(problem, algorithm, evaluations, seed)
    total = _time(run.next)
    first = run.evaluator.n_eval
    second = _time(run.next) if run.has_next() else total
    made = run.evaluator.n_eval
    ends = [*run.stages, 1.0] if isinstance(run, MGEOStaged) and not run.is_precise else [1.0]
    left = max(0.0, ends[0] * evaluations - first)
    total = total + left * second / max(1, made - first)
    for stage, (begin, end) in enumerate(pairwise(ends), 1):
        run.state.stage = stage
        judged = len(run.front) + (end - begin) * evaluations  # the front anew as it begins
        total = total + judged * _time_of_a_design(run)
    refined = _time_of_polish(problem, run.pop.get("X")) if polish else np.zeros(2)
    elapsed, processor = (total + (0.0 if refined is None else refined)).tolist()
    return RunTime(elapsed, processor, made, None if refined is None else float(refined[0]))


def _time_of_polish(problem: Problem, X: FloatArray) -> FloatArray | None:
    designs = as_numbers(problem, X).astype(float)
    steps = refinement_steps(problem, designs)
    if not steps:
        return None
    with closing(refinement(problem, designs)) as tables:
        return steps * _time(lambda: next(tables, None))


def _time_of_a_design(run: Algorithm) -> FloatArray:
    problem, X = run.problem, run.pop.get("X")
    problem.evaluate(X[:1], algorithm=run)  # much is done for the first time
    return _time(lambda: problem.evaluate(X, algorithm=run)) / len(X)


def _time(work: Callable[[], object]) -> FloatArray:
    """Elapsed time, and that of the processors."""
    start = _clocks()
    work()
    return np.subtract(_clocks(), start)


def _clocks() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()
