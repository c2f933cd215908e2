"""Suites and their plans in an engineer's terms."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.constraints import constraints
from mgeo_attitude.filter.accuracy import attitude_accuracy_deg
from mgeo_attitude.view.answers import span, two_digits
from mgeo_attitude.view.describe import maneuver_texts
from numpy.typing import ArrayLike

from mgeo_suite.catalog import NONE

if TYPE_CHECKING:
    import pandas as pd

    from mgeo_suite.protocol import SuiteProblem

#: Accuracies [deg] of which a front's least price is told.
BUDGETED_DEG = (1.0, 0.1, 0.03)


def suite_text(problem: SuiteProblem, choice: Ints) -> str:
    """A suite in words: ``mems-tactical gyro, boom magnetometer, 2 fine Sun sensors (+x, -z)``."""
    names = problem.suites.names(choice)
    parts = [f"{names['gyro']} gyro", f"{names['magnetometer']} magnetometer"]
    if (tracker := names.get("star tracker", NONE)) != NONE:
        parts.append(f"{tracker} star tracker")
    heads: dict[str, list[str]] = {}
    for place, grade in names.items():
        if place.startswith("Sun sensor") and grade != NONE:
            heads.setdefault(grade, []).append(place.removeprefix("Sun sensor "))
    for grade, faces in heads.items():
        many = "s" if len(faces) > 1 else ""
        parts.append(f"{len(faces)} {grade} Sun sensor{many} ({', '.join(faces)})")
    return ", ".join(parts)


def describe(problem: SuiteProblem, X: ArrayLike) -> pd.DataFrame:
    """One row per solution, numbered as in `X`.

    Columns: price, mass and power; the attitude's 1-sigma at t_end about the worst of all axes;
    t_end; the suite in words, and the option of each place; one text per maneuver.
    """
    import pandas as pd

    choices, maneuvers = problem.split(X)
    result = problem.evaluation(X)
    resources = problem.suites.resources(choices)
    lost = np.isnan(result.t_end)
    columns: dict[str, object] = {
        "price [kEUR]": resources[:, 0],
        "mass [g]": resources[:, 1],
        "power [mW]": resources[:, 2],
        "attitude 1-sigma [deg]": np.where(lost, np.nan, attitude_accuracy_deg(result.covariance)),
        "t_end [s]": result.t_end,
        "suite": [suite_text(problem, choice) for choice in choices],
    }
    for k, place in enumerate(problem.suites.places):
        columns[place.name] = [place.options[number] for number in choices[:, k]]
    texts = [maneuver_texts(x) for x in maneuvers]
    for m in range(problem.scenario.maneuvers.count):
        name = f"maneuver {m + 1}: x / y / z [deg/s] for d [s]"
        columns[name] = [text[m] for text in texts]
    return pd.DataFrame(columns)


def answers(problem: SuiteProblem, X: ArrayLike) -> list[str]:
    """What each solution costs and comes to know, and with which sensors, in one line."""
    choices, _ = problem.split(X)
    result = problem.evaluation(X)
    prices = problem.suites.resources(choices)[:, 0]
    lines = []
    for i, choice in enumerate(choices):
        if np.isnan(result.t_end[i]):
            lines.append("the filter's covariance lost positivity")
            continue
        accuracy = two_digits(float(attitude_accuracy_deg(result.covariance[i])))
        lines.append(
            f"{prices[i]:.4g} kEUR; attitude {accuracy} deg (1-sigma, worst of all axes) after "
            f"{span(result.t_end[i])}; {suite_text(problem, choice)}"
        )
    return lines


def limits(problem: SuiteProblem, X: ArrayLike) -> list[pd.DataFrame]:
    """For each design a table with one row per limit, as `mgeo_attitude.view.margins.tables`."""
    from mgeo_attitude.view.margins import tables

    found = [each for asked in constraints(problem.scenario) for each in asked.limits]
    result = problem.evaluation(X)
    excesses = np.array([limit.excess(result) for limit in found]).T
    return tables(found, excesses.reshape(len(result.t_end), len(found)))


def front_summary(problem: SuiteProblem, F: ArrayLike) -> dict[str, float]:
    """The least price at which each of the accuracies `BUDGETED_DEG` is reached, where it is."""
    if not {"price", "attitude"} <= set(problem.objectives):
        return {}
    values = np.atleast_2d(np.asarray(F, dtype=float))
    price, accuracy = (values[:, problem.objectives.index(n)] for n in ("price", "attitude"))
    return {
        f"price of {least:g} deg [kEUR]": float(price[accuracy <= least].min())
        for least in BUDGETED_DEG
        if (accuracy <= least).any()
    }


def conclusions(problem: SuiteProblem, X: ArrayLike, F: Floats, budgets: Floats) -> list[str]:
    """What a front of price against accuracy says, in sentences.

    For each budget [kEUR] the best suite within it; and for each of the accuracies `BUDGETED_DEG`
    the least price, and whether a suite without star tracker reaches it.
    """
    choices, _ = problem.split(X)
    price, accuracy = (F[:, problem.objectives.index(n)] for n in ("price", "attitude"))
    names = [problem.suites.names(choice) for choice in choices]
    blind = np.array([each.get("star tracker", NONE) == NONE for each in names])
    lines = []
    for budget in budgets:
        within = np.flatnonzero(price <= budget)
        if not len(within):
            lines.append(f"Within {budget:g} kEUR there is no suite.")
            continue
        best = within[np.argmin(accuracy[within])]
        lines.append(
            f"Within {budget:g} kEUR the best is {two_digits(accuracy[best])} deg, for "
            f"{price[best]:.4g}: {suite_text(problem, choices[best])}."
        )
    for least in BUDGETED_DEG:
        reach = accuracy <= least
        if not reach.any():
            lines.append(f"Nothing that was found reaches {least:g} deg.")
            continue
        cheapest = np.flatnonzero(reach)[np.argmin(price[reach])]
        told = f"{least:g} deg takes {price[cheapest]:.4g} kEUR"
        if (reach & blind).any():
            told += f", and no star tracker from {price[reach & blind].min():.4g} kEUR on"
        else:
            told += "; nothing without a star tracker reaches it"
        lines.append(f"{told}.")
    return lines
