"""Fronts of problems with equality constraints, by treatment of the bounds and by NSGA-II.

    python docs/studies/equalities.py

writes data/equalities.csv in two minutes on one core: the hypervolume of each run relative to the
best value, which docs/explanation/algorithms.md shows.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
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
    "NSGA-II, 100 individuals": lambda: NSGA2(100),
}


def main():
    rows = []
    for name, (problem, reference, best) in PROBLEMS.items():
        for label, make in ALGORITHMS.items():
            for seed in SEEDS:
                run = minimize(problem, make(), ("n_eval", EVALUATIONS), seed=seed)
                rows.append((name, label, seed, hypervolume(run.F, ref=reference) / best))
    table = pd.DataFrame(rows, columns=["problem", "algorithm", "seed", "share"])
    target = Path(__file__).parent / "data" / "equalities.csv"
    table.to_csv(target, index=False, float_format="%.6g", lineterminator="\n")
    print(table.pivot_table("share", "problem", "algorithm", aggfunc="median").round(2))


if __name__ == "__main__":
    main()
