"""Initial designs of a search by a receding horizon over the maneuvers.

Each maneuver of a plan takes the rate with the smallest objective at its end.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, get_durations
from mgeo_attitude.refine.evaluators import (
    DesignEvaluator,
    FixedTimeEvaluator,
    PlanProblem,
    build_fixed_time_evaluator,
)
from mgeo_attitude.scenario.actuators import build_slew_limits

#: Number of rates about each axis, from the negative to the positive maximum.
_N_RATE_LEVELS = 7
#: Relative error of a trace that was computed from thinned samples.
_THINNING_TOLERANCE = 0.02
#: Shortest useful maneuver, in filter steps.
_MIN_MANEUVER_STEPS = 5


def build_rate_grid(max_rate_deg_s: float, n_levels: int = _N_RATE_LEVELS) -> Floats:
    """Return a grid of body rates [deg/s], with one combination of rates per row.

    The grid contains all combinations of equally spaced rates about three axes.

    Parameters
    ----------
    max_rate_deg_s : float
        Maximum rate about each axis [deg/s].
    n_levels : int
        Number of rates about each axis, from the negative to the positive maximum.

    Returns
    -------
    array, shape (n_levels³, 3)
        Rates [deg/s].
    """
    levels = np.linspace(-max_rate_deg_s, max_rate_deg_s, n_levels)
    return np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)


def append_converging_rate(
    evaluator: FixedTimeEvaluator,
    design: Floats,
    evaluate_designs: DesignEvaluator | None = None,
    thinned_evaluator: FixedTimeEvaluator | None = None,
) -> Floats:
    """Extend a design by a final maneuver at a constant rate at which the filter converges.

    Return one extended design for each suitable rate. The candidate rates are those of
    `build_rate_grid`. The result contains the candidates that no other candidate dominates in time
    and objective, at least one. The first one converges about one window of the convergence rule
    after the design, with the smallest decrease of the trace that the rule accepts.

    Parameters
    ----------
    evaluator : FixedTimeEvaluator
    design : array, shape (4 m,)
    evaluate_designs : function, optional
        Returns time and objective of designs, and violations. Default: convergence time and trace
        by `evaluator`.
    thinned_evaluator : FixedTimeEvaluator, optional
        Evaluator on thinned samples, which discards most candidates first.

    Returns
    -------
    array, shape (k, 4 (m + 1))
    """
    rates = build_rate_grid(evaluator.scenario.maneuvers.max_rate_deg_s)
    repeated = np.broadcast_to(design, (len(rates), len(design)))
    extended = np.hstack([repeated, rates, np.zeros((len(rates), 1))])
    if thinned_evaluator is not None:
        extended = extended[
            _find_near_nondominated_rows(thinned_evaluator.evaluate_convergence(extended)[0])
        ]
    F, violation = (evaluate_designs or evaluator.evaluate_convergence)(extended)
    rows = _find_nondominated_rows(F, violation)
    deviation = np.abs(
        F[rows, 0]
        - get_durations(design).sum()
        - evaluator.model.step * evaluator.model.window_steps
    )
    return extended[rows[np.argsort(deviation, kind="stable")]]


def build_receding_horizon_plan(
    evaluator: FixedTimeEvaluator, n_maneuvers: int, end_time: float
) -> Floats:
    """Build a design by choosing the rate of one maneuver after another.

    All maneuvers have equal durations. Each maneuver has the rate that minimizes the objective at
    its end. The rates are those of a grid with seven levels about each axis. Among them, those with
    the smallest violation of constraints are compared.

    Parameters
    ----------
    evaluator : FixedTimeEvaluator
    n_maneuvers : int
        Number of maneuvers.
    end_time : float
        Approximate end of the design [s].

    Returns
    -------
    array, shape (4 n_maneuvers,)
    """
    plan: Floats = beam_search(evaluator, n_maneuvers, end_time)[0]
    return plan


def beam_search(
    evaluator: FixedTimeEvaluator,
    n_maneuvers: int,
    end_time: float,
    n_levels: int = _N_RATE_LEVELS,
    width: int = 1,
    length_ratio: float = 1.0,
) -> Floats:
    """Find rates of successive maneuvers by beam search, and return the best designs.

    The best design comes first. Each maneuver extends the `width` partial designs with the smallest
    objectives at the end of the previous maneuver, so that the advantage of a rate may appear after
    a later maneuver.

    Parameters
    ----------
    evaluator : FixedTimeEvaluator
    n_maneuvers : int
        Number of maneuvers.
    end_time : float
        Approximate end of the designs [s].
    n_levels : int
        Number of rates about each axis.
    width : int
        Largest number of partial designs.
    length_ratio : float
        Ratio of the durations of consecutive maneuvers. The final objective depends most on the
        last maneuvers.

    Returns
    -------
    array, shape (width, 4 n_maneuvers)
    """
    limits, step = evaluator.scenario.maneuvers, evaluator.model.step
    rates = build_rate_grid(limits.max_rate_deg_s, n_levels)
    lengths = length_ratio ** np.arange(n_maneuvers)
    durations = np.minimum(end_time * lengths / lengths.sum(), limits.max_duration)
    n_steps = np.maximum((durations / step).astype(int), 1)
    plans = np.empty((1, 0))
    for maneuver_steps, end_step in zip(n_steps, np.cumsum(n_steps), strict=True):
        maneuvers = np.column_stack([rates, np.full(len(rates), maneuver_steps * step)])
        candidates = np.hstack(
            [np.repeat(plans, len(maneuvers), axis=0), np.tile(maneuvers, (len(plans), 1))]
        )
        plans = evaluator.select_best(
            candidates, min(int(end_step), evaluator.model.n_steps), width
        )
    return plans


def build_initial_designs(
    problem: PlanProblem, n_designs: int, random_state: np.random.Generator
) -> Floats:
    """Build initial designs for a search, with random end times and receding-horizon rates.

    The rates of each design are chosen maneuver by maneuver. The logarithms of the end times are
    stratified. With the convergence rule "trace", a design minimizes the trace until one window
    before its end, and then holds a rate with which the filter converges. With magnetorquers, the
    designs assume instantaneous rate changes, which give similar traces much faster.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    n_designs : int
        Number of designs, at least 0.
    random_state : numpy Generator
        Draws the end times.

    Returns
    -------
    array, shape (n_designs, n_var)

    Raises
    ------
    ValueError
        If `n_designs` is negative.
    """
    if n_designs < 0:
        raise ValueError(f"n = {n_designs}: expected a number of designs >= 0")
    evaluator = _remove_magnetorquers(build_fixed_time_evaluator(problem))
    scenario, model = evaluator.scenario, evaluator.model
    count, window = scenario.maneuvers.count, model.window_steps * model.step
    has_final_rate = model.rule == "trace" and count > 1
    n_maneuvers = count - 1 if has_final_rate else count
    first = min(_MIN_MANEUVER_STEPS * n_maneuvers * model.step, 0.5 * model.duration)
    first = max(first, 0.02 * model.duration)
    last = min(
        model.duration - (window if has_final_rate else 0.0),
        n_maneuvers * scenario.maneuvers.max_duration,
    )
    shares = (np.arange(n_designs) + random_state.random(n_designs)) / max(n_designs, 1)
    times = first * (max(last, first) / first) ** shares
    designs = np.empty((n_designs, VARIABLES_PER_MANEUVER * count))
    for row, time in enumerate(times):
        design = build_receding_horizon_plan(evaluator, n_maneuvers, float(time))
        if has_final_rate:
            design = append_converging_rate(evaluator, design)[0]
        designs[row] = design
    return designs


def _remove_magnetorquers(evaluator: FixedTimeEvaluator) -> FixedTimeEvaluator:
    if not evaluator.scenario.is_magnetorquer_driven:
        return evaluator
    scenario = dataclasses.replace(evaluator.scenario, magnetorquers=None)
    limits = build_slew_limits(scenario.maneuvers, scenario.wheels, evaluator.model.initial_rate)
    model = dataclasses.replace(evaluator.model, slew_limits=limits)
    return dataclasses.replace(evaluator, scenario=scenario, model=model)


def _find_nondominated_rows(F: Floats, violation: Floats) -> Ints:
    """Return the indices of the designs that are nondominated in time and objective.

    Only the designs with the smallest constraint violation are compared. F has time and objective
    of each row, shape (n, 2). If no objective is finite, one row is returned.
    """
    order = np.lexsort((F[:, 1], F[:, 0], violation))
    least = np.minimum.accumulate(np.nan_to_num(F[order, 1], nan=np.inf))
    rows: Ints = order[np.diff(least, prepend=np.inf) < 0.0]
    return rows if len(rows) else order[:1]


def _find_near_nondominated_rows(F: Floats) -> Ints:
    """Return the indices of the designs that are nearly nondominated in time and objective.

    The objective of such a design exceeds the smallest objective among all designs that end no
    later by at most a relative tolerance. F has time and objective of each row, shape (n, 2).
    """
    order = np.lexsort((F[:, 1], F[:, 0]))
    value = np.nan_to_num(F[order, 1], nan=np.inf)
    rows: Ints = order[value <= (1.0 + _THINNING_TOLERANCE) * np.minimum.accumulate(value)]
    return np.sort(rows)
