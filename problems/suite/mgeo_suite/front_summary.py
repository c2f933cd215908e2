"""Summary of a front of sensor suites: the best suite within a budget, and prices of accuracies."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from mgeo_attitude._typing import Floats
from numpy.typing import ArrayLike

from mgeo_suite.catalog import NONE
from mgeo_suite.problem import SensorSuiteProblem
from mgeo_suite.view import ACCURACY_LEVELS_DEG

if TYPE_CHECKING:
    from mgeo_suite.documents import BudgetRow, PriceRow


def find_best_suites(
    problem: SensorSuiteProblem, X: ArrayLike, F: Floats, budgets: Iterable[float]
) -> list[BudgetRow]:
    """Return the most accurate suite of a front within each budget.

    Parameters
    ----------
    problem : SensorSuiteProblem
        Problem whose objectives include "price" and "attitude".
    X : array_like, shape (n, n_var)
        Designs of the front.
    F : array, shape (n, n_obj)
        Objectives of the front.
    budgets : iterable of float
        Budgets [kEUR].

    Returns
    -------
    list of BudgetRow
        All values but the budget are None if no suite is within the budget.
    """
    choices, _ = problem.split_designs(X)
    price, accuracy = _select_objectives(problem, F)
    rows: list[BudgetRow] = []
    for budget in budgets:
        affordable = np.flatnonzero(price <= budget)
        best = int(affordable[np.argmin(accuracy[affordable])]) if len(affordable) else None
        rows.append(
            {
                "budget_keur": budget,
                "solution": best,
                "price_keur": None if best is None else float(price[best]),
                "attitude_1sigma_deg": None if best is None else float(accuracy[best]),
                "suite": None if best is None else problem.suites.describe_suite(choices[best]),
            }
        )
    return rows


def find_lowest_prices(problem: SensorSuiteProblem, X: ArrayLike, F: Floats) -> list[PriceRow]:
    """Return the lowest price on a front for each accuracy in `ACCURACY_LEVELS_DEG`.

    The parameters are as for `find_best_suites`.

    Returns
    -------
    list of PriceRow
        A price is None if no suite reaches the accuracy.
    """
    choices, _ = problem.split_designs(X)
    price, accuracy = _select_objectives(problem, F)
    names = [problem.suites.get_option_names(choice) for choice in choices]
    has_tracker = np.array([options.get("star tracker", NONE) != NONE for options in names])
    return [
        {
            "attitude_1sigma_deg": level,
            "price_keur": _find_minimum(price[accuracy <= level]),
            "price_without_star_tracker_keur": _find_minimum(
                price[(accuracy <= level) & ~has_tracker]
            ),
        }
        for level in ACCURACY_LEVELS_DEG
    ]


def _select_objectives(problem: SensorSuiteProblem, F: Floats) -> tuple[Floats, Floats]:
    price, accuracy = (F[:, problem.objectives.index(name)] for name in ("price", "attitude"))
    return price, accuracy


def _find_minimum(values: Floats) -> float | None:
    return float(values.min()) if len(values) else None
