"""How far designs are from the limits of their scenario, each limit in its own unit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats
from mgeo_attitude.constraints import Limit, constraints
from mgeo_attitude.describe import checked_designs
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.robustness import kept_by, over_flights

if TYPE_CHECKING:
    import pandas as pd

    from mgeo_attitude.filter.evaluator import Evaluation
    from mgeo_attitude.protocol import ManeuverProblem


def margins(problem: ManeuverProblem, X: ArrayLike) -> list[pd.DataFrame]:
    """For each design, shape (n, n_var), a table with one row per limit.

    Columns: ``unit``, ``value``, ``bound`` ("at most" or "at least"), ``limit``, and ``margin``,
    below zero where it is violated. Where plans are judged over flights, the value is what the
    demanded share of them keeps.

    Raises
    ------
    ValueError
        For another shape, or a design that is no plan.
    """
    from mgeo_attitude.filter.evaluator import evaluate  # compiles

    designs = checked_designs(problem, X)
    asked = constraints(problem.scenario)
    limits = [limit for constraint in asked for limit in constraint.limits]
    if not limits:
        return tables([], np.empty((len(designs), 0)))
    covariance = any(constraint.needs_covariance for constraint in asked)

    def excesses(model: FilterModel, result: Evaluation) -> Floats:
        return np.column_stack([limit.excess(result) for limit in limits])

    threads, flights = problem.threads, problem.flights
    if flights is None:
        result = evaluate(problem.model, designs, threads, covariance=covariance)
        found = excesses(problem.model, result)
    else:
        flown = over_flights(flights, designs, excesses, threads, covariance)
        found = kept_by(flown, flights.errors.kept)
    return tables(limits, found)


def tables(limits: Sequence[Limit], excesses: Floats) -> list[pd.DataFrame]:
    """The table of each of n designs from what they exceed limits by, shape (n, n_limits)."""
    import pandas as pd

    labels = pd.Index([limit.label for limit in limits], name="constraint", dtype=str)
    columns = ["unit", "value", "bound", "limit", "margin"]
    found = []
    for row in excesses:
        cells = []
        for limit, excess in zip(limits, row.tolist(), strict=True):
            bound = limit.bound * limit.factor
            value = bound * (1.0 - excess if limit.least else 1.0 + excess)
            least = "at least" if limit.least else "at most"
            cells.append((limit.unit, value, least, bound, -excess * bound))
        found.append(pd.DataFrame(cells, columns=columns, index=labels))
    return found
