"""Fronts of problems with equality constraints, by treatment of the bounds and by NSGA-II.

    python docs/studies/equalities.py

prints the table of docs/algorithms.md in two minutes on one core.
"""

from __future__ import annotations

import numpy as np
from moocore import hypervolume
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import Problem
from pymoo.optimize import minimize

from mgeo import MGEODirected

EVALUATIONS = 10_000
SEEDS = range(1, 8)


class Arc(Problem):
    """The unit circle in the first quadrant; further variables are best at 0.5.

    The front is the whole arc, from corner to corner of the bounds, and its hypervolume pi / 4.
    """

    def __init__(self, n_var=2):
        super().__init__(n_var=n_var, n_obj=2, n_eq_constr=1, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        rest = ((X[:, 2:] - 0.5) ** 2).sum(axis=1, keepdims=True)
        out["F"] = rest - X[:, :2]
        out["H"] = (X[:, :2] ** 2).sum(axis=1, keepdims=True) - 1.0


class Portfolio(Problem):
    """Shares of assets, which add up to one, for the least loss -m x and variance.

    Assets are independent with means m and variances v. A portfolio of least variance
    for its mean is one of a parametric quadratic program (Markowitz 1952); here the
    front is computed on a grid of multipliers. Every corner with one share of 1 is feasible.
    """

    def __init__(self, n_var=6):
        super().__init__(n_var=n_var, n_obj=2, n_eq_constr=1, xl=0.0, xu=1.0)
        self.mean = np.linspace(0.0, 1.0, n_var)
        self.variance = (1.0 + self.mean) ** 2 / 4.0

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([-X @ self.mean, X**2 @ self.variance])
        out["H"] = X.sum(axis=1, keepdims=True) - 1.0

    def front(self):
        """Objectives of the efficient portfolios: x_i = max(0, (t m_i + u) / v_i), summing to 1."""
        rows = []
        for t in np.geomspace(1e-4, 1e3, 4000):
            low, high = -10.0 * t - 10.0, 10.0
            for _ in range(200):
                u = (low + high) / 2
                x = np.maximum(0.0, (t * self.mean + u) / self.variance)
                low, high = (u, high) if x.sum() < 1.0 else (low, u)
            rows.append([-x @ self.mean, x**2 @ self.variance])
        return np.array(rows)


PROBLEMS = {
    "arc, 2 variables": (Arc(2), [0.0, 0.0], np.pi / 4),
    "arc, 6 variables": (Arc(6), [0.0, 0.0], np.pi / 4),
    "portfolio, 6 assets": (
        Portfolio(), [0.0, 1.0], hypervolume(Portfolio().front(), ref=[0.0, 1.0]),
    ),
}  # fmt: skip
ALGORITHMS = {
    'MGEODirected(bounds="clip")': lambda: MGEODirected(bounds="clip"),
    "MGEODirected()": MGEODirected,
    "NSGA-II, 100": lambda: NSGA2(100),
}


def main():
    """Print the least, median and greatest share of the best hypervolume as a table."""
    print(f"| problem | {' | '.join(ALGORITHMS)} |\n| --- |{' --- |' * len(ALGORITHMS)}")
    for name, (problem, reference, best) in PROBLEMS.items():
        cells = []
        for make in ALGORITHMS.values():
            runs = (minimize(problem, make(), ("n_eval", EVALUATIONS), seed=s) for s in SEEDS)
            shares = np.sort([hypervolume(run.F, ref=reference) / best for run in runs])
            median = shares[len(shares) // 2]
            cells.append(f"{median:.2f} ({shares[0]:.2f} to {shares[-1]:.2f})")
        print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
