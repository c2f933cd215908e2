"""Problems and algorithms that fail, are noisy, or have state."""

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.problems.multi import ZDT1


class HalfFeasibleProblem(Problem):
    """Problem that is infeasible in one half, with a region where the objectives are NaN."""

    def __init__(self):
        super().__init__(n_var=2, n_obj=2, n_ieq_constr=1, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        F = np.column_stack([X[:, 0], 1.0 - X[:, 0] + X[:, 1]])
        F[(X[:, 0] > 0.6) & (X[:, 0] < 0.7)] = np.nan
        out["F"], out["G"] = F, 0.5 - X[:, :1]


class DriftingProblem(ZDT1):
    """Problem whose objectives grow with every evaluation of this object."""

    def __init__(self):
        super().__init__(n_var=4)
        self.calls = []

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        self.calls.append(len(X))
        out["F"] = out["F"] + 0.01 * len(self.calls)


class NoisyProblem(ZDT1):
    """Problem with noise from its own random generator."""

    def __init__(self):
        super().__init__(n_var=4)
        self.random_state = np.random.default_rng(1)

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        out["F"] = out["F"] + self.random_state.normal(0.0, 0.01, out["F"].shape)


class SurrogateProblem(ZDT1):
    """Problem that returns the nearest stored value, as a surrogate model does."""

    def __init__(self):
        super().__init__(n_var=4)
        self.X, self.F = np.empty((0, 4)), np.empty((0, 2))

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        self.X, self.F = np.concatenate([self.X, X]), np.concatenate([self.F, out["F"]])
        if len(self.X) > 30:
            distances = np.abs(X[:, None] - self.X[:20]).sum(axis=2)
            out["F"] = self.F[distances.argmin(axis=1)]


class FailingNSGA2(NSGA2):
    """NSGA-II that fails with even seeds."""

    def _setup(self, problem, **kwargs):
        super()._setup(problem, **kwargs)
        if self.seed % 2 == 0:
            raise ArithmeticError(f"seed {self.seed} is\neven")


class GlobalRandomSearch(Algorithm):
    """Random search that uses NumPy's global random generator."""

    def _initialize_infill(self):
        return self._infill()

    def _initialize_advance(self, infills=None, **kwargs):
        pass

    def _infill(self):
        X = np.random.random((20, self.problem.n_var))  # noqa: NPY002
        return Population.new("X", X)

    def _advance(self, infills=None, **kwargs):
        self.pop = infills


class StuckSearch(GlobalRandomSearch):
    """Random search that proposes no candidate after its first generation."""

    def _infill(self):
        return Population.new("X", np.zeros((0 if self.is_initialized else 7, self.problem.n_var)))
