"""What a run evaluates, watched from outside: the same for every pymoo algorithm."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pymoo.core.evaluator import Evaluator
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo.pareto.archive import ParetoArchive
from mgeo.pareto.dominance import not_weakly_dominated
from mgeo.studies.record import Record


class EvaluationLog:
    """Keeps evaluations that no earlier batch weakly dominates: all that a front can be made of.

    Infeasible solutions, those that failed (see `mgeo.TolerantEvaluator`) and those with a value
    that is not finite count as evaluations and are otherwise left out, as is whatever comes after
    the first `n_eval`. So memory is bounded by
    n_eval solutions; it is usually a small part of that.

    Parameters
    ----------
    n_obj : number of objectives.
    n_eval : how many evaluations to look at.

    Attributes
    ----------
    seen : evaluations so far, beyond `n_eval` too.
    failed : how many of the first `n_eval` failed.
    """

    def __init__(self, n_obj: int, n_eval: int) -> None:
        self.n_eval = n_eval
        self.seen = 0
        self.failed = 0
        self._archive = ParetoArchive(n_obj)
        self._rows = 0
        self._numbers: list[Any] = []
        self._F: list[Any] = [np.empty((0, n_obj))]
        self._X: list[Any] = []

    def __call__(self, population: Population) -> None:
        """Take a batch that has just been evaluated, in the order of evaluation."""
        F = population.get("F").astype(float)
        numbers = np.arange(self.seen + 1, self.seen + 1 + len(F))
        self.seen += len(F)
        failed = np.array([mark is True for mark in population.get("failed")], dtype=np.bool_)
        self.failed += int(np.count_nonzero(failed & (numbers <= self.n_eval)))
        kept = population.get("feas") & np.isfinite(F).all(axis=1) & (numbers <= self.n_eval)
        kept &= ~failed
        kept[kept] = not_weakly_dominated(F[kept], self._archive.F)
        n = int(np.count_nonzero(kept))
        if not n:
            return
        rows = np.arange(self._rows, self._rows + n).astype(object)
        self._archive.add(F[kept], rows)
        self._rows += n
        self._numbers.append(numbers[kept])
        self._F.append(F[kept])
        self._X.append(np.array(population[kept].get("X")))

    def record(self, wall_time: float) -> Record:
        """All of it; `wall_time` in seconds goes with it."""
        rows = np.array(self._archive.individuals, dtype=np.int64)
        return Record(
            numbers=np.concatenate([np.empty(0, dtype=np.int64), *self._numbers]),
            F=np.concatenate(self._F),
            front=rows,
            X=_numeric(self._X, rows),
            n_eval=self.n_eval,
            evaluations=self.seen,
            failed=self.failed,
            wall_time=wall_time,
        )


class WatchedEvaluator(Evaluator):
    """Another evaluator, with a look at each batch of solutions it really evaluates."""

    def __init__(self, inner: Evaluator, watch: Callable[[Population], object]) -> None:
        super().__init__(inner.skip_already_evaluated, inner.evaluate_values_of, inner.callback)
        self._inner = inner
        self._watch = watch

    def _eval(self, problem: Problem, pop: Population, values: Any, **kwargs: Any) -> None:
        self._inner._eval(problem, pop, values, **kwargs)
        self._watch(pop)


def _numeric(X: list[Any], rows: Any) -> Any:
    """(n, n_var) floats of the rows asked for; no columns if the variables are not numbers."""
    if not X or X[0].ndim != 2 or X[0].dtype == object:
        return np.empty((len(rows), 0))
    return np.concatenate(X)[rows].astype(float)
