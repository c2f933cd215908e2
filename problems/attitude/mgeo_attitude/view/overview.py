"""Overview of one plan: when it ends, its accuracy, its constraints and its maneuvers."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import groupby

import numpy as np
import pandas as pd

from mgeo._text import format_duration
from mgeo.plugins.review import Section
from mgeo.plugins.view import MAX_ROWS, build_constraint_section
from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.history import run_filter
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.maneuvers.motion import (
    AFTER_CONVERGENCE_SUFFIX,
    HOLD_LABEL,
    RAMP_PREFIX,
    Phase,
)
from mgeo_attitude.maneuvers.schedule import get_durations
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.trajectory.trajectory import Trajectory
from mgeo_attitude.view.margins import (
    INTERVALS_AFTER_CONVERGENCE,
    has_constraints_after_convergence,
)
from mgeo_attitude.view.plans import MONTE_CARLO_SHARE, Plans
from mgeo_attitude.view.summaries import describe_ends

#: Number of quantities that a terminal shows if there are more than `MAX_ROWS`.
_MAX_QUANTITIES = 5
#: Command whose output has all rows of the tables.
_SHOW_COMMAND = "mgeo attitude show"
_DECIMALS = {"start [s]": 0, "duration [s]": 0, "angle [deg]": 0} | {
    f"ω{axis} [deg/s]": 2 for axis in "xyz"
}


def build_overview(plans: Plans) -> dict[str, Section]:
    """Return the end, accuracy, constraints and maneuvers of a plan as sections. `plans` contains
    this plan only.
    """
    (end,) = describe_ends(plans)
    if not math.isfinite(plans.nominal.t_end[0]):
        return {"end": Section("", (f"{end}.",))}
    (constraints,) = plans.constraints()
    text = f"{end}. {_describe_robust_values(plans)}"
    if constraints.empty:
        text += "The scenario has no constraints. "
    maneuvers = build_maneuver_table(plans)
    text += _describe_omitted_maneuvers(plans, maneuvers)
    sections = {"end": Section("", (text.strip(),)), "accuracy": _build_accuracy_section(plans)}
    if len(constraints):
        section = build_constraint_section(_add_phases(constraints, plans.problem.scenario))
        sections["constraints"] = replace(
            section,
            full_command=_SHOW_COMMAND,
            note=_describe_constraint_values(plans.problem.scenario),
        )
    note = _describe_phases(plans, maneuvers)
    sections["maneuvers"] = Section("Maneuver", (), maneuvers, note, _DECIMALS, MAX_ROWS)
    return sections


def _add_phases(constraints: pd.DataFrame, scenario: Scenario) -> pd.DataFrame:
    """Add "in the maneuvers" to each constraint that further rows apply to later phases."""
    constraints = constraints.rename(
        index={each.bound_label: each.label for each in scenario.path_constraints}
    )
    labels = set(constraints.index)

    def add_phase(label: str) -> str:
        is_repeated = any(f"{label} {later}" in labels for later in INTERVALS_AFTER_CONVERGENCE)
        return f"{label} in the maneuvers" if is_repeated else label

    return constraints.rename(index=add_phase)


def _describe_constraint_values(scenario: Scenario) -> str:
    sentences, settings = [], scenario.monte_carlo
    if settings is not None:
        share = settings.constraint_share
        part = "" if share == 1.0 else f"the best {100.0 * share:g} % of "
        later = "; hold and slew back: nominal run"
        sentences.append(
            f"Value: worst of {part}the {settings.n_runs} Monte Carlo runs"
            f"{later if has_constraints_after_convergence(scenario) else ''}."
        )
    if any(each.attitude_sigmas for each in scenario.path_constraints):
        sentences.append("Angles include the margin for the attitude error.")
    return " ".join(sentences)


def _describe_robust_values(plans: Plans) -> str:
    settings = plans.problem.scenario.monte_carlo
    if settings is None:
        return ""
    if settings.mean:
        return f"Robust values (last table) are means over {settings.n_runs} Monte Carlo runs. "
    text = (
        f"Robust values (last table): not exceeded in {100.0 * settings.quantile:g} % of the "
        f"{settings.n_runs} Monte Carlo runs of the search"
    )
    if settings.quantile > MONTE_CARLO_SHARE:  # The search prefers plans that suit its own runs.
        text += f", and in about {100.0 * MONTE_CARLO_SHARE:g} % of new runs"
    return f"{text}. "


def _build_accuracy_section(plans: Plans) -> Section:
    table, max_rows = build_accuracy_table(plans), None
    if len(table) > MAX_ROWS:  # Attitude first, then the quantities with the smallest reduction.
        order = (table["predicted"] / table["before"]).iloc[1:].sort_values(ascending=False).index
        table, max_rows = table.loc[[table.index[0], *order]], _MAX_QUANTITIES
    new = "new " if plans.problem.scenario.monte_carlo else ""
    note = (
        f"90 % of runs: not exceeded in 90 % of {plans.n_monte_carlo_runs} {new}Monte Carlo runs "
        "with attitude and rate errors. "
    )
    if plans.problem.scenario.is_magnetorquer_driven:
        note += "Predicted: root mean square of these runs. "
    note += (
        "Ratio: predicted / lower bound for any maneuver of this duration."
        if "lower bound" in table
        else "No lower bound can be proved for this scenario."
    )
    return Section(
        "1-sigma, worst axis",
        table=table,
        note=note,
        max_rows=max_rows,
        full_command=_SHOW_COMMAND,
    )


def build_accuracy_table(plans: Plans) -> pd.DataFrame:
    """Return the worst-axis 1-sigmas before and after a plan, one row per quantity. `plans`
    contains this plan only.

    Returns
    -------
    DataFrame
        One row per 3-vector. Columns: ``unit``; ``before`` the plan; ``predicted`` at the end;
        ``90 % of runs``, the value that 90 % of Monte Carlo runs do not exceed; ``lower bound`` of
        the predicted value over all maneuvers of the same duration, and ``ratio`` of the predicted
        value to it. The last two are missing if no lower bound can be proved.
    """
    model = plans.problem.model
    units = list_block_units(model.suite)
    factors = np.array([unit.factor for unit in units])
    predicted = _find_worst_axes(plans.sigma[0])
    columns: dict[str, object] = {
        "unit": [unit.unit for unit in units],
        "before": _find_worst_axes(model.initial_sigma) * factors,
        "predicted": predicted * factors,
        "90 % of runs": plans.monte_carlo_sigma[0] * factors,
    }
    with suppress(NoLowerBoundError):
        lower_bound = plans.problem.lower_bound
        step = round(plans.nominal.t_end[0] / model.step)
        bounds = np.array([lower_bound.compute_sigma(name)[step] for name in model.suite.blocks])
        columns |= {"lower bound": bounds * factors, "ratio": predicted / bounds}
    return pd.DataFrame(columns, index=pd.Index([unit.label for unit in units], name="quantity"))


def _find_worst_axes(sigma: Floats) -> Floats:
    worst: Floats = sigma.reshape(-1, 3).max(axis=1)
    return worst


def build_maneuver_table(plans: Plans) -> pd.DataFrame:
    """Return a table of the maneuvers, constant-rate hold and slew back of a plan. `plans` contains
    this plan only.

    A maneuver includes the preceding change of the rate.

    Returns
    -------
    DataFrame
        One row per maneuver, by number, then ``hold`` and ``slew back``. Columns: ``start [s]``;
        ``duration [s]``; the commanded rates ``ωx [deg/s]`` to ``ωz [deg/s]``; ``angle [deg]``, the
        accumulated rotation; ``most reduced``, the quantity whose worst-axis 1-sigma decreases by
        the largest factor in the maneuver; and ``factor``, this factor.
    """
    model = plans.problem.model
    trajectory = plans.compute_trajectory(0)
    sigma = run_filter(model, plans.X[0]).sigma.reshape(-1, len(model.suite.blocks), 3).max(axis=2)
    labels = [unit.label for unit in list_block_units(model.suite)]
    rows = []
    for name, group in groupby(trajectory.phases, key=partial(_name_phase, trajectory)):
        parts = list(group)
        start, end = parts[0].start, parts[-1].end
        longest = max(parts, key=lambda part: part.duration)
        rates = zip("xyz", longest.commanded_deg_s, strict=True)
        quantity, factor = "", math.nan
        first, last = (min(round(t / model.step), len(sigma) - 1) for t in (start, end))
        if first < last:  # Otherwise the filter has converged before.
            factors = sigma[first] / sigma[last]
            quantity, factor = labels[factors.argmax()], factors.max()
        rows.append(
            {
                "maneuver": name,
                "start [s]": start,
                "duration [s]": end - start,
                **{f"ω{axis} [deg/s]": rate for axis, rate in rates},
                "angle [deg]": sum(part.rotation_deg for part in parts),
                "most reduced": quantity,
                "factor": factor,
            }
        )
    return pd.DataFrame(rows).set_index("maneuver")


def _describe_phases(plans: Plans, table: pd.DataFrame) -> str:
    sentences = []
    if plans.problem.model.slew_limits is not None:
        sentences.append("Duration and angle include the ramp to the rates.")
    if "hold" in table.index:
        (end,) = plans.hold_end
        sentences.append(f"Hold: the last rates are kept until {format_duration(end)}.")
    return " ".join(sentences)


def _describe_omitted_maneuvers(plans: Plans, table: pd.DataFrame) -> str:
    numbers = (str(number + 1) for number in range(get_durations(plans.X).shape[1]))
    omitted = [number for number in numbers if number not in table.index]
    return f"Maneuvers without duration: {', '.join(omitted)}." if omitted else ""


def _name_phase(trajectory: Trajectory, phase: Phase) -> str:
    if phase.start >= trajectory.design_end:
        return "slew back"
    if phase.label.endswith(AFTER_CONVERGENCE_SUFFIX) or phase.label == HOLD_LABEL:
        return "hold"
    return phase.label.removeprefix(RAMP_PREFIX).removeprefix("maneuver ")


def build_front_table(plans: Plans) -> pd.DataFrame:
    """Return a compact table for comparing plans, with one row per plan.

    Returns
    -------
    DataFrame
        Columns: ``ends after [s]`` with the convergence rules "end" and "required", otherwise
        ``converges after [s]``; ``attitude 1-sigma [deg]`` about the worst body axis;
        ``weighted trace [-]`` of the covariance; ``trace / bound [-]``, its ratio to the lower
        bound, if one can be proved; and further objectives. If the scenario has Monte Carlo runs,
        ``robust time [s]`` and ``robust trace [-]`` replace time, trace and ratio, and the
        accuracy is named ``predicted attitude 1-sigma [deg]``, because it is not robust.
    """
    problem, result = plans.problem, plans.nominal
    event = "ends after" if problem.model.rule in ("end", "required") else "converges after"
    objectives = dict(zip(problem.objectives, plans.F.T, strict=True))
    labels = dict(zip(problem.objectives, problem.obj_names, strict=True))
    sigma_deg = np.degrees(plans.sigma[:, :3].max(axis=1))
    columns = {
        f"{event} [s]": result.t_end,
        "attitude 1-sigma [deg]": sigma_deg,
        "weighted trace [-]": result.trace,
    }
    if problem.scenario.monte_carlo:
        robust = {"t_end": "robust time [s]", "trace": "robust trace [-]"}
        columns = {robust[key]: F for key, F in objectives.items() if key in robust}
        columns["predicted attitude 1-sigma [deg]"] = sigma_deg
    else:
        with suppress(NoLowerBoundError):
            bounds = problem.lower_bound.evaluate_trace(result.t_end)
            columns["trace / bound [-]"] = result.trace / bounds
    columns |= {labels[key]: F for key, F in objectives.items() if key not in ("t_end", "trace")}
    return pd.DataFrame(columns)
