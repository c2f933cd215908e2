"""View of sensor suites and their plans that the command line and reports of mgeo display."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from mgeo_attitude import Evaluation
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.constraints import list_constraints
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.view.margins import build_constraint_tables
from mgeo_attitude.view.summaries import format_duration, format_maneuvers, format_two_digits
from numpy.typing import ArrayLike

from mgeo.plugins.view import View
from mgeo_suite.catalog import NONE
from mgeo_suite.problem import SensorSuiteProblem

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Accuracies [deg] for which the least price of a front is reported.
ACCURACY_LEVELS_DEG = (1.0, 0.1, 0.03)


class SuiteView(View):
    """View of n designs, shape (n, n_var), each evaluated once; see `mgeo.View`."""

    problem: SensorSuiteProblem

    @cached_property
    def choices(self) -> Ints:
        """Option indices, shape (n, n_places)."""
        return self.problem.split_designs(self.X)[0]

    @cached_property
    def maneuvers(self) -> Floats:
        """Maneuvers, shape (n, 4 m), in deg/s and s."""
        return self.problem.split_designs(self.X)[1]

    @cached_property
    def resources(self) -> Floats:
        """Price [kEUR], mass [g] and power [mW], shape (n, 3)."""
        return self.problem.suites.compute_resources(self.choices)

    @cached_property
    def evaluation(self) -> Evaluation:
        """Filter runs of the designs."""
        return self.problem.run_filter(self.X)

    def describe(self) -> pd.DataFrame:
        """Return a table with one row per design.

        Columns: price, mass and power; the attitude 1-sigma at t_end about the worst of all axes;
        t_end; the suite as text, and the option of each place; one text per maneuver.
        """
        import pandas as pd

        problem, result, resources = self.problem, self.evaluation, self.resources
        sigma = attitude_accuracy_deg(result.covariance)
        columns: dict[str, object] = {
            "price [kEUR]": resources[:, 0],
            "mass [g]": resources[:, 1],
            "power [mW]": resources[:, 2],
            "attitude 1-sigma [deg]": np.where(np.isnan(result.t_end), np.nan, sigma),
            "t_end [s]": result.t_end,
            "suite": [problem.suites.describe_suite(choice) for choice in self.choices],
        }
        for k, place in enumerate(problem.suites.places):
            columns[place.name] = [place.options[number] for number in self.choices[:, k]]
        texts = [format_maneuvers(x) for x in self.maneuvers]
        for m in range(problem.scenario.maneuvers.count):
            name = f"maneuver {m + 1}: x / y / z [deg/s] for d [s]"
            columns[name] = [text[m] for text in texts]
        return pd.DataFrame(columns)

    def summaries(self) -> list[str]:
        """Return a line on cost, accuracy and sensors of each design."""
        lines = []
        for i, choice in enumerate(self.choices):
            t_end = self.evaluation.t_end[i]
            if np.isnan(t_end):
                lines.append("the filter's covariance lost positivity")
                continue
            accuracy = format_two_digits(
                float(attitude_accuracy_deg(self.evaluation.covariance[i]))
            )
            lines.append(
                f"{self.resources[i, 0]:.4g} kEUR; attitude {accuracy} deg (1-sigma, worst of all "
                f"axes) after {format_duration(t_end)}; {self.problem.suites.describe_suite(choice)}"
            )
        return lines

    def constraints(self) -> list[pd.DataFrame]:
        limits = [
            each
            for constraint in list_constraints(self.problem.scenario)
            for each in constraint.bounds
        ]
        excesses = np.array([limit.compute_violation(self.evaluation) for limit in limits]).T
        return build_constraint_tables(limits, excesses.reshape(len(self.X), len(limits)))

    def figures(self) -> dict[str, go.Figure]:
        """Return ``front``, price against accuracy, and ``sensors``, the selected options."""
        from mgeo_suite.figures import draw_figures

        price = self.resources[:, 0]
        return draw_figures(
            self.problem.suites, self.choices, self.maneuvers, price, self.evaluation
        )

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Return figures of the body rates and of the attitude 1-sigma of each design."""
        from mgeo_suite.figures import draw_solution_figures

        model = self.problem.suites.model
        results = (
            self.problem.run_filter(self.X[[row]], history=True) for row in range(len(self.X))
        )
        return [draw_solution_figures(model, each) for each in results]

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """Return the least price at which a front reaches each of `ACCURACY_LEVELS_DEG`, if it does."""
        objectives = self.problem.objectives
        if not {"price", "attitude"} <= set(objectives):
            return {}
        price, accuracy = (np.atleast_2d(F)[:, objectives.index(n)] for n in ("price", "attitude"))
        return {
            f"price of {least:g} deg [kEUR]": float(price[accuracy <= least].min())
            for least in ACCURACY_LEVELS_DEG
            if (accuracy <= least).any()
        }


def summarize_front(
    problem: SensorSuiteProblem, X: ArrayLike, F: Floats, budgets: Floats
) -> list[str]:
    """Summarize a front of price against accuracy in sentences.

    Parameters
    ----------
    problem : SensorSuiteProblem
    X : array_like, shape (n, n_var)
    F : array, shape (n, n_obj)
    budgets : array
        Budgets [kEUR].

    Returns
    -------
    list of str
        The most accurate suite within each budget; then, for each accuracy of `ACCURACY_LEVELS_DEG`, the
        least price, with and without a star tracker.
    """
    choices, _ = problem.split_designs(X)
    price, accuracy = (F[:, problem.objectives.index(n)] for n in ("price", "attitude"))
    names = [problem.suites.get_option_names(choice) for choice in choices]
    blind = np.array([each.get("star tracker", NONE) == NONE for each in names])
    lines = []
    for budget in budgets:
        within = np.flatnonzero(price <= budget)
        if not len(within):
            lines.append(f"Within {budget:g} kEUR there is no suite.")
            continue
        best = within[np.argmin(accuracy[within])]
        lines.append(
            f"Within {budget:g} kEUR the best is {format_two_digits(accuracy[best])} deg, for "
            f"{price[best]:.4g}: {problem.suites.describe_suite(choices[best])}."
        )
    for least in ACCURACY_LEVELS_DEG:
        reach = accuracy <= least
        if not reach.any():
            lines.append(f"Nothing that was found reaches {least:g} deg.")
            continue
        cheapest = np.flatnonzero(reach)[np.argmin(price[reach])]
        sentence = f"{least:g} deg takes {price[cheapest]:.4g} kEUR"
        if (reach & blind).any():
            sentence += f", and no star tracker from {price[reach & blind].min():.4g} kEUR on"
        else:
            sentence += "; nothing without a star tracker reaches it"
        lines.append(f"{sentence}.")
    return lines
