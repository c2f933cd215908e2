"""Margins of plans to the constraints of their scenario, each in the unit of the constraint.

The margins also cover the time after convergence, which the search does not evaluate.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
import pandas as pd

from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.constraints import PLAN_END, Bound
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.environment.directions import SatelliteState
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.filter.path_constraints import compute_violation_on_orbit
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.trajectory.trajectory import Trajectory
from mgeo_attitude.view.plans import Plans

#: Unit, value, "at most" or "at least", limit and margin.
MarginRow = tuple[str, float, str, float, float]
_COLUMNS = ["unit", "value", "bound_type", "bound_value", "margin"]
#: Number of 1-sigmas in the attitude margin, the default of path constraints.
_SIGMAS = 3.0
#: Names of the intervals after `t_end`.
INTERVALS_AFTER_CONVERGENCE = ("in the constant-rate hold", "in the slew back")
#: Label of the row of `ManeuverLimits.end_tolerance_deg`.
END_ATTITUDE = "attitude after the slew back, 3 sigma"


def build_constraint_tables(
    bounds: Sequence[Bound],
    violations: Floats,
    margins_after: Sequence[Mapping[str, MarginRow]] | None = None,
) -> list[pd.DataFrame]:
    """Return a table of constraints for each of n designs.

    Parameters
    ----------
    bounds : sequence of Limit
    violations : array, shape (n, n_limits)
        Relative violations, positive if violated.
    margins_after : sequence of mapping, optional
        Additional rows of each design for the time after convergence; see `compute_margins_after_convergence`.

    Returns
    -------
    list of DataFrame
        One row per constraint. Columns: ``unit``, ``value``, ``bound`` ("at most" or "at least"),
        ``limit``, and ``margin``, which is negative if the constraint is violated.
    """
    more = [{} for _ in violations] if margins_after is None else margins_after
    result = []
    for row, rest in zip(violations, more, strict=True):
        cells = [_build_row(limit, each) for limit, each in zip(bounds, row.tolist(), strict=True)]
        labels = [*(limit.label for limit in bounds), *rest]
        index = pd.Index(labels, name="constraint", dtype=str)
        result.append(pd.DataFrame([*cells, *rest.values()], columns=_COLUMNS, index=index))
    return result


def _build_row(constraint_bound: Bound, violation: float) -> MarginRow:
    bound = constraint_bound.value * constraint_bound.factor
    value = bound * (1.0 - violation if constraint_bound.is_lower else 1.0 + violation)
    return (
        constraint_bound.unit,
        value,
        "at least" if constraint_bound.is_lower else "at most",
        bound,
        -violation * bound,
    )


def _build_upper_bound_row(unit: str, value: float, bound: float) -> MarginRow:
    return unit, value, "at most", bound, bound - value


def has_constraints_after_convergence(scenario: Scenario) -> bool:
    """Return whether constraints apply to plans after convergence."""
    wheels = scenario.wheels
    budgeted = wheels is not None and wheels.has_momentum_budget
    limited = scenario.path_constraints or scenario.windows or budgeted
    tolerated = scenario.maneuvers.end_tolerance_deg is not None
    return bool((limited and (scenario.monte_carlo or scenario.maneuvers.slew_back)) or tolerated)


def compute_margins_after_convergence(plans: Plans) -> list[dict[str, MarginRow]]:
    """Return the margins of each plan for the time after convergence, by label.

    Path constraints, the wheel budget and the end of the window are evaluated during the
    constant-rate hold and the slew back, in about 0.1 s per design; the attitude uncertainty is
    evaluated at the end. A design whose covariance was lost, and every design of a scenario without
    such constraints, has an empty mapping.
    """
    problem, result = plans.problem, plans.nominal
    rows: list[dict[str, MarginRow]] = [{} for _ in plans.X]
    if not has_constraints_after_convergence(problem.scenario):
        return rows
    for i in np.flatnonzero(np.isfinite(result.t_end)).tolist():
        trajectory = plans.compute_trajectory(i)
        edges = [trajectory.t_end, trajectory.design_end]
        try:
            edges.append(trajectory.end)
        except InvalidValue:
            rows[i]["time of the slew back"] = _build_upper_bound_row(
                "s", np.inf, problem.scenario.duration
            )
        else:
            tolerance = problem.scenario.maneuvers.end_tolerance_deg
            if tolerance is not None:
                off = _compute_final_attitude_error(problem.scenario, problem.model, trajectory)
                rows[i][END_ATTITUDE] = _build_upper_bound_row("deg", off, tolerance)
        latest = problem.scenario.deadline
        if latest < np.inf:
            rows[i][f"{PLAN_END}, including hold and slew back"] = _build_upper_bound_row(
                "s", edges[-1], latest
            )
        for (start, end), while_ in zip(pairwise(edges), INTERVALS_AFTER_CONVERGENCE, strict=False):
            if start < end:
                rows[i] |= compute_interval_margins(
                    problem.model, trajectory, start, end, result.covariance[i, :3, :3], while_
                )
    return rows


def _compute_final_attitude_error(
    scenario: Scenario, model: FilterModel, trajectory: Trajectory
) -> float:
    """Return three times the attitude 1-sigma about the worst axis at the end of a plan [deg].

    The covariance includes all measurements until the end and the growth by the gyro's noise.
    """
    last = round(trajectory.end / model.step)
    if last > model.n_steps:  # the scenario's duration bounds t_end, not the slew back
        longer = dataclasses.replace(scenario, duration=last * model.step)
        model = FilterModel.from_scenario(longer)
    ran = evaluate(model, trajectory.commanded_design, covariance=True, end_steps=last)
    return _SIGMAS * float(attitude_accuracy_deg(ran.covariance[0]))


def summarize_margins(plans: Plans, sample_label: str) -> list[str]:
    """Return a line that counts the plans of a front that satisfy all constraints to their end."""
    if not has_constraints_after_convergence(plans.problem.scenario):
        return []
    exceeded = [
        {label for label, (*_, margin) in after.items() if margin < 0.0}
        for after in compute_margins_after_convergence(plans)
    ]
    keep = sum(not each for each in exceeded)
    line = f"{keep} of {sample_label} satisfy all constraints after convergence"
    if labels := sorted(set().union(*exceeded)):
        line += f"; the other plans violate {', '.join(labels)}"
    return [line]


def compute_interval_margins(
    model: FilterModel,
    trajectory: Trajectory,
    start: float,
    end: float,
    covariance: Floats,
    interval_name: str,
) -> dict[str, MarginRow]:
    """Return margins of path constraints and of the wheel budget in an interval, by label.

    Parameters
    ----------
    model : FilterModel
    trajectory : Trajectory
    start, end : float
        Interval [s] after the epoch, both on a step of the filter.
    covariance : array, shape (3, 3)
        Attitude covariance, body axes [rad²], assumed constant over the interval.
    interval_name : str
        Name of the interval, for the labels.
    """
    scenario = trajectory.scenario
    first, last = (round(time / model.step) for time in (start, end))
    attitude = trajectory.attitude[first : last + 1]
    turn = np.vstack([np.zeros(3), model.step * trajectory.motion.rates[first:last]])
    rows: dict[str, MarginRow] = {}
    wheels = scenario.wheels
    if wheels is not None and wheels.has_momentum_budget:
        bounds = (wheels.max_momentum, wheels.max_torque)
        names = (("wheel momentum", "N m s"), ("wheel torque", "N m"))
        loads = _compute_wheel_load(model, trajectory, first, last).tolist()
        for (name, unit), load, bound in zip(names, loads, bounds, strict=True):
            if bound is not None:
                rows[name] = _build_upper_bound_row(unit, load, bound)
    at = SatelliteState.from_times(
        scenario, start + model.step * np.arange(len(attitude), dtype=float)
    )
    at = at if scenario.eclipse else at.without_eclipses()
    covariances = np.repeat(covariance[None], len(attitude), axis=0)
    for limit in scenario.path_constraints:
        cone, bound = limit.build_cone(), limit.half_angle_deg
        excess = compute_violation_on_orbit(
            cone, limit.attitude_sigmas, at, scenario.epoch, attitude, turn, covariances
        )
        worst = np.degrees(max(float(excess.max()), -np.pi))  # -inf if the Sun is never visible
        if cone.keep_in:
            rows[limit.label] = _build_upper_bound_row("deg", worst, bound)
        else:
            rows[limit.label] = ("deg", -worst, "at least", bound, -worst - bound)
    return {f"{label} {interval_name}": row for label, row in rows.items()}


def _compute_wheel_load(
    model: FilterModel, trajectory: Trajectory, first: int, last: int
) -> Floats:
    """Return the largest momentum [N m s] and torque [N m] of budgeted wheels, shape (2,)."""
    from mgeo_attitude.filter.wheel_load import compute_wheel_loads  # imports numba

    scenario = trajectory.scenario
    times = model.step * np.arange(last + 1, dtype=float)  # may extend beyond the run
    around = Environment.from_times(scenario, times)
    budget = MomentumBudget.from_scenario(
        scenario, around, model.initial_attitude, model.initial_rate
    )
    assert budget is not None  # the caller checks that the wheels have a budget
    flown = model.build_schedule(trajectory.commanded_design, last + 1)
    loads: Floats = compute_wheel_loads(budget, flown, np.array([last]), model.step, 1, first)[0]
    return loads
