"""Tables about one plan, as shown in the terminal, in review documents and in JSON output."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mgeo.plugins.review import Review, Section
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.view.plans import MONTE_CARLO_SHARE_TEXT
from mgeo_attitude.view.satellite import build_instrument_table, describe_satellite
from mgeo_attitude.view.summaries import format_nominal_suffix

#: Length of a time stamp without fractions of a second.
_STAMP_LENGTH = 19


@dataclass(frozen=True)
class PlanTable:
    """Definition of one table about a plan: its title, the function that computes it, and its
    display.

    Attributes
    ----------
    title : str
    table : function
        Returns the table of a plan with all columns, as in JSON.
    columns : function
        Returns the columns that the terminal and a review document show, as a table.
    note : function
        Returns a line of text for a plan, shown below the table.
    text : function
        Returns lines of text for a plan that interpret the table.
    is_wide : bool
        Whether a terminal shows the table transposed.
    """

    title: str
    table: Callable[[ManeuverPlan], pd.DataFrame]
    columns: Callable[[pd.DataFrame], pd.DataFrame] = pd.DataFrame.copy
    note: Callable[[ManeuverPlan], str] = lambda plan: ""
    text: Callable[[ManeuverPlan], list[str]] = lambda plan: []
    is_wide: bool = False

    def build_section(self, plan: ManeuverPlan) -> Section | None:
        """Return the table of a plan as a section of a review document, or None if the table has no
        rows.
        """
        table = self.columns(self.table(plan))
        if table.empty:
            return None
        return Section(self.title, tuple(self.text(plan)), table, self.note(plan))


def build_review(plan: ManeuverPlan) -> Review:
    """Return the document for the review of a plan: satellite, instruments, and all tables of the
    plan.
    """
    scenario = plan.scenario
    start, end = (
        text[:_STAMP_LENGTH]
        for text in format_time_stamps(scenario.epoch, np.array([0.0, plan.duration]))
    )
    facts = describe_satellite(plan.problem)
    return Review(
        f"{scenario.name}: calibration maneuvers, {start} to {end} UTC",
        plan.summary,
        (
            Section("Satellite", table=pd.DataFrame({"": facts.values()}, index=list(facts))),
            Section("Gyro and sensors", table=build_instrument_table(scenario)),
            *(section for each in TABLES.values() if (section := each.build_section(plan))),
        ),
    )


def _build_lower_bound_table(plan: ManeuverPlan) -> pd.DataFrame:
    try:
        return plan.compare_with_lower_bound()
    except NoLowerBoundError:
        return pd.DataFrame()


def _select_command_columns(table: pd.DataFrame) -> pd.DataFrame:
    rates = [f"rate {axis} [deg/s]" for axis in "xyz"]
    attitude = [f"end q{part}" for part in "123c"]
    columns = ["start [s]", "duration [s]", *rates, "rotation [deg]", *attitude]
    table = table.set_index("phase")
    return table[["start UTC"]].join(table[columns].map("{:.6g}".format))


def _reduce_to_worst_axis(table: pd.DataFrame) -> pd.DataFrame:
    """Replace the three columns x, y and z of each error by their largest value."""
    errors = table.iloc[:, 3:].T.groupby(lambda name: re.sub(" [xyz] ", " ", name), sort=False)
    return table.iloc[:, :3].join(errors.max().T)


def _format_constraints_note(plan: ManeuverPlan) -> str:
    errors = plan.scenario.monte_carlo
    if errors is None:
        return ""
    share = f"{errors.constraint_share:.0%} of {errors.n_runs} Monte Carlo runs"
    return f"values until t_end are satisfied in {share}; all other tables are of the nominal run"


def _format_objectives_note(plan: ManeuverPlan) -> str:
    text = (
        f"predicted: by the plan; Monte Carlo: in {MONTE_CARLO_SHARE_TEXT}, of 200 drawn from "
        "[monte_carlo]"
    )
    if not np.isinf([plan.view.monte_carlo_t_end, plan.view.robust_t_end]).any():
        return text
    longest = plan.problem.model.duration
    return f"{text}; a t_end of {longest:.6g} s means that the filter does not converge"


#: Tables about a plan by their keys in JSON output, in the order in which the terminal shows them.
TABLES = {
    "constraints": PlanTable(
        "Constraints",
        ManeuverPlan.build_constraint_table,
        lambda table: table.assign(satisfied=np.where(table["satisfied"], "satisfied", "violated")),
        _format_constraints_note,
    ),
    "monte_carlo": PlanTable(
        "Objectives in Monte Carlo runs",
        ManeuverPlan.compare_with_monte_carlo,
        note=_format_objectives_note,
    ),
    "timeline": PlanTable(
        "Timeline", ManeuverPlan.build_timeline, _select_command_columns, is_wide=True
    ),
    "accuracy": PlanTable(
        "Predicted 1-sigma",
        ManeuverPlan.build_accuracy_table,
        note=lambda plan: "of Monte Carlo runs" if plan.scenario.is_magnetorquer_driven else "",
    ),
    "worst_axis": PlanTable("Worst axis and lower bound", _build_lower_bound_table),
    "error_budget": PlanTable(
        "Error budget, 1-sigma of the worst body axis",
        ManeuverPlan.compute_error_budget,
        note=lambda plan: (
            "with the filter's gains; the last row is the root sum square of the contributions"
            + format_nominal_suffix(plan.scenario)
        ),
        text=ManeuverPlan.describe_error_drivers,
    ),
    "improvements": PlanTable(
        "Improvements, 1-sigma of the worst body axis",
        ManeuverPlan.evaluate_improvements,
        note=lambda plan: "each row is one run of the filter; constraints are not evaluated",
    ),
    "measurement_times": PlanTable(
        "Measurement time of the sensors", ManeuverPlan.compute_measurement_times
    ),
    "uncertainty_by_phase": PlanTable(
        "Uncertainty reduction by phase",
        ManeuverPlan.compute_uncertainty_by_phase,
        _reduce_to_worst_axis,
        note=lambda plan: "trace and worst body axis at the end of each phase",
        is_wide=True,
    ),
    "least_observable": PlanTable(
        "Least observable directions",
        lambda plan: plan.find_least_observable(5),
        lambda table: table.iloc[:, 1::-1],
        note=lambda plan: "remaining: final over initial 1-sigma; 1 for an unobserved direction",
    ),
    "comparison": PlanTable(
        "Comparison with plans that need no optimizer",
        ManeuverPlan.compare_with_designs,
        note=lambda plan: (
            f"after {plan.t_end:.6g} s; 1-sigma of the worst body axis; t_end: convergence of "
            "each plan"
        ),
        is_wide=True,
    ),
}
