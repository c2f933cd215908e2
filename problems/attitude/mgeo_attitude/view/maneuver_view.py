"""View of maneuver plans that the command line and reports of mgeo display."""

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

#: Relative excess up to which an objective counts as satisfied in the Monte Carlo runs.
TOLERANCE = 0.1


class ManeuverView(Plans):
    """View of n maneuver plans, shape (n, n_var).

    `mgeo.View` documents the methods; `Plans` holds the evaluation results.
    """

    def describe(self) -> pd.DataFrame:
        return summaries.build_plan_table(self)

    def quick_metrics(self) -> pd.DataFrame:
        return summaries.compute_quick_metrics(self)

    def summaries(self) -> list[str]:
        return summaries.summarize_plans(self)

    def constraints(self) -> list[pd.DataFrame]:
        """Return constraints and margins, one table per plan; see `margins.tables`.

        With Monte Carlo runs, each value holds in the requested share of the runs. Path constraints
        and the wheel budget have additional rows for the time after convergence, that is, for the
        constant-rate hold and for the slew back. The search does not evaluate these rows.
        """
        result = []
        limits = [
            limit for each in list_constraints(self.problem.scenario) for limit in each.bounds
        ]
        for row, after in zip(
            self.violations, margins.compute_margins_after_convergence(self), strict=True
        ):
            result += margins.build_constraint_tables(limits, row[None], [after])
        return result

    def remarks(self) -> list[str]:
        """Return lines on the robustness of a front, its margins and the lower bound.

        The lines count the plans that satisfy their objectives, and their constraints until the
        end. The `notes` follow. Of a large front, a sample of plans is evaluated.
        """
        if not len(self.X):
            return self.notes()
        rows = select_sample_rows(len(self.X))
        some, these = self.select(rows), format_plan_count(rows, len(self.X))
        return [
            _summarize_robustness(some, these),
            *margins.summarize_margins(some, these),
            *lower_bound.summarize_lower_bound(self, some, these),
            *self.notes(),
        ]

    def suggestions(self) -> list[str]:
        """Return suggestions for required 1-sigmas that no plan reaches."""
        return suggestions.suggest_changes(self)

    def figures(self) -> dict[str, go.Figure]:
        """Return figures of all plans; ``front`` exists only for the paper's objectives."""
        from mgeo_attitude.view.figures.time_series import build_figures

        return build_figures(self)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Return small figures of each plan: rates, directions of Sun and field, 1-sigmas."""
        import plotly.graph_objects as go

        return [
            {name: go.Figure(tree, _validate=False) for name, tree in trees.items()}
            for trees in self.figure_dicts()
        ]

    def figure_dicts(self) -> list[dict[str, dict[str, Any]]]:
        """Return the figures of `solution_figures` as plotly dictionaries."""
        from mgeo_attitude.view.figures.plan_drawings import draw_plans

        return list(draw_plans(self))

    def review(self) -> Review:
        """Return a review document of the only plan; see `plan.tables.review`."""
        from mgeo_attitude.plan.plan import ManeuverPlan
        from mgeo_attitude.plan.tables import build_review

        return build_review(ManeuverPlan.from_design(self.problem, self.X[0], self.F[0]))

    def infeasibility_reasons(self) -> list[str]:
        """Return the requirements that the lower bound proves infeasible."""
        return lower_bound.list_infeasible_requirements(self.problem)

    def facts(self) -> dict[str, str]:
        """Return orbit, illumination, margins at rest and validity of the scenario."""
        return satellite.describe_satellite(self.problem)

    def notes(self) -> list[str]:
        """Return warnings on implausible values, assumptions and validity of the covariance."""
        scenario = self.problem.scenario
        remarks = [
            f"{line} (docs/consistency.md): verify a plan"
            for line in find_validity_violations(scenario)
        ]
        return [*find_implausible_values(scenario), *scenario.assumptions, *remarks]

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """Return the number of points of a front that converge in the first orbit, and later.

        The result is empty for objectives other than the paper's.
        """
        if self.problem.objectives != PAPER_OBJECTIVES:
            return {}
        return summaries.count_front_points(self.problem.scenario, np.atleast_2d(F))


def _summarize_robustness(plans: Plans, sample_label: str) -> str:
    """Count the plans that satisfy their objectives in most Monte Carlo runs, as a line."""
    names = list(plans.problem.obj_names)
    if (
        plans.problem.model.ends_with_last_maneuver
    ):  # the design fixes t_end, so every run satisfies it
        names = [name for name in names if name != OBJECTIVES["t_end"].label] or names
    # The comparison is false for NaN, the result of a lost covariance.
    in_time = plans.monte_carlo_objectives - plans.F <= TOLERANCE * np.abs(plans.F)
    keep = in_time.all(axis=1) & ~np.isinf(plans.monte_carlo_t_end)
    ratio = plans.compare_with_monte_carlo()[f"Monte Carlo / predicted {names[0]}"]
    return (
        f"{keep.sum()} of {sample_label} reach their objectives within {TOLERANCE:.0%} in {MONTE_CARLO_SHARE_TEXT}; "
        f"the ratio of {names[0]} in these runs to the plan's is {ratio.median():.3g} in the "
        f"median, {ratio.max():.3g} at most"
    )
