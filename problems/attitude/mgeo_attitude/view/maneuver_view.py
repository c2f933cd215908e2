"""All that is shown of plans of the satellite problem."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude.criteria.constraints import constraints
from mgeo_attitude.criteria.objectives import OBJECTIVES
from mgeo_attitude.scenario.settings import PAPER
from mgeo_attitude.scenario.validity import implausible, validity
from mgeo_attitude.view import at_best, describe, requirements
from mgeo_attitude.view.plans import MOST_SAMPLES, Plans, looked_at, spread

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go

    from mgeo.plugins.shown import Review

#: By what share of a promise it may be missed.
TOLERANCE = 0.1


class ManeuverView(Plans):
    """Plans, shape (n, n_var), as people are shown them.

    See `mgeo.View` for what each method is, and `Plans` for what is known of them besides.
    """

    def describe(self) -> pd.DataFrame:
        """Each plan, one row, in an engineer's terms; see `describe.describe`."""
        return describe.describe(self)

    def glance(self) -> pd.DataFrame:
        """Of it what one run of the filter tells; see `describe.glance`."""
        return describe.glance(self)

    def answers(self) -> list[str]:
        """What each plan is worth, in one line; see `mgeo_attitude.view.describe`."""
        return describe.answers(self)

    def limits(self) -> list[pd.DataFrame]:
        """The scenario's limits and each plan's margins; see `margins.tables`.

        Where plans are judged over flights, a value is what the demanded share of them keeps.
        Path limits, and the budget of wheels, have a row each for the time after the filter has
        converged, too, in which the last rate is held for late flights or the body slews back. No
        search sees these.
        """
        from mgeo_attitude.view.margins import all_after, tables  # compiles

        problem = self.problem
        excesses = self.values[:, problem.n_obj + problem.n_ieq_constr :]
        found = []
        limits = [limit for each in constraints(problem.scenario) for limit in each.limits]
        for row, after in zip(excesses, all_after(self), strict=True):
            found += tables(limits, row[None], [after])
        return found

    def remarks(self) -> list[str]:
        """How many plans of a front keep their objectives, and their limits to the end.

        And how near they come to what no maneuver can beat; the `notes` follow. Of a large front
        some are looked at.
        """
        from mgeo_attitude.view import margins  # compiles

        if not len(self.X):
            return self.notes()
        rows = spread(len(self.X))
        some, these = self.take(rows), looked_at(rows, len(self.X))
        return [
            *_promises_kept(some, these),
            *margins.remarks(some, these),
            *_late_ends(some, these),
            *requirements.remarks(some, these),
            *at_best.remarks(self, some, these),
            *self.notes(),
        ]

    def ways_out(self) -> list[str]:
        """Errors of which plans that miss requirements learn nothing; `requirements.ways_out`."""
        return requirements.ways_out(self)

    def figures(self) -> dict[str, go.Figure]:
        """Interactive figures of the plans together; ``front`` for the paper's objectives."""
        from mgeo_attitude.view.figures.against_time import figures

        return figures(self)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """For each plan its own small figures: rates, directions of Sun and field, errors."""
        import plotly.graph_objects as go

        return [
            {name: go.Figure(tree, _validate=False) for name, tree in trees.items()}
            for trees in self.drawings()
        ]

    def drawings(self) -> list[dict[str, dict[str, Any]]]:
        """The same as trees; see `single.drawings`."""
        from mgeo_attitude.view.figures.single import drawings

        return list(drawings(self))

    def review(self) -> Review:
        """The only plan as a document for a review; see `review.review`."""
        from mgeo_attitude.view.review import review

        return review(self)

    def impossible(self) -> list[str]:
        """Why no plan at all keeps the scenario's limits; see `at_best.impossible`."""
        return at_best.impossible(self.problem)

    def facts(self) -> dict[str, str]:
        """Orbit, light, margins at rest, where the covariance is believed; `satellite.facts`."""
        from mgeo_attitude.view import satellite

        return satellite.facts(self.problem)

    def notes(self) -> list[str]:
        """What looks like a slip or is assumed, and where the covariance was not found true."""
        scenario = self.problem.scenario
        found = [f"{line} (docs/consistency.md): verify a plan" for line in validity(scenario)]
        return [*implausible(scenario), *scenario.assumed, *found]

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """How many points of a front converge in the first orbit, and how many later.

        Nothing is said of a front of other objectives than the paper's.
        """
        if self.problem.objectives != PAPER:
            return {}
        values = np.atleast_2d(np.asarray(F, dtype=float))
        return describe.front_summary(self.problem.scenario, values)


def _promises_kept(plans: Plans, these: str) -> list[str]:
    """How many plans keep their objectives in most samples."""
    promised, names = plans.promised, list(plans.problem.obj_names)
    if plans.problem.model.ends_by_design:  # a time by design is kept by all
        names = [name for name in names if name != OBJECTIVES["t_end"].label] or names
    label = names[0]
    # false of NaN, too, where a covariance is lost
    in_time = plans.kept - promised <= TOLERANCE * np.abs(promised)
    endless = [found.kept == math.inf for found in plans.times]
    keep = in_time.all(axis=1) & ~np.array(endless)
    ratio = plans.promises()[f"kept / promised {label}"]
    return [
        f"{keep.sum()} of {these} keep their objectives in {MOST_SAMPLES}, to {TOLERANCE:.0%}; "
        f"{label} of these samples is {ratio.median():.3g} times the plan's in the median, "
        f"{ratio.max():.3g} at most"
    ]


def _late_ends(plans: Plans, these: str) -> list[str]:
    """How many plans slew back beyond the scenario's duration."""
    scenario = plans.problem.scenario
    if not scenario.maneuvers.slew_back:
        return []
    late = [end for end in plans.ends.tolist() if scenario.duration < end < math.inf]
    if not late:
        return []
    return [
        f"duration = {scenario.duration:.6g} s limits the time to converge, it is no window: "
        f"{len(late)} of {these} slew back later, until {max(late):.6g} s at most"
    ]
