"""Initial designs by a receding horizon: each stage takes the rate of least value at its end."""

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
#: Relative error of a trace from thinned samples.
_THINNING_TOLERANCE = 0.02
#: Shortest useful stage [steps].
_MIN_STAGE_STEPS = 5


def build_rate_grid(max_rate_deg_s: float, n_levels: int = _N_RATE_LEVELS) -> Floats:
    """Return rates [deg/s] on a grid about the three axes, shape (n_levels³, 3)."""
    levels = np.linspace(-max_rate_deg_s, max_rate_deg_s, n_levels)
    return np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)


def append_converging_rate(
    evaluator: FixedTimeEvaluator,
    design: Floats,
    evaluate_designs: DesignEvaluator | None = None,
    thinned_evaluator: FixedTimeEvaluator | None = None,
) -> Floats:
    """Append a final rate with which a design converges, and return one design per suitable rate.

    The candidate rates are those of `build_rate_grid`. The result contains the candidates that no other
    candidate dominates in time and value, at least one. The first one converges about one window
    after the design, when the trace falls as little as the rule allows.

    Parameters
    ----------
    evaluator : FixedTimeEvaluator
    design : array, shape (4 m,)
    evaluate_designs : function, optional
        Returns time and value of designs, and violations. Default: time and trace of `evaluator`.
    thinned_evaluator : FixedTimeEvaluator, optional
        Evaluation on thinned samples that discards most candidates first.

    Returns
    -------
    array, shape (k, 4 (m + 1))
    """
    last = build_rate_grid(evaluator.scenario.maneuvers.max_rate_deg_s)
    before = np.broadcast_to(design, (len(last), len(design)))
    extended = np.hstack([before, last, np.zeros((len(last), 1))])
    if thinned_evaluator is not None:
        extended = extended[
            _find_near_nondominated_rows(thinned_evaluator.evaluate_convergence(extended)[0])
        ]
    F, violation = (evaluate_designs or evaluator.evaluate_convergence)(extended)
    rows = _find_nondominated_rows(F, violation)
    late = np.abs(
        F[rows, 0]
        - get_durations(design).sum()
        - evaluator.model.step * evaluator.model.window_steps
    )
    return extended[rows[np.argsort(late, kind="stable")]]


def build_receding_horizon_plan(
    evaluator: FixedTimeEvaluator, n_stages: int, end_time: float
) -> Floats:
    """Return a plan of `n_stages` stages of equal length until a time [s], shape (4 count,).

    Each stage takes the rate with the least value at its end, on a grid of seven rates about each
    axis, among the rates with the least violation of constraints.
    """
    plan: Floats = beam_search(evaluator, n_stages, end_time)[0]
    return plan


def beam_search(
    evaluator: FixedTimeEvaluator,
    n_stages: int,
    end_time: float,
    n_levels: int = _N_RATE_LEVELS,
    width: int = 1,
    length_ratio: float = 1.0,
) -> Floats:
    """Return the best plans of a beam search over rates, best first, shape (width, 4 count).

    Each stage keeps the `width` partial plans with the least values at its end, so that a rate can
    pay off in later stages.

    Parameters
    ----------
    evaluator : FixedTimeEvaluator
    n_stages : int
        Number of stages.
    end_time : float
        Approximate end of the plan [s].
    n_levels : int
        Number of rates about each axis.
    width : int
        Largest number of partial plans.
    length_ratio : float
        Ratio of the lengths of consecutive stages. The final value depends most on the last stages.
    """
    limits, step = evaluator.scenario.maneuvers, evaluator.model.step
    rates = build_rate_grid(limits.max_rate_deg_s, n_levels)
    lengths = length_ratio ** np.arange(n_stages)
    durations = np.minimum(end_time * lengths / lengths.sum(), limits.max_duration)
    n_steps = np.maximum((durations / step).astype(int), 1)
    plans = np.empty((1, 0))
    for own_steps, until in zip(n_steps, np.cumsum(n_steps), strict=True):
        own = np.column_stack([rates, np.full(len(rates), own_steps * step)])
        candidates = np.hstack([np.repeat(plans, len(own), axis=0), np.tile(own, (len(plans), 1))])
        plans = evaluator.select_best(candidates, min(int(until), evaluator.model.n_steps), width)
    return plans


def build_initial_designs(
    problem: PlanProblem, n_designs: int, random_state: np.random.Generator
) -> Floats:
    """Return initial designs for a search, shape (n, n_var), for n different end times.

    The logarithms of the end times are stratified samples. With the convergence rule "trace", a
    plan reduces the value until one window before its end, and then holds a rate with which the
    filter converges. With magnetorquers the designs assume instantaneous rate changes, which give
    similar values much faster.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    n_designs : int
        Number of designs, at least 0.
    random_state : numpy Generator
        Draws the end times.

    Raises
    ------
    ValueError
        If `n_designs` is negative.
    """
    if n_designs < 0:
        raise ValueError(f"n = {n_designs}: expected a number of designs >= 0")
    at = _remove_magnetorquers(build_fixed_time_evaluator(problem))
    scenario, model = at.scenario, at.model
    count, window = scenario.maneuvers.count, model.window_steps * model.step
    holds = model.rule == "trace" and count > 1
    learning = count - 1 if holds else count
    first = min(_MIN_STAGE_STEPS * learning * model.step, 0.5 * model.duration)
    first = max(first, 0.02 * model.duration)
    last = min(
        model.duration - (window if holds else 0.0), learning * scenario.maneuvers.max_duration
    )
    shares = (np.arange(n_designs) + random_state.random(n_designs)) / max(n_designs, 1)
    times = first * (max(last, first) / first) ** shares
    designs = np.empty((n_designs, VARIABLES_PER_MANEUVER * count))
    for row, time in enumerate(times):
        plan = build_receding_horizon_plan(at, learning, float(time))
        if holds:
            plan = append_converging_rate(at, plan)[0]
        designs[row] = plan
    return designs


def _remove_magnetorquers(evaluator: FixedTimeEvaluator) -> FixedTimeEvaluator:
    if not evaluator.scenario.is_magnetorquer_driven:
        return evaluator
    scenario = dataclasses.replace(evaluator.scenario, magnetorquers=None)
    limits = build_slew_limits(scenario.maneuvers, scenario.wheels, evaluator.model.initial_rate)
    model = dataclasses.replace(evaluator.model, slew_limits=limits)
    return dataclasses.replace(evaluator, scenario=scenario, model=model)


def _find_nondominated_rows(F: Floats, violation: Floats) -> Ints:
    """Return the nondominated rows of the least violation, by time and value, or one row.

    F, shape (n, 2), has the time and the final value of each row.
    """
    order = np.lexsort((F[:, 1], F[:, 0], violation))
    least = np.minimum.accumulate(np.nan_to_num(F[order, 1], nan=np.inf))
    rows: Ints = order[np.diff(least, prepend=np.inf) < 0.0]
    return rows if len(rows) else order[:1]


def _find_near_nondominated_rows(F: Floats) -> Ints:
    """Return the rows that are nondominated up to a tolerance of the value.

    F is as in `_nondominated_rows`.
    """
    order = np.lexsort((F[:, 1], F[:, 0]))
    value = np.nan_to_num(F[order, 1], nan=np.inf)
    rows: Ints = order[value <= (1.0 + _THINNING_TOLERANCE) * np.minimum.accumulate(value)]
    return np.sort(rows)
