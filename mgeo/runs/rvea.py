"""RVEA with a front as its result, and with the whole budget."""

from typing import Any

from pymoo.algorithms.moo.rvea import RVEA
from pymoo.core.problem import Problem
from pymoo.termination.max_eval import MaximumFunctionCallTermination
from pymoo.util.optimum import filter_optimum


class FrontRVEA(RVEA):
    """pymoo's RVEA, whose result is its population, dominated points and all.

    This one's is the nondominated part of that. Nor does it end a generation before its budget of
    evaluations is used, as pymoo's does, which counts the first generation twice.
    """

    termination: Any

    def _setup(self, problem: Problem, **options: Any) -> None:
        given = self.termination
        if isinstance(given, MaximumFunctionCallTermination):
            budget = given.n_max_evals + self.n_offsprings
            self.termination = MaximumFunctionCallTermination(budget)
        super()._setup(problem, **options)

    def _set_optimum(self, **options: Any) -> None:
        self.opt = filter_optimum(self.pop, least_infeasible=True)
