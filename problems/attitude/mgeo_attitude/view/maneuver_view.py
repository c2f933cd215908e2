"""Everything that people are shown of plans of the satellite problem."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo.plugins.shown import Review
from mgeo_attitude.criteria.constraints import constraints
from mgeo_attitude.criteria.objectives import OBJECTIVES, PAPER
from mgeo_attitude.scenario.validity import implausible, validity
from mgeo_attitude.view import describe, lower_bound, margins, requirements, satellite
from mgeo_attitude.view.plans import MOST_SAMPLES, Plans, looked_at, spread

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Share by which an objective may be missed.
TOLERANCE = 0.1


class ManeuverView(Plans):
    """Plans, shape (n, n_var), as people are shown them.

    See `mgeo.View` for each method, and `Plans` for what is known of the plans besides.
    """

    def describe(self) -> pd.DataFrame:
        """Return one row a plan; see `describe.describe`."""
        return describe.describe(self)

    def glance(self) -> pd.DataFrame:
        """Return what one run of the filter tells, one row a plan; see `describe.glance`."""
        return describe.glance(self)

    def answers(self) -> list[str]:
        """Return what each plan is worth, in one line; see `describe.answers`."""
        return describe.answers(self)

    def limits(self) -> list[pd.DataFrame]:
        """Return the scenario's limits and each plan's margins; see `margins.tables`.

        Over Monte Carlo runs, a value is what the demanded share of them keeps. Path limits, and
        the budget of wheels, have a row each for the time after the filter has converged, too, in
        which the last rate is held for late flights or the body slews back. No search sees these.
        """
        found = []
        limits = [limit for each in constraints(self.problem.scenario) for limit in each.limits]
        for row, after in zip(self.excesses, margins.all_after(self), strict=True):
            found += margins.tables(limits, row[None], [after])
        return found

    def remarks(self) -> list[str]:
        """Return how many plans of a front keep their objectives, and their limits to the end.

        And how near they come to the lower bound; the `notes` follow. Of a large front some plans
        are looked at.
        """
        if not len(self.X):
            return self.notes()
        rows = spread(len(self.X))
        some, these = self.take(rows), looked_at(rows, len(self.X))
        return [
            _objectives_kept(some, these),
            *margins.remarks(some, these),
            *lower_bound.remarks(self, some, these),
            *self.notes(),
        ]

    def ways_out(self) -> list[str]:
        """Return errors of which plans that miss requirements learn nothing."""
        return requirements.ways_out(self)

    def figures(self) -> dict[str, go.Figure]:
        """Return figures of the plans together; ``front`` for the paper's objectives."""
        from mgeo_attitude.view.figures.against_time import figures

        return figures(self)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Return small figures of each plan: rates, directions of Sun and field, errors."""
        import plotly.graph_objects as go

        return [
            {name: go.Figure(tree, _validate=False) for name, tree in trees.items()}
            for trees in self.drawings()
        ]

    def drawings(self) -> list[dict[str, dict[str, Any]]]:
        """Return the same as trees; see `single.drawings`."""
        from mgeo_attitude.view.figures.single import drawings

        return list(drawings(self))

    def review(self) -> Review:
        """Return the only plan as a document for a review; see `plan.tables.review`."""
        from mgeo_attitude.plan.plan import ManeuverPlan
        from mgeo_attitude.plan.tables import review

        return review(ManeuverPlan.from_design(self.problem, self.X[0], self.F[0]))

    def impossible(self) -> list[str]:
        """Return why no plan at all keeps the scenario's limits; see `lower_bound.impossible`."""
        return lower_bound.impossible(self.problem)

    def facts(self) -> dict[str, str]:
        """Return orbit, light, margins at rest and validity; see `satellite.facts`."""
        return satellite.facts(self.problem)

    def notes(self) -> list[str]:
        """Return what looks like a slip or is assumed, and where the covariance may be wrong."""
        scenario = self.problem.scenario
        found = [f"{line} (docs/consistency.md): verify a plan" for line in validity(scenario)]
        return [*implausible(scenario), *scenario.assumed, *found]

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """Count the points of a front that converge in the first orbit, and later.

        Empty for other objectives than the paper's.
        """
        if self.problem.objectives != PAPER:
            return {}
        return describe.front_summary(self.problem.scenario, np.atleast_2d(F))


def _objectives_kept(plans: Plans, these: str) -> str:
    """Count the plans that keep their objectives in most Monte Carlo runs."""
    names = list(plans.problem.obj_names)
    if plans.problem.model.ends_by_design:  # a time by design is kept by all
        names = [name for name in names if name != OBJECTIVES["t_end"].label] or names
    # false of NaN, too, where a covariance is lost
    in_time = plans.kept - plans.F <= TOLERANCE * np.abs(plans.F)
    keep = in_time.all(axis=1) & ~np.isinf(plans.kept_t_end)
    ratio = plans.promises()[f"kept / promised {names[0]}"]
    return (
        f"{keep.sum()} of {these} keep their objectives in {MOST_SAMPLES}, to {TOLERANCE:.0%}; "
        f"{names[0]} of these samples is {ratio.median():.3g} times the plan's in the median, "
        f"{ratio.max():.3g} at most"
    )
