"""Corrections of pymoo's algorithms: runs that repeat with their seed, results that are fronts."""

from __future__ import annotations

from typing import Any

from pymoo.algorithms.moo.rvea import RVEA
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem
from pymoo.termination.max_eval import MaximumFunctionCallTermination
from pymoo.util.archive import Archive, RandomTruncation, SurvivalTruncation, Truncation
from pymoo.util.optimum import filter_optimum


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
