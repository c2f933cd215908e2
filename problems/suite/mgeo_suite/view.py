"""Presentation of sensor suites and their maneuvers in the command line and reports of mgeo."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from mgeo_attitude import Evaluation
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.constraints import list_constraints
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.view.margins import build_constraint_tables
from mgeo_attitude.view.summaries import COVARIANCE_LOST, format_maneuvers
from numpy.typing import ArrayLike

from mgeo._text import format_duration, format_two_digits
from mgeo.plugins.review import Section
from mgeo.plugins.view import MAX_ROWS, View, build_constraint_section
from mgeo_suite.problem import SensorSuiteProblem

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Attitude 1-sigmas [deg] for which the minimum price on a front is reported.
ACCURACY_LEVELS_DEG = (1.0, 0.1, 0.03)


class SuiteView(View):
    """Presentation of `SensorSuiteProblem` designs as tables, figures and text.

    See `mgeo.View`. Each design is evaluated once.
    """

    problem: SensorSuiteProblem
    noun = "suite"

    @cached_property
    def choices(self) -> Ints:
        """Index of the option selected for each instrument mounting place, with one row per design.

        The shape is (n, n_places).
        """
        return self.problem.split_designs(self.X)[0]

    @cached_property
    def maneuvers(self) -> Floats:
        """Body rates [deg/s] and duration [s] of each maneuver, with one row per design.

        The shape is (n, 4 n_maneuvers).
        """
        return self.problem.split_designs(self.X)[1]

    @cached_property
    def resources(self) -> Floats:
        """Price [kEUR], mass [g] and power [mW] of the selected suites, with one row per design.

        The shape is (n, 3).
        """
        return self.problem.suites.compute_resources(self.choices)

    @cached_property
    def evaluation(self) -> Evaluation:
        """Results of the Kalman filter for the instruments and maneuvers of each design."""
        return self.problem.run_filter(self.X)

    def describe(self) -> pd.DataFrame:
        """Return a table of cost, accuracy, sensors and maneuvers, with one row per design.

        The columns are price, mass and power; the attitude 1-sigma at t_end about the worst of all
        axes; t_end; the suite as text; the option of each mounting place; and each maneuver as
        text.
        """
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
        """Return one line of text per design: price, attitude accuracy, end time and sensors."""
        lines = []
        for i, choice in enumerate(self.choices):
            t_end = self.evaluation.t_end[i]
            if np.isnan(t_end):
                lines.append(COVARIANCE_LOST)
                continue
            accuracy = format_two_digits(
                float(attitude_accuracy_deg(self.evaluation.covariance[i]))
            )
            suite = self.problem.suites.describe_suite(choice)
            lines.append(
                f"{self.resources[i, 0]:.4g} kEUR: attitude {accuracy} deg (1-sigma, worst of all "
                f"axes) after {format_duration(t_end)}, with {suite}"
            )
        return lines

    def overview(self) -> dict[str, Section]:
        """Return the summary, the constraints and the maneuvers of a single design."""
        (constraints,), (maneuvers,) = self.constraints(), self.maneuvers
        rates = maneuvers.reshape(-1, VARIABLES_PER_MANEUVER)
        # The scenario may end before the last maneuver.
        ends = np.fmin(rates[:, 3].cumsum(), self.evaluation.t_end[0])
        columns = {"duration [s]": np.diff(ends, prepend=0.0)}
        columns |= {f"ω{axis} [deg/s]": rates[:, i] for i, axis in enumerate("xyz")}
        decimals = {name: 0 if name == "duration [s]" else 2 for name in columns}
        numbers = pd.Index([str(m + 1) for m in range(len(rates))], name="maneuver")
        sections = {"summary": Section("", tuple(f"{line}." for line in self.summaries()))}
        if len(constraints):
            note = ""
            if self.problem.scenario.required_sigma:
                note = "A required 1-sigma applies to each body axis, not to the worst of all axes."
            section = build_constraint_section(constraints)
            sections["constraints"] = dataclasses.replace(section, note=note)
        table = pd.DataFrame(columns, index=numbers)[columns["duration [s]"] > 0.0]
        return sections | {"maneuvers": Section("Maneuver", (), table, "", decimals, MAX_ROWS)}

    def front_table(self) -> pd.DataFrame:
        """Return a table of cost, accuracy and end time, with one row per design.

        If it is an objective, the time from which on all required 1-sigmas are satisfied follows.
        """
        table = self.describe().iloc[:, :5].rename(columns={"t_end [s]": "ends after [s]"})
        if "t_required" in self.problem.objectives:
            table["requirement met after [s]"] = self.evaluation.t_required
        return table

    def constraints(self) -> list[pd.DataFrame]:
        bounds = [
            bound
            for constraint in list_constraints(self.problem.scenario)
            for bound in constraint.bounds
        ]
        violations = np.array([bound.compute_violation(self.evaluation) for bound in bounds]).T
        return build_constraint_tables(bounds, violations.reshape(len(self.X), len(bounds)))

    def figures(self) -> dict[str, go.Figure]:
        """Draw two figures of all designs: accuracy versus price, and the selected sensors.

        The keys of the figures are ``front`` and ``sensors``.
        """
        from mgeo_suite.figures import draw_figures

        price = self.resources[:, 0]
        return draw_figures(
            self.problem.suites, self.choices, self.maneuvers, price, self.evaluation
        )

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Draw body rates and attitude 1-sigma versus time for each design."""
        from mgeo_suite.figures import draw_solution_figures

        model = self.problem.suites.model
        results = (
            self.problem.run_filter(self.X[[row]], history=True) for row in range(len(self.X))
        )
        return [draw_solution_figures(model, result) for result in results]

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """Return the lowest price on a front for each accuracy in `ACCURACY_LEVELS_DEG`.

        The keys of the dict state the accuracy.

        Accuracies that no suite reaches are left out.
        """
        objectives = self.problem.objectives
        if not {"price", "attitude"} <= set(objectives):
            return {}
        price, accuracy = (np.atleast_2d(F)[:, objectives.index(n)] for n in ("price", "attitude"))
        return {
            f"price of {level:g} deg [kEUR]": float(price[accuracy <= level].min())
            for level in ACCURACY_LEVELS_DEG
            if (accuracy <= level).any()
        }
