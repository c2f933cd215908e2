"""Sections about one plan, as shown in the terminal, on pages, in review documents and in JSON."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mgeo._text import format_duration
from mgeo.plugins.review import Review, Section, format_bounds
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.filter.error_budget import GYRO_NOISE
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.maneuvers.motion import HOLD_LABEL, RAMP_PREFIX
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.summary import describe_plan, list_warnings
from mgeo_attitude.plan_sections import FIRST_PAGE, SECTION_KEYS, SUMMARY
from mgeo_attitude.view.margins import INTERVALS_AFTER_CONVERGENCE
from mgeo_attitude.view.observability.error_budget import TOTAL
from mgeo_attitude.view.observability.improvements import EXTRA_DURATION_PREFIX, UNCHANGED
from mgeo_attitude.view.overview import build_maneuver_table
from mgeo_attitude.view.satellite import build_instrument_table, describe_satellite

#: Length of a time stamp without fractions of a second.
_STAMP_LENGTH = 19
#: Part of the labels of constraints that apply after the slew back.
_AFTER_SLEW_BACK = " after the slew back"
#: Number of least observable directions.
_N_DIRECTIONS = 5


@dataclass(frozen=True)
class PlanSection:
    """Template of a report section about a plan: title, table, note and displayed columns.

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
    """Build the requested report sections about a plan, in the order of `SECTION_KEYS`.

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
    """Build a review document with all report sections about a plan."""
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
    """Return the constraint table of a plan, with a column that states when each constraint
    applies.
    """
    table = plan.build_constraint_table().reset_index()
    during = pd.Series("maneuvers", table.index)
    for interval in INTERVALS_AFTER_CONVERGENCE:
        is_after = table["constraint"].str.endswith(f" {interval}")
        during[is_after] = interval.removeprefix("in the ").replace(HOLD_LABEL, "hold")
        table["constraint"] = table["constraint"].str.removesuffix(f" {interval}")
    is_final = table["constraint"].str.contains(_AFTER_SLEW_BACK, regex=False)
    during[is_final] = _AFTER_SLEW_BACK.replace(" the", "").strip()
    table["constraint"] = (
        table["constraint"]
        .str.replace(_AFTER_SLEW_BACK, "", regex=False)
        .replace({each.label: each.bound_label for each in plan.scenario.path_constraints})
    )
    table.insert(1, "during", during)
    return table.set_index("constraint")


def _select_constraint_columns(table: pd.DataFrame) -> pd.DataFrame:
    bounds = format_bounds(table["bound_type"], table["bound_value"].map("{:.4g}".format))
    result = np.where(table["satisfied"], "satisfied", "VIOLATED")
    columns = table[["unit", "value"]].assign(bound=bounds, margin=table["margin"])
    if not table["satisfied"].all():
        columns["result"] = result
    if table["during"].nunique() > 1:
        columns.insert(0, "during", table["during"])
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
            f" During the maneuvers, {100.0 * errors.constraint_share:.0f} % of {errors.n_runs} "
            "Monte Carlo runs have this value or a more favorable one. Hold and slew back are "
            "evaluated in the nominal run."
        )
    return text


def _build_timeline(plan: ManeuverPlan) -> pd.DataFrame:
    table = build_maneuver_table(plan.view)
    starts = format_time_stamps(plan.scenario.epoch, table["start [s]"].to_numpy())
    return table.assign(**{"start UTC": starts})


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
        text += " The duration includes the ramp to the rates."
    maneuvers = {
        label for name in labels if "maneuver" in (label := name.removeprefix(RAMP_PREFIX))
    }
    if len(maneuvers) < plan.scenario.maneuvers.count:
        text += " Maneuvers without duration are omitted."
    text += " Most reduced: quantity whose 1-sigma is divided by the largest factor."
    if any(label.startswith(HOLD_LABEL) for label in labels):
        text += " Hold: the satellite keeps the last rates."
    return text


def _describe_accuracy(plan: ManeuverPlan) -> str:
    predicted = (
        f"root mean square of {plan.view.n_monte_carlo_runs} Monte Carlo runs"
        if plan.scenario.is_magnetorquer_driven
        else "nominal run, without random errors"
    )
    nominal = ", when the nominal run converges" if plan.scenario.monte_carlo else ""
    text = (
        "1-sigma about the worst body axis, before the plan and after "
        f"{format_duration(plan.t_end)}{nominal}. Predicted: {predicted}. 90 % of runs: not "
        f"exceeded in 90 % of {plan.view.n_monte_carlo_runs} Monte Carlo runs with random errors "
        "of attitude and rates."
    )
    if "lower bound" in plan.accuracy:
        text += " Lower bound: for any maneuver of this duration. Ratio: predicted / lower bound."
    return text


def _build_axes_table(plan: ManeuverPlan) -> pd.DataFrame:
    """Return the 1-sigma about each body axis before and after a plan, one row per quantity."""
    table = plan.build_accuracy_table()
    names = [str(name)[:-2] for name in table.index[::3]]
    columns: dict[str, object] = {"unit": table["unit"].to_numpy()[::3]}
    for name in ("before", "after"):
        values = table[name].to_numpy().reshape(-1, 3)
        columns |= {f"{name} {axis}": values[:, i] for i, axis in enumerate("xyz")}
    return pd.DataFrame(columns, pd.Index(names, name="quantity"))


def _describe_run(plan: ManeuverPlan) -> str:
    """Return a note on the simulated run behind the values of a table.

    Only scenarios with magnetorquer-driven motion or with Monte Carlo runs need a note. Otherwise,
    the note is empty.
    """
    if plan.scenario.is_magnetorquer_driven:
        return (
            " The values apply without initial attitude error, which changes the motion of a "
            "satellite with magnetorquers. The predicted accuracy includes this error."
        )
    return " The values are those of the nominal run." if plan.scenario.monte_carlo else ""


def _select_axes_columns(table: pd.DataFrame) -> pd.DataFrame:
    before = table[[f"before {axis}" for axis in "xyz"]]
    if (before.nunique(axis=1) > 1).any():
        return table
    columns = table.drop(columns=before.columns)
    columns.insert(1, "before", before["before x"])
    return columns


def _compute_budget_shares(table: pd.DataFrame) -> pd.DataFrame:
    """Convert the 1-sigmas of an error budget to shares of the variance [%]."""
    shares = 100.0 * (table.drop(TOTAL) / table.loc[TOTAL]) ** 2
    names = [re.sub(r" \[.*", " [%]", name) for name in map(str, table)]
    shares = shares.set_axis(names, axis=1).rename_axis("error source")
    return _format_columns(shares, "", "{:.1f}")


def _name_halved_sources(table: pd.DataFrame) -> pd.DataFrame:
    """Add "half" to the names of rows in which an error source is halved."""
    others = (UNCHANGED, EXTRA_DURATION_PREFIX)
    return table.rename(index=lambda name: name if name.startswith(others) else f"half {name}")


def _format_times(table: pd.DataFrame) -> pd.DataFrame:
    """Convert time columns to text, so that times are not rounded to three digits."""
    return _format_columns(table, r"\[s\]$", "{:.6g}")


def _format_columns(table: pd.DataFrame, pattern: str, template: str) -> pd.DataFrame:
    """Convert the columns whose title matches a pattern to text."""
    names = [name for name in map(str, table) if re.search(pattern, name)]
    return table.assign(**{name: table[name].map(template.format) for name in names})


def _select_reduction_columns(table: pd.DataFrame) -> pd.DataFrame:
    """Replace the columns x, y and z of each error with one column of their largest values."""
    errors = table.iloc[:, 3:].T.groupby(lambda name: re.sub(" [xyz] ", " ", name), sort=False)
    first = table[["time [s]", "contribution [%]"]].set_axis(["end [s]", "share [%]"], axis=1)
    return _format_times(first.join(errors.max().T))


def _select_attitude_columns(table: pd.DataFrame) -> pd.DataFrame:
    quaternion = [f"end q{part}" for part in "123c"]
    ends = table["end UTC"].str[:_STAMP_LENGTH]
    shown = table.assign(**{"end UTC": ends}).set_index("phase")[["end UTC", *quaternion]]
    return shown.rename_axis("maneuver")


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
    text = (
        "Trace: weighted sum of the variances of all errors; a plan with a smaller trace can have "
        "a larger attitude 1-sigma. No maneuver of this duration has a smaller trace than the "
        "lower bound."
    )
    if relaxations:
        text += (
            " Simplifications that make the bound smaller than necessary: "
            f"{'; '.join(relaxations)}."
        )
    return text


def _build_monte_carlo_table(plan: ManeuverPlan) -> pd.DataFrame:
    table = plan.compare_with_monte_carlo().rename(index=plan.view.format_title)
    return table.set_axis(["predicted", "90 % of runs", "ratio"], axis=1)


def _describe_monte_carlo(plan: ManeuverPlan) -> str:
    errors = plan.scenario.monte_carlo
    text = "Predicted: nominal run, without random errors."
    if errors is not None:
        runs = f"the {errors.n_runs} Monte Carlo runs of the search"
        text = f"Predicted: value that {100.0 * errors.quantile:g} % of {runs} do not exceed."
        if errors.mean:
            text = f"Predicted: mean over {runs}."
    other = "other " if errors else ""
    text += (
        f" 90 % of runs: value that 90 % of {plan.view.n_monte_carlo_runs} {other}Monte Carlo runs "
        "do not exceed."
    )
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
            "Error sources with the largest share of the variance about the worst body axis. If "
            "halved: 1-sigma after the same maneuvers if this noise, drift or initial error is "
            f"half as large and the filter is tuned to it.{_describe_run(plan)}"
        ),
        lambda table: table.rename(columns={"predicted": "1-sigma"}),
    ),
    "axes": PlanSection(
        "Accuracy about each body axis",
        _build_axes_table,
        lambda plan: (
            "1-sigma about body x, y and z, before the plan and predicted after "
            f"{format_duration(plan.t_end)}."
        ),
        _select_axes_columns,
    ),
    "budget": PlanSection(
        "Error budget",
        ManeuverPlan.compute_error_budget,
        lambda plan: (
            "Share of each error source in the variance of the worst body axis after "
            f"{format_duration(plan.t_end)}. {GYRO_NOISE.capitalize()}: angle random walk."
            f"{_describe_run(plan)}"
        ),
        _compute_budget_shares,
    ),
    "improvements": PlanSection(
        "Possible improvements",
        ManeuverPlan.evaluate_improvements,
        lambda plan: (
            "1-sigma about the worst body axis after one change. Half: this noise, drift or "
            "initial error is half as large and the filter is tuned to it. 300 s more: the plan "
            "continues at the last rates, or with a rotation about a body axis. Constraints are "
            "not evaluated."
            f"{_describe_run(plan)}"
        ),
        _name_halved_sources,
    ),
    "reduction": PlanSection(
        "Uncertainty reduction by maneuver",
        lambda plan: plan.compute_uncertainty_by_phase().rename_axis("maneuver"),
        lambda plan: (
            "1-sigma about the worst body axis at the end of each maneuver. Share: contribution of "
            "the maneuver to the total decrease of the logarithm of the trace."
            f"{_describe_run(plan)}"
        ),
        _select_reduction_columns,
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
        lambda plan: plan.compute_measurement_times().rename_axis("maneuver"),
        lambda plan: "Time in each maneuver during which the sensor provides measurements.",
        _format_times,
    ),
    "comparison": PlanSection(
        "Comparison with simple maneuvers",
        _build_comparison_table,
        lambda plan: (
            "1-sigma about the worst body axis after the same time, for maneuvers that need no "
            "optimization, such as a rotation about one body axis after the other. Trace ratio: "
            f"trace divided by the trace of the plan.{_describe_run(plan)}"
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
            "Quaternion of the rotation from GCRF to body axes at the end of each maneuver, with "
            "the scalar part qc last."
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
