"""Local refinement of the plans of a front, by gradients of the objective at their ends."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.objectives import find_smooth_objective
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, get_durations
from mgeo_attitude.refine.evaluators import (
    DesignEvaluator,
    FixedTimeEvaluator,
    PlanProblem,
    build_design_evaluator,
    build_fixed_time_evaluator,
    round_to_steps,
    scale_time,
    set_end_times,
    stretch_durations,
)
from mgeo_attitude.refine.front import RefinementFront
from mgeo_attitude.refine.initial_designs import append_converging_rate, beam_search
from mgeo_attitude.refine.splitting import remove_ineffective_maneuvers
from mgeo_attitude.refine.thinned_samples import ThinnedSamples

#: Default number of plans of a front to refine, and of iterations for each plan.
MAX_PLANS, MAX_ITERATIONS = 16, 48
#: Number of plans that are refined in one batch.
_BATCH_SIZE = 4
#: Beam search: rate levels per axis, width, and ratio of the durations of consecutive
#: maneuvers.
BeamSettings = tuple[int, int, float]
#: Beam searches for plans of at most `_MAX_SHORT_PLAN_ROTATIONS` revolutions at the maximum rate,
#: which need a wide beam of maximum rates, and for longer plans, which need maneuvers of decreasing
#: duration.
_MAX_SHORT_PLAN_ROTATIONS = 4.0
_SHORT_PLAN_BEAMS: tuple[BeamSettings, ...] = ((2, 100, 1.0), (3, 10, 0.9))
_LONG_PLAN_BEAMS: tuple[BeamSettings, ...] = ((3, 15, 0.9), (3, 15, 0.8))
#: Number of plans of a beam search that become initial designs.
_N_BEAM_PLANS = 8
#: For the first round of plans and for the plans between them: number of initial designs, share of
#: the iterations, and whether beam searches provide initial designs.
_ROUNDS = (16, 0.6, True), (3, 0.4, False)
#: Number of final rates of each plan that Monte Carlo runs evaluate, and that are tried at other
#: times.
_N_MONTE_CARLO_RATES, _N_FINAL_RATES = 4, 6
#: Number of refined plans that are adapted to another time, and of results that are evaluated.
_N_CANDIDATES, _N_EVALUATED = 3, 2
#: Tolerance by which a time may miss a filter step, in steps.
_STEP_TOLERANCE = 1e-6
#: Earliest end of a plan to refine, as a share of the scenario's duration.
_MIN_TIME_SHARE = 0.02
#: Ratio of the end times of neighboring plans above which plans are added between them.
_MAX_TIME_RATIO = 1.01
#: Number of refined plans that serve as initial designs of another plan.
_N_NEAREST = 3


def refine_plans(
    problem: PlanProblem,
    designs: ArrayLike,
    max_plans: int = MAX_PLANS,
    max_iterations: int = MAX_ITERATIONS,
) -> Floats:
    """Improve plans by gradient-based local refinement. No plan ends later or has a larger
    objective than before.

    The result has the plans in the order of `designs`. A plan for which no better feasible plan is
    found stays unchanged.

    Up to `max_plans` plans of the front, at approximately equal ratios of their end times, are
    refined first. The initial designs of a refinement are the plan, other refined plans, and the
    results of beam searches (`initial_designs.beam_search`). The plans between them follow, with
    fewer iterations and without beam searches. All results are then adapted to the end times of the
    other plans, and maneuvers without effect are removed.

    With the convergence rule "trace", the objective one window before the end is refined, and a
    final rate is chosen with which the filter converges. If the problem uses Monte Carlo runs,
    gradients are those of nominal runs, but results are accepted by their objectives over the Monte
    Carlo runs.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
        Its objectives are t_end and one smooth objective of the covariance.
    designs : array_like, shape (n, n_var)
        Plans within the bounds of the problem.
    max_plans : int
        Largest number of plans to refine in each round.
    max_iterations : int
        Largest number of iterations for each plan.

    Returns
    -------
    array, shape (n, n_var)

    Raises
    ------
    ValueError
        If the problem has other objectives.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude import AttitudeManeuverProblem, Scenario, refine_plans
    >>> scenario = Scenario.from_dict({"preset": "paper", "step": 4.0})
    >>> problem = AttitudeManeuverProblem(scenario)
    >>> designs = np.array([[0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, 0.4, 0.7, 600.0]])
    >>> better = refine_plans(problem, designs, max_iterations=3)
    >>> bool((problem.evaluate(better)[0] <= problem.evaluate(designs)[0]).all())
    True
    """
    result = np.atleast_2d(np.array(designs, dtype=float))
    for better in iterate_refinement(problem, result, max_plans, max_iterations):
        result = better
    return result


def iterate_refinement(
    problem: PlanProblem,
    designs: ArrayLike,
    max_plans: int = MAX_PLANS,
    max_iterations: int = MAX_ITERATIONS,
    add_plans: bool = False,
) -> Iterator[Floats]:
    """Refine the plans of a front in batches, and yield all plans after each batch.

    Each element has the refined plans in the order of `designs`, followed by the added plans. No
    plan is worse than in the element before.

    Parameters
    ----------
    problem, designs, max_plans, max_iterations
        See `refine_plans`.
    add_plans : bool
        Whether to append plans for end times between those of `designs`.

    Returns
    -------
    iterator of array, shape (n + a, n_var)
        The refined plans, then a added plans.

    Raises
    ------
    ValueError
        If the problem has other objectives than `refine_plans` needs.
    """
    objective_name = find_smooth_objective(problem.objectives)
    X = np.atleast_2d(np.array(designs, dtype=float))
    return _iterate_batches(problem, objective_name, X, (max_plans, max_iterations), add_plans)


def _iterate_batches(
    problem: PlanProblem, objective_name: str, X: Floats, size: tuple[int, int], add_plans: bool
) -> Iterator[Floats]:
    (max_plans, max_iterations), evaluate_designs = size, build_design_evaluator(problem)
    if not X.size:
        return
    evaluator = build_fixed_time_evaluator(problem, objective_name)
    time_column = problem.objectives.index("t_end")
    order = [time_column, 1 - time_column]

    def evaluate_in_order(designs: Floats) -> tuple[Floats, Floats]:
        F, violation = evaluate_designs(designs)
        return F[:, order], violation

    is_robust = problem.scenario.monte_carlo is not None
    front = RefinementFront(evaluate_in_order, X, _MAX_TIME_RATIO if add_plans else np.inf)
    refined: list[Floats] = []
    thinned = ThinnedSamples(evaluator)
    completed: list[Floats] = []
    finished: set[int] = set()
    for round_index, (n_initial, share, uses_beams) in enumerate(_ROUNDS):
        candidates = _select_rows(evaluator, front, max_plans, bool(round_index))
        rows = [row for row in candidates if row not in finished]
        finished.update(rows)
        for batch in _group_rows(thinned, front, rows):
            ends = np.array(
                [_compute_refinement_time(evaluator, front.times[row]) for row in batch]
            )
            initial = [
                _build_initial_designs(
                    thinned,
                    plan,
                    refined,
                    until,
                    _select_beam_searches(evaluator, until) if uses_beams else (),
                )
                for plan, until in zip(front.X[batch], ends, strict=True)
            ]
            improved = thinned.refine_designs(
                initial, ends, max(round(share * max_iterations), 1), n_initial
            )
            refined += list(improved)
            acceptance = None if is_robust else evaluate_in_order
            with_rates = [
                _append_final_rates(thinned, each, until, acceptance)
                for each, until in zip(improved, ends, strict=True)
            ]
            front.store_improvements(
                np.vstack(
                    [each[:_N_MONTE_CARLO_RATES] if is_robust else each for each in with_rates]
                )
            )
            completed.extend(np.vstack([each[:_N_FINAL_RATES] for each in with_rates]))
            yield front.plans
    if completed and not is_robust:
        front.store_improvements(_adapt_refined_plans(thinned, np.array(completed), front.times))
        yield front.plans
    front.replace_dominated()
    yield front.plans
    if refined and not is_robust:
        yield remove_ineffective_maneuvers(problem, front.plans)


def _group_rows(
    thinned: ThinnedSamples, front: RefinementFront, rows: list[int]
) -> list[list[int]]:
    """Group plans of the front into small batches. The plans of a batch are refined with the same
    number of measurement samples merged into one.
    """
    groups: dict[int, list[int]] = {}
    for row in rows:
        n_merged = thinned.count_merged_samples(
            _compute_refinement_time(thinned.full_evaluator, front.times[row]) or 0.0
        )
        groups.setdefault(n_merged, []).append(row)
    return [
        group[first : first + _BATCH_SIZE]
        for group in groups.values()
        for first in range(0, len(group), _BATCH_SIZE)
    ]


def _select_rows(
    evaluator: FixedTimeEvaluator, front: RefinementFront, n_max: int, select_between: bool
) -> list[int]:
    """Select up to `n_max` plans of the front with nearly logarithmically spaced end times.

    The result contains their rows in ascending order of the end time. If `select_between` is True,
    select up to `n_max` - 1 plans between those instead.
    """
    rows = front.rows
    times = front.times[rows]
    refinement_times = np.array(
        [_compute_refinement_time(evaluator, time) or 0.0 for time in times]
    )
    candidates = np.flatnonzero(
        (refinement_times > 0.0) & (times >= _MIN_TIME_SHARE * evaluator.model.duration)
    )
    if not len(candidates):
        return []
    candidates = candidates[np.argsort(times[candidates], kind="stable")]
    order, logs = rows[candidates], np.log(refinement_times[candidates])
    targets = np.linspace(logs[0], logs[-1], 2 * n_max - 1)[int(select_between) :: 2]
    nearest = np.unique(np.abs(logs[:, None] - targets).argmin(axis=0))
    selection: list[int] = order[nearest].tolist()
    return selection


def _has_final_rate(evaluator: FixedTimeEvaluator) -> bool:
    """Return True if the last maneuver of each plan serves only to let the filter converge.

    Such a maneuver is not refined.
    """
    return evaluator.model.rule == "trace" and evaluator.scenario.maneuvers.count > 1


def _compute_refinement_time(evaluator: FixedTimeEvaluator, t_end: float) -> float | None:
    """Return the time [s] at which the objective of a plan with a given end time is minimized.

    With a final rate, this is one window before the end. The result is None for a plan that is too
    short or does not end.
    """
    if not np.isfinite(t_end):
        return None
    steps = math.floor(t_end / evaluator.model.step + _STEP_TOLERANCE)
    steps -= evaluator.model.window_steps if _has_final_rate(evaluator) else 0
    return steps * evaluator.model.step if steps >= 2 else None


def _select_beam_searches(evaluator: FixedTimeEvaluator, time: float) -> tuple[BeamSettings, ...]:
    n_rotations = evaluator.scenario.maneuvers.max_rate_deg_s * time / 360.0
    return _SHORT_PLAN_BEAMS if n_rotations <= _MAX_SHORT_PLAN_ROTATIONS else _LONG_PLAN_BEAMS


def _build_initial_designs(
    thinned: ThinnedSamples,
    design: Floats,
    refined: list[Floats],
    time: float,
    beams: Iterable[BeamSettings],
) -> Floats:
    evaluator = thinned.full_evaluator
    count = design.size // VARIABLES_PER_MANEUVER - _has_final_rate(evaluator)
    max_duration = evaluator.scenario.maneuvers.max_duration
    designs = [set_end_times(design[None, : VARIABLES_PER_MANEUVER * count], time, max_duration)]
    for n_levels, width, length_ratio in beams:
        plans = beam_search(thinned.get_evaluator(time), count, time, n_levels, width, length_ratio)
        designs.append(plans[:: -(-len(plans) // _N_BEAM_PLANS)])
    if refined:
        plans = np.array(refined)
        nearest = _find_nearest_rows(evaluator, plans, time, _N_NEAREST)
        designs.append(_adapt_to_times(evaluator, plans[nearest], time))
    return np.vstack(designs)


def _adapt_to_times(evaluator: FixedTimeEvaluator, plans: Floats, times: Floats | float) -> Floats:
    """Adapt each plan to a new end time in three ways.

    The results are plans that are cut off or extended at the end, plans with stretched durations,
    and plans with stretched durations and scaled rates.
    """
    limits, factors = evaluator.scenario.maneuvers, times / _sum_durations(plans)
    return np.vstack(
        [
            set_end_times(plans, times, limits.max_duration),
            stretch_durations(plans, factors, limits.max_duration),
            scale_time(plans, factors, limits.max_duration, limits.max_rate_deg_s),
        ]
    )


def _find_nearest_rows(
    evaluator: FixedTimeEvaluator, plans: Floats, time: float, n_max: int
) -> Ints:
    total = _sum_durations(plans)
    nonzero = np.flatnonzero(total >= evaluator.model.step)
    distance = np.abs(np.log(total[nonzero] / time))
    return nonzero[np.argsort(distance, kind="stable")[:n_max]]


def _append_final_rates(
    thinned: ThinnedSamples, refined: Floats, time: float, evaluate_designs: DesignEvaluator | None
) -> Floats:
    """Return copies of a refined plan, each extended by a final maneuver at a rate at which the
    filter converges.

    If no final rate is needed, the result is one plan, with maneuvers that end at filter steps.
    """
    if not _has_final_rate(thinned.full_evaluator):
        return round_to_steps(thinned.full_evaluator, refined[None])
    return append_converging_rate(
        thinned.full_evaluator, refined, evaluate_designs, thinned.get_evaluator(time)
    )


def _adapt_refined_plans(thinned: ThinnedSamples, plans: Floats, times: Floats) -> Floats:
    """Adapt refined plans to the end times of other plans, and return the best results.

    A few results are returned for each end time.
    """
    evaluator = thinned.full_evaluator
    has_final_rate = _has_final_rate(evaluator)
    # This number of plans differ only in the final rate.
    n_similar = _N_FINAL_RATES if has_final_rate else 1
    size = VARIABLES_PER_MANEUVER * (evaluator.scenario.maneuvers.count - has_final_rate)
    refinement_times = [_compute_refinement_time(evaluator, t_end) for t_end in np.unique(times)]
    targets = [time for time in refinement_times if time is not None]
    if not targets:
        return plans
    rows = [
        _find_nearest_rows(evaluator, plans[:, :size], time, n_similar * _N_CANDIDATES)
        for time in targets
    ]
    indices, end_times = np.concatenate(rows), np.repeat(targets, [len(each) for each in rows])
    bodies = _adapt_to_times(evaluator, plans[indices, :size], end_times)
    tails = np.tile(plans[indices, size:], (len(bodies) // len(indices), 1))
    best = thinned.select_best_per_time(
        bodies, np.resize(end_times, len(bodies)), n_similar * _N_EVALUATED
    )
    bodies, tails = bodies[best], tails[best]
    result = np.hstack([bodies, tails]) if has_final_rate else round_to_steps(evaluator, bodies)
    return np.unique(result, axis=0)


def _sum_durations(designs: Floats) -> Floats:
    total: Floats = get_durations(designs).sum(axis=1)
    return total
