"""Best known plans of a front during its refinement, by their end times."""

from __future__ import annotations

import numpy as np

from mgeo.evaluation.dominance import find_front_rows
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.refine.evaluators import DesignEvaluator

#: Smallest ratio of the end time of a replacing plan to the initial end time of its row.
_MIN_TIME_RATIO = 0.98
#: Largest factor on the density of added end times where the objective falls steeply.
_MAX_DENSITY_FACTOR = 3.0


class RefinementFront:
    """Best known plan for each of several end times, updated while plans are refined.

    The end times are those of the initial plans and optionally times between them.

    Parameters
    ----------
    evaluate_designs : function
        Returns end time and objective of designs, shape (n, 2), and largest violations, shape (n,).
    X : array, shape (n, n_var)
        Initial plans.
    max_time_ratio : float
        Ratio of neighboring end times above which end times are added between them.

    Attributes
    ----------
    X : array, shape (n + r, n_var)
        Best known plan of each row.
    times : array, shape (n + r,)
        End times of the initial plans [s], then the r added end times.
    """

    def __init__(
        self, evaluate_designs: DesignEvaluator, X: Floats, max_time_ratio: float = np.inf
    ) -> None:
        self._evaluate_designs = evaluate_designs
        F, violation = evaluate_designs(X)
        self._n_initial = len(X)
        self._added_rows: list[int] = []
        added_times, best = _add_rows(F, violation, max_time_ratio)
        self.X = np.vstack([X, X[best]])
        self._F = np.vstack([F, np.column_stack([added_times, F[best, 1]])])
        self._violation = np.append(violation, violation[best])
        self.times = self._F[:, 0].copy()

    @property
    def rows(self) -> Ints:
        """Row indices of all known plans in `X`.

        The initial plans come first. The plans for added end times follow in the order in which
        they were first found.
        """
        return np.array([*range(self._n_initial), *self._added_rows], dtype=np.int64)

    @property
    def plans(self) -> Floats:
        """Best known plans in the order of `rows`, shape (len(rows), n_var)."""
        return self.X[self.rows]

    def store_improvements(self, designs: Floats) -> None:
        """Store feasible designs that are better than the best known plan of an end time.

        A design improves on a plan if it ends no later and has a smaller objective. A design that
        ends much earlier than the initial end time of a row does not replace its plan, because a
        smaller objective is possible at that time. A plan that violates a constraint is replaced by
        any feasible design that ends no later.

        Parameters
        ----------
        designs : array, shape (k, n_var)
        """
        self._replace(designs, np.arange(len(self.X)), _MIN_TIME_RATIO)

    def replace_dominated(self) -> None:
        """Replace each dominated plan by a plan that ends no later and has a smaller objective."""
        self._replace(self.plans, self.rows, 0.0)

    def _replace(self, designs: Floats, rows: Ints, share: float) -> None:
        if not len(designs):
            return
        F, violation = self._evaluate_designs(designs)
        feasible = np.flatnonzero(np.isfinite(F).all(axis=1) & (violation <= 0.0))
        order = feasible[find_front_rows(F[feasible])]
        latest = np.searchsorted(F[order, 0], self._F[rows, 0], side="right") - 1
        rows, latest = rows[latest >= 0], latest[latest >= 0]
        best = order[latest]
        is_better = (F[best, 1] < self._F[rows, 1]) & (F[best, 0] >= share * self.times[rows])
        is_better |= self._violation[rows] > 0.0
        rows, best = rows[is_better], best[is_better]
        self.X[rows], self._F[rows], self._violation[rows] = designs[best], F[best], 0.0
        present = set(self._added_rows)
        self._added_rows += [
            row for row in rows.tolist() if row >= self._n_initial and row not in present
        ]


def _add_rows(F: Floats, violation: Floats, ratio: float) -> tuple[Floats, Ints]:
    """Choose additional end times between those of feasible plans.

    Return these times and, for each of them, the row of the best plan that ends by then.
    Neighboring times have the ratio `ratio`, or a smaller ratio where the objective falls faster
    than the time increases.
    """
    feasible = np.flatnonzero(np.isfinite(F).all(axis=1) & (violation <= 0.0) & (F[:, 0] > 0.0))
    order = feasible[find_front_rows(F[feasible])]
    if len(order) < 2 or not np.isfinite(ratio):
        return np.empty(0), np.empty(0, dtype=np.int64)
    logs, values = np.log(F[order, 0]), F[order, 1]
    gaps = np.diff(logs)
    falls = -np.diff(np.log(values)) if (values > 0.0).all() else gaps
    steps = np.clip(falls, gaps, _MAX_DENSITY_FACTOR * gaps)
    times, best = [], []
    for k, (gap, step) in enumerate(zip(gaps, steps, strict=True)):
        number = int(step / np.log(ratio))
        times += (logs[k] + gap * np.arange(1, number + 1) / (number + 1)).tolist()
        best += [order[k]] * number
    return np.exp(np.array(times)), np.array(best, dtype=np.int64)
