"""View of maneuver plans: the tables, texts and figures that the command line and reports
display.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo.plugins.review import Review, Section
from mgeo_attitude.calibration_package import (
    INSTALL_COMMAND,
    is_calibration_installed,
    suggest_verification,
)
from mgeo_attitude.criteria.constraints import list_constraints
from mgeo_attitude.criteria.objectives import PAPER_OBJECTIVES
from mgeo_attitude.scenario.validity import find_implausible_values, find_validity_violations
from mgeo_attitude.view import lower_bound, margins, overview, satellite, suggestions, summaries
from mgeo_attitude.view.plans import (
    Plans,
    format_plan_count,
    select_sample_rows,
)

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Relative excess over its predicted value up to which an objective counts as reached.
TOLERANCE = 0.1


class ManeuverView(Plans):
    """Tables, texts and figures that present maneuver plans in reports and terminals.

    `mgeo.View` documents the methods, and `Plans` has the evaluation results.
    """

    def describe(self) -> pd.DataFrame:
        return summaries.build_plan_table(self)

    def quick_metrics(self) -> pd.DataFrame:
        return summaries.compute_quick_metrics(self)

    def summaries(self) -> list[str]:
        return summaries.summarize_plans(self)

    def constraints(self) -> list[pd.DataFrame]:
        """Return one table per plan with the value, bound and margin of each constraint.

        With Monte Carlo runs, each value is satisfied in the requested share of the runs. Path
        constraints and wheel budgets have additional rows for the constant-rate hold after
        convergence and for the slew back. The search does not evaluate these rows. See
        `margins.build_constraint_tables` for the columns.
        """
        result = []
        bounds = [
            bound for each in list_constraints(self.problem.scenario) for bound in each.bounds
        ]
        for row, after in zip(
            self.violations, margins.compute_margins_after_convergence(self), strict=True
        ):
            result += margins.build_constraint_tables(bounds, row[None], [after])
        return result

    def overview(self) -> dict[str, Section]:
        return overview.build_overview(self)

    def front_table(self) -> pd.DataFrame:
        return overview.build_front_table(self)

    def format_title(self, name: str) -> str:
        """Return a column title that spells out ``t_end`` and ``trace``."""
        event = "end" if self.problem.model.rule in ("end", "required") else "convergence"
        title = name.replace("t_end", f"{event} time").removesuffix(" [-]").replace(" [-],", ",")
        return re.sub(r"\btrace$|\btrace(?=,)", "weighted trace of covariance", title)

    def warnings(self) -> list[str]:
        """Return warnings about the plans, followed by the `notes` on the scenario.

        The warnings count the plans that exceed their predicted objectives in Monte Carlo runs, and
        those that violate constraints after convergence. If there are many plans, a sample of them
        is evaluated.
        """
        if not len(self.X):
            return self.notes()
        rows = select_sample_rows(len(self.X))
        sample, sample_label = self.select(rows), format_plan_count(rows, len(self.X))
        return [
            *_list_robustness_warnings(sample, sample_label),
            *margins.list_margin_warnings(sample, sample_label),
            *self.notes(),
        ]

    def next_commands(self, folder: str) -> dict[str, str]:
        return {
            "Print the plan": f"mgeo attitude show {folder}",
            **suggest_verification(folder),
        }

    def suggestions(self) -> list[str]:
        return suggestions.suggest_changes(self)

    def figures(self) -> dict[str, go.Figure]:
        """Return plotly figures of all plans, keyed by ``front``, ``maneuvers`` and
        ``convergence``.

        ``front`` exists only for the paper's objectives, t_end and trace.
        """
        from mgeo_attitude.view.figures.time_series import build_figures

        return build_figures(self)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Return one dict of small plotly figures per plan, keyed by figure name.

        The figures show body rates, attitude, directions of Sun and magnetic field, trace and
        1-sigmas.
        """
        import plotly.graph_objects as go

        return [
            {name: go.Figure(tree, _validate=False) for name, tree in trees.items()}
            for trees in self.figure_dicts()
        ]

    def figure_dicts(self) -> list[dict[str, dict[str, Any]]]:
        from mgeo_attitude.view.figures.plan_drawings import draw_plans

        return list(draw_plans(self))

    def review(self) -> Review:
        from mgeo_attitude.plan.plan import ManeuverPlan
        from mgeo_attitude.plan.tables import build_review

        return build_review(ManeuverPlan.from_design(self.problem, self.X[0], self.F[0]))

    def infeasibility_reasons(self) -> list[str]:
        return lower_bound.list_infeasible_requirements(self.problem)

    def facts(self) -> dict[str, str]:
        return satellite.describe_satellite(self.problem)

    def notes(self) -> list[str]:
        """Return notes on implausible values, modeling assumptions and untested initial errors."""
        scenario = self.problem.scenario
        check = "Check a plan with mgeo attitude verify"
        if not is_calibration_installed():
            check += f", which {INSTALL_COMMAND} installs"
        validity = [f"{line}. {check}." for line in find_validity_violations(scenario)]
        return [*find_implausible_values(scenario), *scenario.assumptions, *validity]

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """Count the nondominated points that converge within the first orbit and after it.

        The dict has the keys ``points, first orbit`` and ``points, second orbit``. It is empty for
        objectives other than the paper's.
        """
        if self.problem.objectives != PAPER_OBJECTIVES:
            return {}
        return summaries.count_front_points(self.problem.scenario, np.atleast_2d(F))


def _list_robustness_warnings(plans: Plans, sample_label: str) -> list[str]:
    # The comparison is false for NaN, the result of a lost covariance.
    is_reached = plans.monte_carlo_objectives - plans.F <= TOLERANCE * np.abs(plans.F)
    n_overrun = int((~is_reached.all(axis=1) | np.isinf(plans.monte_carlo_t_end)).sum())
    if not n_overrun:
        return []
    problem = plans.problem
    # The design may fix t_end, so that every run reaches it.
    is_fixed = problem.model.ends_with_last_maneuver
    labels = [label for label in problem.obj_labels if not (is_fixed and label == "time")]
    names = " or ".join(labels).replace("-", " ")
    advice = "Use --robust to search for plans that tolerate these errors."
    if problem.scenario.monte_carlo:
        advice = "Increase monte_carlo.n_runs in the scenario file."
    return [
        f"Random errors may increase the {names} of {n_overrun} of {sample_label} by over "
        f"{100.0 * TOLERANCE:.0f} %. {advice}"
    ]
