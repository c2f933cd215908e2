"""Sections about one plan, as shown in the terminal, on pages, in review documents and in JSON."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mgeo.plugins.review import Review, Section
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.filter.error_budget import GYRO_NOISE
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.maneuvers.motion import HOLD_LABEL, RAMP_PREFIX
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.summary import describe_plan, list_warnings
from mgeo_attitude.plan_sections import FIRST_PAGE, SECTION_KEYS, SUMMARY
from mgeo_attitude.view.margins import INTERVALS_AFTER_CONVERGENCE
from mgeo_attitude.view.observability.error_budget import TOTAL
from mgeo_attitude.view.overview import build_maneuver_table
from mgeo_attitude.view.satellite import build_instrument_table, describe_satellite
from mgeo_attitude.view.summaries import format_nominal_suffix

#: Length of a time stamp without fractions of a second.
_STAMP_LENGTH = 19
#: Number of least observable directions.
_N_DIRECTIONS = 5


@dataclass(frozen=True)
class PlanSection:
    """Definition of one section about a plan: its title, the function that computes its table, and
    its display.

    Attributes
    ----------
    title : str
    table : function
        Returns the table of a plan with all columns, as in JSON.
    note : function
        Returns the text below the table, which says what the table shows.
    columns : function
        Returns the columns that terminal and pages show, as a table.
    """

    title: str
    table: Callable[[ManeuverPlan], pd.DataFrame]
    note: Callable[[ManeuverPlan], str]
    columns: Callable[[pd.DataFrame], pd.DataFrame] = lambda table: table


def build_sections(plan: ManeuverPlan, keys: Collection[str] = SECTION_KEYS) -> list[Section]:
    """Return sections about a plan in the order of `SECTION_KEYS`.

    Parameters
    ----------
    plan : ManeuverPlan
    keys : collection of str
        Names of the sections.

    Returns
    -------
    list of Section
    """
    sections = []
    if SUMMARY in keys:
        sections.append(Section("Summary", tuple(describe_plan(plan)), key=SUMMARY))
    for key, each in SECTIONS.items():
        if key in keys:
            table, note, is_detail = each.table(plan), each.note(plan), key not in FIRST_PAGE
            if table.empty:  # The note has the reason.
                sections.append(Section(each.title, (note,), key=key, is_detail=is_detail))
            else:
                columns = each.columns(table)
                sections.append(
                    Section(each.title, (), columns, note, key=key, is_detail=is_detail)
                )
    return sections


def build_review(plan: ManeuverPlan) -> Review:
    """Return the document for the review of a plan, with all sections about the plan."""
    start, end = (
        text[:_STAMP_LENGTH]
        for text in format_time_stamps(plan.scenario.epoch, np.array([0.0, plan.duration]))
    )
    title = f"{plan.scenario.name}: calibration maneuvers"
    summary, *sections = build_sections(plan)
    warnings = tuple(list_warnings(plan))
    first = [Section("Warnings", warnings, key="warnings")] if warnings else []
    text = " ".join((*summary.lines, f"From {start} to {end} UTC."))
    return Review(title, text, (*first, *sections))


def _build_constraint_table(plan: ManeuverPlan) -> pd.DataFrame:
    """Return the table of `ManeuverPlan.build_constraint_table` with the phase of each row."""
    table = plan.build_constraint_table().reset_index()
    phase = pd.Series("maneuvers", table.index)
    for interval in INTERVALS_AFTER_CONVERGENCE:
        is_after = table["constraint"].str.endswith(f" {interval}")
        phase[is_after] = interval.removeprefix("in the ").replace(HOLD_LABEL, "hold")
        table["constraint"] = table["constraint"].str.removesuffix(f" {interval}")
    table.insert(1, "phase", phase)
    return table.set_index("constraint")


def _select_constraint_columns(table: pd.DataFrame) -> pd.DataFrame:
    kinds = table["bound_type"].map({"at most": "max", "at least": "min"})
    bounds = kinds + table["bound_value"].map(" {:.4g}".format)
    result = np.where(table["satisfied"], "satisfied", "VIOLATED")
    columns = table[["unit", "value"]].assign(bound=bounds, margin=table["margin"])
    if not table["satisfied"].all():
        columns["result"] = result
    if table["phase"].nunique() > 1:
        columns.insert(0, "phase", table["phase"])
    return columns


def _describe_constraints(plan: ManeuverPlan) -> str:
    if plan.build_constraint_table().empty:
        return "The scenario has no constraints."
    text = "Margin: distance from the bound; negative if the constraint is violated."
    if any(each.attitude_sigmas for each in plan.scenario.path_constraints):
        text += (
            ' "minus 3 sigma" and "plus 3 sigma": the angle is reduced or increased by three '
            "times the attitude 1-sigma."
        )
    errors = plan.scenario.monte_carlo
    if errors is not None:
        text += (
            f" Values of maneuvers hold in {100.0 * errors.constraint_share:.0f} % of "
            f"{errors.n_runs} Monte Carlo runs."
        )
    return text


def _build_timeline(plan: ManeuverPlan) -> pd.DataFrame:
    table = build_maneuver_table(plan.view)
    starts = format_time_stamps(plan.scenario.epoch, table["start [s]"].to_numpy())
    return table.assign(**{"start UTC": starts}).rename_axis("phase")


def _format_timeline(table: pd.DataFrame) -> pd.DataFrame:
    columns = _format_times(_format_columns(table, "^ω", "{:+.2f}"))
    return columns.drop(columns="start UTC")


def _describe_timeline(plan: ManeuverPlan) -> str:
    (epoch,) = format_time_stamps(plan.scenario.epoch, np.zeros(1))
    text = (
        f"Start: time after {epoch[:_STAMP_LENGTH]} UTC. ω: commanded body rates. Angle: "
        "accumulated rotation."
    )
    labels = [phase.label for phase in plan.phases]
    if any(label.startswith(RAMP_PREFIX) for label in labels):
        text += " A maneuver begins with the ramp to its rates."
    if any(label.startswith(HOLD_LABEL) for label in labels):
        text += " Hold: the last rates are held."
    return text


def _describe_accuracy(plan: ManeuverPlan) -> str:
    predicted = (
        "root mean square of 200 Monte Carlo runs"
        if plan.scenario.is_magnetorquer_driven
        else "from the filter's covariance"
    )
    text = (
        f"1-sigma about the worst body axis. Predicted: {predicted}. 90 % of runs: not exceeded in "
        "90 % of 200 Monte Carlo runs."
    )
    if "lower bound" in plan.accuracy:
        text += " Lower bound: for any maneuver of this duration. Ratio: predicted / lower bound."
    return text


def _build_axes_table(plan: ManeuverPlan) -> pd.DataFrame:
    """Return the 1-sigma of each body axis before and after a plan, one row per 3-vector."""
    table = plan.build_accuracy_table()
    names = [str(name)[:-2] for name in table.index[::3]]
    columns: dict[str, object] = {"unit": table["unit"].to_numpy()[::3]}
    for name in ("before", "after"):
        values = table[name].to_numpy().reshape(-1, 3)
        columns |= {f"{name} {axis}": values[:, i] for i, axis in enumerate("xyz")}
    return pd.DataFrame(columns, pd.Index(names, name="quantity"))


def _name_run(plan: ManeuverPlan) -> str:
    return " in the nominal run" if format_nominal_suffix(plan.scenario) else ""


def _select_axes_columns(table: pd.DataFrame) -> pd.DataFrame:
    before = table[[f"before {axis}" for axis in "xyz"]]
    if (before.nunique(axis=1) > 1).any():
        return table
    columns = table.drop(columns=before.columns)
    columns.insert(1, "before", before["before x"])
    return columns


def _compute_budget_shares(table: pd.DataFrame) -> pd.DataFrame:
    """Convert the 1-sigmas of an error budget to shares of the variances [%]."""
    shares = 100.0 * (table.drop(TOTAL) / table.loc[TOTAL]) ** 2
    names = [re.sub(r" \[.*", " [%]", name) for name in map(str, table)]
    shares = shares.set_axis(names, axis=1).rename_axis("error source")
    return _format_columns(shares, "", "{:.1f}")


def _format_times(table: pd.DataFrame) -> pd.DataFrame:
    """Convert the columns of times to text, because times are not rounded to three digits."""
    return _format_columns(table, r"\[s\]$", "{:.6g}")


def _format_columns(table: pd.DataFrame, pattern: str, template: str) -> pd.DataFrame:
    """Convert the columns of which the title matches a pattern to text."""
    names = [name for name in map(str, table) if re.search(pattern, name)]
    return table.assign(**{name: table[name].map(template.format) for name in names})


def _select_phase_columns(table: pd.DataFrame) -> pd.DataFrame:
    """Replace the three columns x, y and z of each error by their largest value."""
    errors = table.iloc[:, 3:].T.groupby(lambda name: re.sub(" [xyz] ", " ", name), sort=False)
    first = table[["time [s]", "contribution [%]"]].set_axis(["end [s]", "share [%]"], axis=1)
    return _format_times(first.join(errors.max().T)).rename_axis("phase")


def _select_attitude_columns(table: pd.DataFrame) -> pd.DataFrame:
    quaternion = [f"end q{part}" for part in "123c"]
    ends = table["end UTC"].str[:_STAMP_LENGTH]
    return table.assign(**{"end UTC": ends}).set_index("phase")[["end UTC", *quaternion]]


def _build_comparison_table(plan: ManeuverPlan) -> pd.DataFrame:
    table = plan.compare_with_designs().rename_axis("maneuvers")
    return table.rename(columns={"trace / first trace [-]": "trace ratio"})


def _select_comparison_columns(table: pd.DataFrame) -> pd.DataFrame:
    errors = [name for name in map(str, table) if " 1-sigma " in name]
    columns = table[["trace ratio", *errors]]
    return columns.rename(columns=lambda name: name.replace(" 1-sigma", ""))


def _describe_lower_bound(plan: ManeuverPlan) -> str:
    try:
        relaxations = plan.problem.lower_bound.relaxations
    except NoLowerBoundError as reason:
        return f"No lower bound can be proved: {reason}."
    text = "No maneuver of this duration has a smaller trace than the lower bound."
    if relaxations:
        text += (
            " Simplifications that make the bound smaller than necessary: "
            f"{'; '.join(relaxations)}."
        )
    return text


def _build_monte_carlo_table(plan: ManeuverPlan) -> pd.DataFrame:
    return plan.compare_with_monte_carlo().set_axis(["predicted", "90 % of runs", "ratio"], axis=1)


def _describe_monte_carlo(plan: ManeuverPlan) -> str:
    text = "90 % of runs: not exceeded in 90 % of 200 Monte Carlo runs with random errors."
    if np.isinf([plan.view.monte_carlo_t_end, plan.view.robust_t_end]).any():
        longest = plan.problem.model.duration
        text += f" A time of {longest:.6g} s means that the filter does not converge."
    return text


def _build_satellite_table(plan: ManeuverPlan) -> pd.DataFrame:
    facts = describe_satellite(plan.problem)
    return pd.DataFrame({"description": facts.values()}, pd.Index(facts, name="topic"))


#: Sections about a plan, except the summary, in the order of `SECTION_KEYS`.
SECTIONS = {
    "constraints": PlanSection(
        "Constraints",
        _build_constraint_table,
        _describe_constraints,
        _select_constraint_columns,
    ),
    "timeline": PlanSection("Timeline", _build_timeline, _describe_timeline, _format_timeline),
    "accuracy": PlanSection(
        "Predicted accuracy",
        lambda plan: plan.accuracy,
        _describe_accuracy,
    ),
    "drivers": PlanSection(
        "Accuracy drivers",
        ManeuverPlan.find_error_drivers,
        lambda plan: (
            "Largest error sources of the 1-sigma about the worst body axis"
            f"{_name_run(plan)}, with their share of the variance. If halved: 1-sigma that the "
            "same maneuvers give with half of the error source."
        ),
    ),
    "axes": PlanSection(
        "Accuracy about each body axis",
        _build_axes_table,
        lambda plan: "1-sigma about body x, y and z before the plan, and predicted after it.",
        _select_axes_columns,
    ),
    "budget": PlanSection(
        "Error budget",
        ManeuverPlan.compute_error_budget,
        lambda plan: (
            "Share of each error source in the variance of the worst body axis at convergence, "
            f"with the gains of the filter. {GYRO_NOISE.capitalize()}: angle random walk."
        ),
        _compute_budget_shares,
    ),
    "improvements": PlanSection(
        "Possible improvements",
        ManeuverPlan.evaluate_improvements,
        lambda plan: (
            "1-sigma of the worst body axis if the error source in the row were halved, or if the "
            "plan were longer: with more time at the last rate or with a rotation about a body "
            "axis. Constraints are not evaluated."
        ),
    ),
    "phases": PlanSection(
        "Uncertainty reduction by phase",
        lambda plan: plan.compute_uncertainty_by_phase().rename_axis("phase"),
        lambda plan: (
            "1-sigma of the worst body axis at the end of each phase. Share: contribution of the "
            "phase to the total decrease of the logarithm of the trace."
        ),
        _select_phase_columns,
    ),
    "directions": PlanSection(
        "Least observable directions",
        lambda plan: plan.find_least_observable(_N_DIRECTIONS),
        lambda plan: (
            "Combinations of errors of which the largest share of the initial 1-sigma remains. "
            "100 % means that the maneuvers do not make the combination observable."
        ),
        lambda table: pd.DataFrame(
            {"remaining [%]": 100.0 * table["remaining [-]"], "direction": table["direction"]}
        ),
    ),
    "measurements": PlanSection(
        "Measurement times",
        lambda plan: plan.compute_measurement_times().rename_axis("phase"),
        lambda plan: "Time in each phase during which the sensor provides measurements.",
        _format_times,
    ),
    "comparison": PlanSection(
        "Comparison with simple maneuvers",
        _build_comparison_table,
        lambda plan: (
            "1-sigma of the worst body axis after the same time for maneuvers that need no "
            "optimization, such as a rotation about one body axis after the other. Trace ratio: "
            "trace over the trace of the plan."
        ),
        _select_comparison_columns,
    ),
    "bound": PlanSection(
        "Lower bound of the trace",
        ManeuverPlan.compare_trace_with_lower_bound,
        _describe_lower_bound,
    ),
    "objectives": PlanSection(
        "Objectives in Monte Carlo runs",
        _build_monte_carlo_table,
        _describe_monte_carlo,
    ),
    "attitudes": PlanSection(
        "Attitudes",
        ManeuverPlan.build_timeline,
        lambda plan: (
            "Quaternion of the rotation from GCRF to body axes at the end of each phase, scalar "
            "part qc last."
        ),
        _select_attitude_columns,
    ),
    "satellite": PlanSection(
        "Satellite and orbit",
        _build_satellite_table,
        lambda plan: "Properties of the scenario on which the predictions are based.",
    ),
    "instruments": PlanSection(
        "Gyro and sensors",
        lambda plan: build_instrument_table(plan.scenario).rename_axis("instrument"),
        lambda plan: "Noise, sample interval and initial 1-sigma errors of each instrument.",
    ),
}
