"""Suites with their plans, evaluated once for all that is told of them, and in words."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from mgeo_attitude import Scenario
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.view import two_digits
from numpy.typing import ArrayLike

from mgeo.plugins import View
from mgeo_suite.catalog import NONE
from mgeo_suite.suites import SuiteModels

if TYPE_CHECKING:
    from mgeo_attitude import Evaluation

#: Accuracies [deg] of which a front's least price is told.
BUDGETED_DEG = (1.0, 0.1, 0.03)


class SuiteProblem(Protocol):
    """A problem whose designs are a suite of sensors each, and maneuvers of one scenario."""

    scenario: Scenario
    suites: SuiteModels
    objectives: tuple[str, ...]

    def split(self, X: ArrayLike) -> tuple[Ints, Floats]: ...
    def evaluation(self, X: ArrayLike, history: bool = False) -> Evaluation: ...


class Designs(View):
    """Designs, shape (n, n_var), and what their evaluation gives, each when first asked for."""

    problem: SuiteProblem

    @cached_property
    def choices(self) -> Ints:
        """Numbers of options, shape (n, n_places)."""
        return self.problem.split(self.X)[0]

    @cached_property
    def maneuvers(self) -> Floats:
        """Shape (n, 4 m)."""
        return self.problem.split(self.X)[1]

    @cached_property
    def resources(self) -> Floats:
        """Price [kEUR], mass [g] and power [mW], shape (n, 3)."""
        return self.problem.suites.resources(self.choices)

    @cached_property
    def result(self) -> Evaluation:
        """Filter runs."""
        return self.problem.evaluation(self.X)


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
