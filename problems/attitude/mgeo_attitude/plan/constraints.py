"""The constraints of a plan, number by number."""

from __future__ import annotations

import pandas as pd
from numpy.typing import ArrayLike

from ..constraints import constraints
from ..filter.evaluator import evaluate
from ..problem import AttitudeManeuverProblem


def constraints_table(problem: AttitudeManeuverProblem, design: ArrayLike) -> pd.DataFrame:
    """What one design, shape (n_var,), makes of the problem's constraints, a row per limit.

    The ``unit``; the design's ``value``; the ``bound``, "at most" or "at least", and the ``limit``;
    the ``margin``, below zero where it is violated; whether it is ``kept``. No rows if the scenario
    asks for nothing.
    """
    asked = constraints(problem.scenario)
    limits = [limit for constraint in asked for limit in constraint.limits]
    columns = ["unit", "value", "bound", "limit", "margin", "kept"]
    labels = pd.Index([limit.label for limit in limits], name="constraint", dtype=str)
    if not limits:
        return pd.DataFrame(columns=columns, index=labels)
    covariance = any(constraint.needs_covariance for constraint in asked)
    result = evaluate(problem.model, design, problem.threads, covariance=covariance)
    rows = []
    for limit in limits:
        excess, bound = float(limit.excess(result)[0]), limit.bound * limit.factor
        value = float(limit.measured(result)[0]) * limit.factor
        least = "at least" if limit.least else "at most"
        # kept as the optimizer has it
        rows.append((limit.unit, value, least, bound, -excess * bound, excess <= 0.0))
    return pd.DataFrame(rows, columns=columns, index=labels)


def violations(table: pd.DataFrame) -> list[str]:
    """Each row of a `constraints_table` that is not kept, in words."""
    return [
        f"{label} {row['value']:.6g} {row['unit']}, {row['bound']} {row['limit']:.6g} "
        f"{row['unit']}, violated by {-row['margin']:.3g} {row['unit']}"
        for label, row in table.iterrows()
        if not row["kept"]
    ]
