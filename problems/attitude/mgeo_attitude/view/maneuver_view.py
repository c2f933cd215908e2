"""View of maneuver plans: the tables, texts and figures that the command line and reports
display.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo.plugins.review import Review
from mgeo_attitude.criteria.constraints import list_constraints
from mgeo_attitude.criteria.objectives import OBJECTIVES, PAPER_OBJECTIVES
from mgeo_attitude.scenario.validity import find_implausible_values, find_validity_violations
from mgeo_attitude.view import lower_bound, margins, satellite, suggestions, summaries
from mgeo_attitude.view.plans import (
    MONTE_CARLO_SHARE_TEXT,
    Plans,
    format_plan_count,
    select_sample_rows,
)

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Relative excess over its predicted value up to which an objective counts as reached.
TOLERANCE = 0.1


class ManeuverView(Plans):
    """Presentation of n maneuver plans in reports and terminals: tables, summaries, warnings and
    figures.

    `mgeo.View` documents the methods, and `Plans` has the evaluation results.
    """

    def describe(self) -> pd.DataFrame:
        return summaries.build_plan_table(self)

    def quick_metrics(self) -> pd.DataFrame:
        return summaries.compute_quick_metrics(self)

    def summaries(self) -> list[str]:
        return summaries.summarize_plans(self)

    def constraints(self) -> list[pd.DataFrame]:
        """Return, for each plan, a table with the value, bound and margin of each constraint.

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

    def remarks(self) -> list[str]:
        """Return lines of text on the plans as a group: robustness, margins after convergence, and
        lower bound. Warnings on the scenario follow.

        The lines count the plans that reach their predicted objectives in most Monte Carlo runs,
        and those that satisfy their constraints until the end of the plan. If there are many plans,
        a sample of them is evaluated.
        """
        if not len(self.X):
            return self.notes()
        rows = select_sample_rows(len(self.X))
        sample, sample_label = self.select(rows), format_plan_count(rows, len(self.X))
        return [
            _summarize_robustness(sample, sample_label),
            *margins.summarize_margins(sample, sample_label),
            *lower_bound.summarize_lower_bound(self, sample, sample_label),
            *self.notes(),
        ]

    def suggestions(self) -> list[str]:
        return suggestions.suggest_changes(self)

    def figures(self) -> dict[str, go.Figure]:
        """Return plotly figures that show all plans together, as a dict with the keys ``front``,
        ``maneuvers`` and ``convergence``.

        ``front`` exists only for the paper's objectives, t_end and trace.
        """
        from mgeo_attitude.view.figures.time_series import build_figures

        return build_figures(self)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Return small plotly figures of each plan, as one dict of figures by name per plan.

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
        """Return lines of text with warnings on the scenario: implausible values, modeling
        assumptions, and initial errors for which the filter has not been validated.
        """
        scenario = self.problem.scenario
        validity = [
            f"{line} (docs/validation/consistency.md): verify a plan"
            for line in find_validity_violations(scenario)
        ]
        return [*find_implausible_values(scenario), *scenario.assumptions, *validity]

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """Count the nondominated points of a front that converge within the first orbit, and those
        that converge later. Return both counts as a dict.

        The dict has the keys ``points, first orbit`` and ``points, second orbit``. It is empty for
        objectives other than the paper's.
        """
        if self.problem.objectives != PAPER_OBJECTIVES:
            return {}
        return summaries.count_front_points(self.problem.scenario, np.atleast_2d(F))


def _summarize_robustness(plans: Plans, sample_label: str) -> str:
    names = list(plans.problem.obj_names)
    if plans.problem.model.ends_with_last_maneuver:
        # The design fixes t_end, so that every run reaches it.
        names = [name for name in names if name != OBJECTIVES["t_end"].label] or names
    # The comparison is false for NaN, the result of a lost covariance.
    is_reached = plans.monte_carlo_objectives - plans.F <= TOLERANCE * np.abs(plans.F)
    is_robust = is_reached.all(axis=1) & ~np.isinf(plans.monte_carlo_t_end)
    ratio = plans.compare_with_monte_carlo()[f"Monte Carlo / predicted {names[0]}"]
    return (
        f"{is_robust.sum()} of {sample_label} reach their objectives within {TOLERANCE:.0%} in "
        f"{MONTE_CARLO_SHARE_TEXT}; the ratio of {names[0]} in these runs to the plan's is "
        f"{ratio.median():.3g} in the median, {ratio.max():.3g} at most"
    )
