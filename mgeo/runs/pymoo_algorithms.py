"""Corrections of pymoo's algorithms: runs that repeat with their seed, results that are fronts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pymoo.algorithms.moo.rvea import RVEA
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem
from pymoo.operators.selection.tournament import compare
from pymoo.termination.max_eval import MaximumFunctionCallTermination
from pymoo.util.archive import Archive, RandomTruncation, SurvivalTruncation, Truncation
from pymoo.util.optimum import filter_optimum

if TYPE_CHECKING:
    from pymoo.core.population import Population


class SeededComparison:
    """A comparison of pairs whose ties of violation are drawn from the algorithm's generator.

    Of two solutions of which one violates constraints the less violating wins; of two feasible
    ones whichever wins by the `inner` comparison.

    Parameters
    ----------
    inner : comparison of pymoo's `TournamentSelection`.
    """

    def __init__(self, inner: Any) -> None:
        self.inner = inner

    def __call__(
        self,
        pop: Population,
        P: NDArray[np.int_],
        random_state: np.random.Generator | None = None,
        **options: Any,
    ) -> NDArray[np.int_]:
        """(n, 1) winners of the (n, 2) pairs `P`, rows of the population."""
        violation = pop.get("CV")[:, 0]
        winners = np.empty((len(P), 1), dtype=np.int_)
        for i, (a, b) in enumerate(P):
            if max(violation[a], violation[b]) > 0.0:
                winners[i] = compare(
                    a,
                    violation[a],
                    b,
                    violation[b],
                    method="smaller_is_better",
                    return_random_if_equal=True,
                    random_state=random_state,
                )
            else:
                winners[i] = self.inner(pop, P[i : i + 1], random_state=random_state, **options)
        return winners


class SeededTruncation(Truncation):
    """Another truncation, which draws from an algorithm's own generator.

    pymoo's archives call theirs without a generator; it then takes a new one from the entropy of
    the operating system, and a run does not repeat with its seed.
    """

    def __init__(self, inner: Truncation, algorithm: Algorithm) -> None:
        super().__init__()
        self._inner = inner
        self._algorithm = algorithm

    def __call__(self, sols: Any, k: int) -> Any:
        """`k` of the solutions."""
        state, inner = self._algorithm.random_state, self._inner
        if isinstance(inner, SurvivalTruncation):
            return inner.survival.do(inner.problem, sols, n_survive=k, random_state=state)
        if isinstance(inner, RandomTruncation):
            return inner(sols, k, random_state=state)
        return inner(sols, k)


def seed_archives(algorithm: Algorithm) -> None:
    """Make the archives of an algorithm that was set up draw from its generator.

    These are the one given as ``archive=`` and the elites of pymoo's CMOPSO.
    """
    for name in ("archive", "elites"):
        archive = getattr(algorithm, name, None)
        if isinstance(archive, Archive):
            archive.truncation = SeededTruncation(archive.truncation, algorithm)


class FrontRVEA(RVEA):
    """pymoo's RVEA, but its result is the nondominated part of its population.

    Nor does it end a generation before its budget of evaluations is used, as pymoo's does, which
    counts the first generation twice.
    """

    termination: Any

    def _setup(self, problem: Problem, **options: Any) -> None:
        if isinstance(self.termination, MaximumFunctionCallTermination):
            budget = self.termination.n_max_evals + self.n_offsprings
            self.termination = MaximumFunctionCallTermination(budget)
        super()._setup(problem, **options)

    def _set_optimum(self, **options: Any) -> None:
        self.opt = filter_optimum(self.pop, least_infeasible=True)
