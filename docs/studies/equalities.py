"""Fronts of problems with equality constraints, by treatment of the bounds and by NSGA-II.

    python docs/studies/equalities.py

prints the table of docs/explanation/algorithms.md in two minutes on one core.
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
    """Problem whose front is the unit circle in the first quadrant, with other variables at 0.5.

    The front extends from corner to corner of the bounds and has the hypervolume pi / 4.
    """

    def __init__(self, n_var=2):
        super().__init__(n_var=n_var, n_obj=2, n_eq_constr=1, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        rest = ((X[:, 2:] - 0.5) ** 2).sum(axis=1, keepdims=True)
        out["F"] = rest - X[:, :2]
        out["H"] = (X[:, :2] ** 2).sum(axis=1, keepdims=True) - 1.0


class Portfolio(Problem):
    """Portfolio problem: shares x of assets that sum to 1 minimize the loss -m x and the variance.

    The returns of the assets are independent with means m and variances v. The efficient portfolios
    solve a parametric quadratic program (Markowitz 1952), and the front is computed on a grid of
    multipliers. Every corner of the bounds with a share of 1 is feasible.
    """

    def __init__(self, n_var=6):
        super().__init__(n_var=n_var, n_obj=2, n_eq_constr=1, xl=0.0, xu=1.0)
        self.mean = np.linspace(0.0, 1.0, n_var)
        self.variance = (1.0 + self.mean) ** 2 / 4.0

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([-X @ self.mean, X**2 @ self.variance])
        out["H"] = X.sum(axis=1, keepdims=True) - 1.0

    def front(self):
        """Return the objectives of the efficient portfolios."""
        # For a multiplier t, x_i = max(0, (t m_i + u) / v_i), with u such that the sum is 1.
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
    """Print a table of the median and range of the hypervolume, relative to the best value."""
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
