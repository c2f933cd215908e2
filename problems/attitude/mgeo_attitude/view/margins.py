"""Margins of plans to the constraints of their scenario, in the unit of each constraint.

The margins include the time after convergence, which the search does not evaluate.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np
import pandas as pd

from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.constraints import PLAN_END, Bound
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.environment.directions import SatelliteState
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import Evaluation, evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.filter.path_constraints import compute_monitored_angle_on_orbit
from mgeo_attitude.scenario.criteria import RequiredSigma
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.trajectory.trajectory import Trajectory
from mgeo_attitude.view.plans import Plans

#: Cells in one row of a constraint table: unit, value, "at most" or "at least", bound and margin.
MarginRow = tuple[str, float, str, float, float]
_COLUMNS = ["unit", "value", "bound_type", "bound_value", "margin"]
#: Number of 1-sigmas in the final attitude error, which is also the default of path constraints.
_SIGMAS = 3.0
#: Phrases for the two intervals after convergence, in labels of constraints.
INTERVALS_AFTER_CONVERGENCE = ("in the constant-rate hold", "in the slew back")
#: Label of the constraint that ``maneuvers.end_tolerance_deg`` sets.
END_ATTITUDE = "attitude after the slew back, 3 sigma"
#: End of the labels of required 1-sigmas after the slew back.
_AFTER_SLEW_BACK = "after the slew back"


def build_constraint_tables(
    bounds: Sequence[Bound],
    violations: Floats,
    margins_after: Sequence[Mapping[str, MarginRow]] | None = None,
) -> list[pd.DataFrame]:
    """Return one table per design with the value, bound and margin of each constraint.

    Parameters
    ----------
    bounds : sequence of Bound
    violations : array, shape (n, n_bounds)
        Relative violations of the bounds, positive if violated.
    margins_after : sequence of mapping, optional
        Additional rows of each design by label; see `compute_margins_after_convergence`.

    Returns
    -------
    list of DataFrame
        One row per constraint. Columns: ``unit``, ``value``, ``bound_type`` ("at most" or "at
        least"), ``bound_value``, and ``margin``, which is negative if the constraint is violated.
    """
    additional_rows = [{} for _ in violations] if margins_after is None else margins_after
    result = []
    for row, additional in zip(violations, additional_rows, strict=True):
        cells = [_build_row(bound, each) for bound, each in zip(bounds, row.tolist(), strict=True)]
        labels = [*(bound.label for bound in bounds), *additional]
        index = pd.Index(labels, name="constraint", dtype=str)
        result.append(pd.DataFrame([*cells, *additional.values()], columns=_COLUMNS, index=index))
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
    """Return True if constraints apply during the constant-rate hold or the slew back."""
    wheels = scenario.wheels
    has_wheel_budget = wheels is not None and wheels.has_momentum_budget
    has_motion_constraints = scenario.path_constraints or scenario.windows or has_wheel_budget
    continues = scenario.monte_carlo or scenario.maneuvers.slew_back
    has_end_tolerance = scenario.maneuvers.end_tolerance_deg is not None
    has_required_sigma = scenario.required_sigma and scenario.maneuvers.slew_back
    return bool((has_motion_constraints and continues) or has_end_tolerance or has_required_sigma)


def compute_margins_after_convergence(plans: Plans) -> list[dict[str, MarginRow]]:
    """Return the constraint margins of each plan after convergence, keyed by constraint label.

    Path constraints, wheel budgets and the deadline are evaluated during the constant-rate hold and
    the slew back, in about 0.1 s per plan. The final attitude uncertainty is compared with its
    tolerance, and the 1-sigmas after the slew back with the required ones. With the convergence
    rule "required" they must be satisfied until the end of the scenario, otherwise at the end of
    the slew back. The dict is empty if the scenario has no such constraints or if the covariance of
    the plan lost positivity.

    Returns
    -------
    list of dict of str to MarginRow
        One dict per plan, with labels of constraints as keys.
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
                error_deg = _compute_final_attitude_error(
                    problem.scenario, problem.model, trajectory
                )
                rows[i][END_ATTITUDE] = _build_upper_bound_row("deg", error_deg, tolerance)
            if problem.scenario.required_sigma and problem.scenario.maneuvers.slew_back:
                rows[i] |= _compute_required_margins(problem.scenario, problem.model, trajectory)
        deadline = problem.scenario.deadline
        if deadline < np.inf:
            rows[i][f"{PLAN_END}, including hold and slew back"] = _build_upper_bound_row(
                "s", edges[-1], deadline
            )
        for (start, end), interval_name in zip(
            pairwise(edges), INTERVALS_AFTER_CONVERGENCE, strict=False
        ):
            if start < end:
                rows[i] |= compute_interval_margins(
                    problem.model,
                    trajectory,
                    start,
                    end,
                    result.covariance[i, :3, :3],
                    interval_name,
                )
    return rows


def _compute_final_attitude_error(
    scenario: Scenario, model: FilterModel, trajectory: Trajectory
) -> float:
    """Return the 3-sigma attitude uncertainty of the worst body axis at the end of a plan [deg].

    The covariance includes all measurements until the end and the growth due to gyro noise.
    """
    result = _evaluate_with_slew_back(
        scenario, model, trajectory, round(trajectory.end / model.step)
    )
    return _SIGMAS * float(attitude_accuracy_deg(result.covariance[0]))


def _compute_required_margins(
    scenario: Scenario, model: FilterModel, trajectory: Trajectory
) -> dict[str, MarginRow]:
    """Return the margins of the required 1-sigmas after the slew back, keyed by label."""
    first = round(trajectory.end / model.step)
    last = max(first, model.n_steps) if model.rule == "required" else first
    result = _evaluate_with_slew_back(scenario, model, trajectory, last)
    variances = result.variances[0, first : last + 1].max(axis=0)
    worst = np.sqrt(variances.reshape(-1, 3).max(axis=1))
    required = RequiredSigma(scenario.required_sigma).list_sigmas(model.suite.units)
    return {
        f"1-sigma of {unit.label} {_AFTER_SLEW_BACK}": _build_upper_bound_row(
            unit.unit, sigma * unit.factor, bound * unit.factor
        )
        for unit, sigma, bound in zip(
            list_block_units(model.suite), worst.tolist(), required, strict=True
        )
        if bound < np.inf
    }


def _evaluate_with_slew_back(
    scenario: Scenario, model: FilterModel, trajectory: Trajectory, last: int
) -> Evaluation:
    """Run the filter along a plan and its slew back until the filter step `last`."""
    if last > model.n_steps:  # The scenario's duration bounds t_end, but not the slew back.
        longer = dataclasses.replace(scenario, duration=last * model.step)
        model = FilterModel.from_scenario(longer)
    design = trajectory.commanded_design
    return evaluate(model, design, history=True, covariance=True, end_steps=last)


def list_margin_warnings(plans: Plans, sample_label: str) -> list[str]:
    """Return warnings about plans that violate constraints after convergence.

    Required 1-sigmas after the slew back have a warning of their own. The list is empty if no
    constraint is violated.
    """
    violated_labels = [
        {label for label, (*_, margin) in after.items() if margin < 0.0}
        for after in compute_margins_after_convergence(plans)
    ]
    after_slew_back = [
        {label for label in labels if label.endswith(_AFTER_SLEW_BACK)}
        for labels in violated_labels
    ]
    others = [
        labels - after for labels, after in zip(violated_labels, after_slew_back, strict=True)
    ]
    show = "Check the constraints of a plan with mgeo attitude show."
    relax = "Require smaller values in [required_sigma], or start at another epoch."
    return [
        *_format_violations(others, sample_label, show),
        *_format_violations(after_slew_back, sample_label, relax),
    ]


def _format_violations(
    labels_by_plan: Sequence[set[str]], sample_label: str, advice: str
) -> Iterator[str]:
    n_violating = sum(map(bool, labels_by_plan))
    if n_violating:
        verb = "violates" if n_violating == 1 else "violate"
        names = ", ".join(sorted(set().union(*labels_by_plan)))
        yield (
            f"{n_violating} of {sample_label} {verb} a constraint that the search does not "
            f"evaluate: {names}. {advice}"
        )


def compute_interval_margins(
    model: FilterModel,
    trajectory: Trajectory,
    start: float,
    end: float,
    covariance: Floats,
    interval_name: str,
) -> dict[str, MarginRow]:
    """Compute the margins of path constraints and wheel budgets during a time interval.

    Parameters
    ----------
    model : FilterModel
    trajectory : Trajectory
    start, end : float
        Start and end of the interval after the epoch [s], both on a step of the filter.
    covariance : array, shape (3, 3)
        Attitude covariance, body axes [rad²], assumed constant over the interval.
    interval_name : str
        Phrase for the interval, appended to the labels.

    Returns
    -------
    dict of str to MarginRow
    """
    scenario = trajectory.scenario
    first, last = (round(time / model.step) for time in (start, end))
    attitude = trajectory.attitude[first : last + 1]
    rotation = np.vstack([np.zeros(3), model.step * trajectory.motion.rates[first:last]])
    rows: dict[str, MarginRow] = {}
    wheels = scenario.wheels
    if wheels is not None and wheels.has_momentum_budget:
        bounds = (wheels.max_momentum, wheels.max_torque)
        names = (("wheel momentum", "N m s"), ("wheel torque", "N m"))
        loads = _compute_wheel_load(model, trajectory, first, last).tolist()
        for (name, unit), load, bound in zip(names, loads, bounds, strict=True):
            if bound is not None:
                rows[name] = _build_upper_bound_row(unit, load, bound)
    states = SatelliteState.from_times(
        scenario, start + model.step * np.arange(len(attitude), dtype=float)
    )
    states = states if scenario.eclipse else states.without_eclipses()
    covariances = np.repeat(covariance[None], len(attitude), axis=0)
    for constraint in scenario.path_constraints:
        cone, bound = constraint.build_cone(), constraint.half_angle_deg
        excess = compute_monitored_angle_on_orbit(
            cone,
            constraint.attitude_sigmas,
            states,
            scenario.epoch,
            attitude,
            rotation,
            covariances,
        )
        # The violation is -inf if the Sun is never visible.
        worst = np.degrees(max(float(excess.max()), -np.pi))
        if cone.keep_in:
            rows[constraint.label] = _build_upper_bound_row("deg", worst, bound)
        else:
            rows[constraint.label] = ("deg", -worst, "at least", bound, -worst - bound)
    return {f"{label} {interval_name}": row for label, row in rows.items()}


def _compute_wheel_load(
    model: FilterModel, trajectory: Trajectory, first: int, last: int
) -> Floats:
    """Return the largest wheel momentum [N m s] and wheel torque [N m] between two filter steps."""
    from mgeo_attitude.filter.wheel_load import compute_wheel_loads  # The import of numba is slow.

    scenario = trajectory.scenario
    times = model.step * np.arange(last + 1, dtype=float)  # They may extend beyond the run.
    environment = Environment.from_times(scenario, times)
    budget = MomentumBudget.from_scenario(
        scenario, environment, model.initial_attitude, model.initial_rate
    )
    assert budget is not None  # The caller checks that the wheels have a budget.
    schedule = model.build_schedule(trajectory.commanded_design, last + 1)
    loads: Floats = compute_wheel_loads(budget, schedule, np.array([last]), model.step, 1, first)[0]
    return loads
