"""Suites and their plans in an engineer's terms."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from mgeo_attitude.criteria import attitude_accuracy_deg, constraints
from mgeo_attitude.view import maneuver_texts, span, two_digits
from numpy.typing import ArrayLike

from mgeo_suite.designs import BUDGETED_DEG, Designs, suite_text

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go


class SuiteView(Designs):
    """Suites and their plans as people are shown them; see `mgeo.View`."""

    def describe(self) -> pd.DataFrame:
        """One row per design.

        Columns: price, mass and power; the attitude's 1-sigma at t_end about the worst of all axes;
        t_end; the suite in words, and the option of each place; one text per maneuver.
        """
        import pandas as pd

        problem, result, resources = self.problem, self.result, self.resources
        sigma = attitude_accuracy_deg(result.covariance)
        columns: dict[str, object] = {
            "price [kEUR]": resources[:, 0],
            "mass [g]": resources[:, 1],
            "power [mW]": resources[:, 2],
            "attitude 1-sigma [deg]": np.where(np.isnan(result.t_end), np.nan, sigma),
            "t_end [s]": result.t_end,
            "suite": [suite_text(problem, choice) for choice in self.choices],
        }
        for k, place in enumerate(problem.suites.places):
            columns[place.name] = [place.options[number] for number in self.choices[:, k]]
        texts = [maneuver_texts(x) for x in self.maneuvers]
        for m in range(problem.scenario.maneuvers.count):
            name = f"maneuver {m + 1}: x / y / z [deg/s] for d [s]"
            columns[name] = [text[m] for text in texts]
        return pd.DataFrame(columns)

    def answers(self) -> list[str]:
        """What each design costs and comes to know, and with which sensors, in one line."""
        lines = []
        for i, choice in enumerate(self.choices):
            t_end = self.result.t_end[i]
            if np.isnan(t_end):
                lines.append("the filter's covariance lost positivity")
                continue
            accuracy = two_digits(float(attitude_accuracy_deg(self.result.covariance[i])))
            lines.append(
                f"{self.resources[i, 0]:.4g} kEUR; attitude {accuracy} deg (1-sigma, worst of all "
                f"axes) after {span(t_end)}; {suite_text(self.problem, choice)}"
            )
        return lines

    def limits(self) -> list[pd.DataFrame]:
        """For each design a table with a row per limit, see `mgeo_attitude.view.margins.tables`."""
        from mgeo_attitude.view import tables  # compiles

        found = [each for asked in constraints(self.problem.scenario) for each in asked.limits]
        excesses = np.array([limit.excess(self.result) for limit in found]).T
        return tables(found, excesses.reshape(len(self.X), len(found)))

    def figures(self) -> dict[str, go.Figure]:
        """``front`` by suite, and which sensors appear where."""
        from mgeo_suite.figures import figures

        return figures(self)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """For each design its plan and how the attitude comes to be known along it."""
        from mgeo_suite.figures import solution_figures

        return solution_figures(self)

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """The least price at which each of `BUDGETED_DEG` is reached, where it is."""
        objectives = self.problem.objectives
        if not {"price", "attitude"} <= set(objectives):
            return {}
        values = np.atleast_2d(np.asarray(F, dtype=float))
        price, accuracy = (values[:, objectives.index(n)] for n in ("price", "attitude"))
        return {
            f"price of {least:g} deg [kEUR]": float(price[accuracy <= least].min())
            for least in BUDGETED_DEG
            if (accuracy <= least).any()
        }
