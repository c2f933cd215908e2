"""Test problems with known fronts, failing evaluations, several fidelities or mixed variables."""

import copy

import numpy as np
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.core.variable import Binary, Integer, Real


class Galski(Problem):
    """Cases 1 to 4 of Galski (2006), as coded in mgeocpp's mgeocpp_testcases.cpp."""

    def __init__(self, case):
        self.case = case
        super().__init__(n_var=2 if case == 4 else 1, n_obj=2, xl=-10.0, xu=10.0)

    def _evaluate(self, X, out, *args, **kwargs):
        x = X[:, 0]
        if self.case == 1:
            bump = 1.4 * np.exp(-x * x)
            out["F"] = np.column_stack([np.exp(-x) + bump, np.exp(x) + bump])
        elif self.case == 2:
            out["F"] = np.column_stack([x**2, (x - 2) ** 2])
        elif self.case == 3:
            saw = np.select([x <= 1, x <= 3, x <= 4], [-x, x - 2, 4 - x], x - 4)
            out["F"] = np.column_stack([saw, (x - 5) ** 2])
        else:
            y = X[:, 1]
            out["F"] = np.column_stack([x**2 + y**2, (x - 1.5) ** 2 + (y - 3.5) ** 2])


class Rosenbrock(Problem):
    """Rosenbrock function of de Sousa, Ramos, Paglione & Girardi (2003); minimum 0 at all ones."""

    def __init__(self, n_var=2):
        super().__init__(n_var=n_var, n_obj=1, xl=-2.048, xu=2.048)

    def _evaluate(self, X, out, *args, **kwargs):
        a, b = X[:, :-1], X[:, 1:]
        out["F"] = np.sum(100.0 * (b - a**2) ** 2 + (1.0 - a) ** 2, axis=1)


class Mixture(ElementwiseProblem):
    """Problem with ties, NaN and infinite objectives, an inequality and an equality constraint."""

    def __init__(self):
        super().__init__(
            n_var=5,
            n_obj=3,
            n_ieq_constr=1,
            n_eq_constr=1,
            xl=[-1, 0, -3, -2, 0],
            xu=[1, 4, 3, 2, 1],
        )

    def _evaluate(self, x, out, *args, **kwargs):
        f = [round(float(x[0]), 1), float(np.floor(x[1])), float((x[2] - 1) ** 2 + x[3])]
        if x[3] > 1.5:
            f[1] = np.nan
        if x[3] < -1.9:
            f[2] = np.inf
        out["F"] = f
        out["G"] = [x[0] - 0.8]
        out["H"] = [max(0.0, float(x[4]) - 0.5)]  # Satisfied on half of the range.


class Fixed(Problem):
    """Problem with the same objectives at every point; `violation` makes all points infeasible."""

    def __init__(self, F, violation=None):
        self.F = np.asarray(F, dtype=float)
        n_ieq = int(violation is not None)
        self.violation = violation
        super().__init__(n_var=3, n_obj=len(self.F), n_ieq_constr=n_ieq, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.tile(self.F, (len(X), 1))
        if self.violation is not None:
            out["G"] = np.full((len(X), 1), self.violation)


class Estimated(Problem):
    """Problem with three fidelity levels; the two lower ones add sine waves to the objectives."""

    def __init__(self, constrained=False):
        super().__init__(n_var=4, n_obj=2, n_ieq_constr=int(constrained), xl=0.0, xu=1.0)
        self.batches, self.fidelity = [], 2

    def at_fidelity(self, fidelity):
        if fidelity >= 2:
            return self
        low_fidelity = copy.copy(self)
        low_fidelity.fidelity = fidelity
        return low_fidelity

    def _evaluate(self, X, out, *args, **kwargs):
        fidelity = self.fidelity
        self.batches.append((fidelity, X.copy()))
        rest = 1.0 + X[:, 1:].sum(axis=1) + 0.1 * (2 - fidelity) * np.sin(40.0 * X).sum(axis=1)
        out["F"] = np.column_stack([X[:, 0] + 0.5 * rest, 1.0 - X[:, 0] + rest])
        if self.n_ieq_constr:
            out["G"] = 0.1 * fidelity - X[:, :1] * X[:, 1:2]


class Typed(Problem):
    """Problem with a real, an integer and a binary variable, whose designs are dicts."""

    def __init__(self):
        variables = {"a": Real(bounds=(-1, 2)), "b": Integer(bounds=(-3, 4)), "c": Binary()}
        super().__init__(vars=variables, n_obj=2)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.array([[x["a"] ** 2 + x["b"], x["c"] - x["b"] * x["a"]] for x in X])


class Arc(Problem):
    """Problem whose feasible set and front are the unit circle in the first quadrant."""

    def __init__(self):
        super().__init__(n_var=2, n_obj=2, n_eq_constr=1, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = -X
        out["H"] = (X**2).sum(axis=1, keepdims=True) - 1.0
