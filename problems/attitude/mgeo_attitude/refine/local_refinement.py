"""Local refinement of the plans of a front, by gradients of the final value."""

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

#: Number of plans of a front to refine, and of iterations for each.
MAX_PLANS, MAX_ITERATIONS = 16, 48
#: Number of plans that are refined in one batch.
_BATCH_SIZE = 4
#: Beam search: rate levels per axis, width, and ratio of the lengths of consecutive stages.
BeamSettings = tuple[int, int, float]
#: Beam searches for plans of at most `_TURNS` rotations at the maximum rate, which need a wide beam
#: of maximum rates, and for longer plans, which need stages of decreasing length.
_MAX_EARLY_ROTATIONS = 4.0
_EARLY_BEAMS: tuple[BeamSettings, ...] = ((2, 100, 1.0), (3, 10, 0.9))
_LATE_BEAMS: tuple[BeamSettings, ...] = ((3, 15, 0.9), (3, 15, 0.8))
#: Number of plans of a beam search that become initial designs.
_N_BEAM_PLANS = 8
#: For the first round of plans and for the plans between them: number of initial designs, share of
#: the iterations, and whether beam searches provide initial designs.
_ROUNDS = (16, 0.6, True), (3, 0.4, False)
#: Number of final rates per plan that Monte Carlo runs evaluate, and that are tried at other times.
_N_MONTE_CARLO_RATES, _N_FINAL_RATES = 4, 6
#: Number of refined plans that are tried at another time, and of results that are evaluated.
_N_CANDIDATES, _N_EVALUATED = 3, 2
#: Tolerance for a time on a step, in steps.
_STEP_TOLERANCE = 1e-6
#: Earliest end of a plan to refine, as a share of the longest run.
_MIN_TIME_SHARE = 0.02
#: Ratio of the times of neighboring plans above which plans are added between them.
_MAX_TIME_RATIO = 1.01
#: Number of refined plans that serve as initial designs of another plan.
_N_NEAREST = 3


def refine_plans(
    problem: PlanProblem,
    designs: ArrayLike,
    max_plans: int = MAX_PLANS,
    max_iterations: int = MAX_ITERATIONS,
) -> Floats:
    """Return plans that end no later than the given ones and have no higher value, row by row.

    Up to `max_plans` plans of the front, at approximately equal ratios of their times, are refined. The
    initial designs of a refinement are the plan, other refined plans and beam searches
    (`starts.beam_search`). The plans between them follow, with fewer iterations and without beam searches.
    All results are also tried at the times of the other plans, and maneuvers without effect are
    removed. A row without a better feasible plan stays unchanged.

    With the convergence rule "trace", the value one window before the end is refined, and a final
    rate is chosen with which the filter converges. If the problem uses Monte Carlo runs, gradients
    are those of nominal runs, and results are accepted by the Monte Carlo values.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
        Its objectives are the time and one smooth objective of the covariance.
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
    >>> from mgeo_attitude import AttitudeManeuverProblem, Scenario, polish
    >>> scenario = Scenario.from_dict({"preset": "paper", "step": 4.0})
    >>> problem = AttitudeManeuverProblem(scenario)
    >>> designs = np.array([[0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, 0.4, 0.7, 600.0]])
    >>> better = polish(problem, designs, iterations=3)
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
    """Return an iterator over the plans after each batch of refinements.

    No table of plans is worse than the one before.

    Parameters
    ----------
    problem, designs, max_plans, max_iterations
        See `polish`.
    add_plans : bool
        Whether to append plans for times between those of the rows.

    Raises
    ------
    ValueError
        If the problem has other objectives than `polish` needs.
    """
    name = find_smooth_objective(problem.objectives)
    table = np.atleast_2d(np.array(designs, dtype=float))
    return _refine_tables(problem, name, table, (max_plans, max_iterations), add_plans)


def _refine_tables(
    problem: PlanProblem, name: str, table: Floats, size: tuple[int, int], add_plans: bool
) -> Iterator[Floats]:
    (most, iterations), judge = size, build_design_evaluator(problem)
    if not table.size:
        return
    at = build_fixed_time_evaluator(problem, name)
    time = problem.objectives.index("t_end")
    order = [time, 1 - time]

    def in_order(designs: Floats) -> tuple[Floats, Floats]:
        F, violation = judge(designs)
        return F[:, order], violation

    is_robust = problem.scenario.monte_carlo is not None
    front = RefinementFront(in_order, table, _MAX_TIME_RATIO if add_plans else np.inf)
    refined: list[Floats] = []
    thinned = ThinnedSamples(at)
    new: list[Floats] = []
    finished: set[int] = set()
    for between, (n_initial, share, uses_beams) in enumerate(_ROUNDS):
        rows = [row for row in _select_rows(at, front, most, bool(between)) if row not in finished]
        finished.update(rows)
        for own in _group_rows(thinned, front, rows):
            ends = np.array([_compute_refinement_time(at, front.times[row]) for row in own])
            initial = [
                _build_initial_designs(
                    thinned,
                    plan,
                    refined,
                    until,
                    _select_beam_searches(at, until) if uses_beams else (),
                )
                for plan, until in zip(front.X[own], ends, strict=True)
            ]
            better = thinned.refine_designs(
                initial, ends, max(round(share * iterations), 1), n_initial
            )
            refined += list(better)
            of_plans = None if is_robust else in_order
            with_rates = [
                _append_final_rates(thinned, each, until, of_plans)
                for each, until in zip(better, ends, strict=True)
            ]
            front.replace_rows(
                np.vstack(
                    [each[:_N_MONTE_CARLO_RATES] if is_robust else each for each in with_rates]
                )
            )
            new.extend(np.vstack([each[:_N_FINAL_RATES] for each in with_rates]))
            yield front.plans
    if new and not is_robust:
        front.replace_rows(_adapt_refined_plans(thinned, np.array(new), front.times))
        yield front.plans
    front.replace_dominated()
    yield front.plans
    if refined and not is_robust:
        yield remove_ineffective_maneuvers(problem, front.plans)


def _group_rows(
    thinned: ThinnedSamples, front: RefinementFront, rows: list[int]
) -> list[list[int]]:
    groups: dict[int, list[int]] = {}
    for row in rows:
        n_merged = thinned.count_merged_samples(
            _compute_refinement_time(thinned.full_evaluator, front.times[row]) or 0.0
        )
        groups.setdefault(n_merged, []).append(row)
    return [
        own[first : first + _BATCH_SIZE]
        for own in groups.values()
        for first in range(0, len(own), _BATCH_SIZE)
    ]


def _select_rows(
    evaluator: FixedTimeEvaluator, front: RefinementFront, n_max: int, between: bool
) -> list[int]:
    """Return up to `n_max` rows at approximately equal ratios of their times, earliest first.

    With `between`, return up to `n_max` - 1 rows between them.
    """
    rows = front.rows
    times = front.times[rows]
    learning = np.array([_compute_refinement_time(evaluator, time) or 0.0 for time in times])
    candidates = np.flatnonzero(
        (learning > 0.0) & (times >= _MIN_TIME_SHARE * evaluator.model.duration)
    )
    if not len(candidates):
        return []
    candidates = candidates[np.argsort(times[candidates], kind="stable")]
    order, logs = rows[candidates], np.log(learning[candidates])
    targets = np.linspace(logs[0], logs[-1], 2 * n_max - 1)[int(between) :: 2]
    nearest = np.unique(np.abs(logs[:, None] - targets).argmin(axis=0))
    selection: list[int] = order[nearest].tolist()
    return selection


def _has_final_rate(evaluator: FixedTimeEvaluator) -> bool:
    """Return whether the last maneuver only serves convergence, not observability."""
    return evaluator.model.rule == "trace" and evaluator.scenario.maneuvers.count > 1


def _compute_refinement_time(evaluator: FixedTimeEvaluator, t_end: float) -> float | None:
    """Return the time [s] at which the value of a plan with this end is refined, or None."""
    if not np.isfinite(t_end):
        return None
    steps = math.floor(t_end / evaluator.model.step + _STEP_TOLERANCE)
    steps -= evaluator.model.window_steps if _has_final_rate(evaluator) else 0
    return steps * evaluator.model.step if steps >= 2 else None


def _select_beam_searches(evaluator: FixedTimeEvaluator, time: float) -> tuple[BeamSettings, ...]:
    turns = evaluator.scenario.maneuvers.max_rate_deg_s * time / 360.0
    return _EARLY_BEAMS if turns <= _MAX_EARLY_ROTATIONS else _LATE_BEAMS


def _build_initial_designs(
    thinned: ThinnedSamples,
    design: Floats,
    refined: list[Floats],
    time: float,
    beams: Iterable[BeamSettings],
) -> Floats:
    at = thinned.full_evaluator
    count = design.size // VARIABLES_PER_MANEUVER - _has_final_rate(at)
    longest = at.scenario.maneuvers.max_duration
    parts = [set_end_times(design[None, : VARIABLES_PER_MANEUVER * count], time, longest)]
    for levels, width, shorter in beams:
        plans = beam_search(thinned.get_evaluator(time), count, time, levels, width, shorter)
        parts.append(plans[:: -(-len(plans) // _N_BEAM_PLANS)])
    if refined:
        plans = np.array(refined)
        parts.append(
            _adapt_to_times(at, plans[_find_nearest_rows(at, plans, time, _N_NEAREST)], time)
        )
    return np.vstack(parts)


def _adapt_to_times(evaluator: FixedTimeEvaluator, plans: Floats, times: Floats | float) -> Floats:
    """Return plans, shape (k, 4 m), that end at other times: cut or extended, stretched, slowed."""
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
    """Return the rows of the `n_max` plans whose total duration is closest to a time [s]."""
    total = _sum_durations(plans)
    nonzero = np.flatnonzero(total >= evaluator.model.step)
    far = np.abs(np.log(total[nonzero] / time))
    return nonzero[np.argsort(far, kind="stable")[:n_max]]


def _append_final_rates(
    thinned: ThinnedSamples, refined: Floats, time: float, evaluate_designs: DesignEvaluator | None
) -> Floats:
    """Return designs that end a refined plan with a final rate, if the rule needs one."""
    if not _has_final_rate(thinned.full_evaluator):
        return round_to_steps(thinned.full_evaluator, refined[None])
    return append_converging_rate(
        thinned.full_evaluator, refined, evaluate_designs, thinned.get_evaluator(time)
    )


def _adapt_refined_plans(thinned: ThinnedSamples, plans: Floats, times: Floats) -> Floats:
    """Adapt refined plans to other end times.

    Thinned samples select the few best plans for each time.
    """
    at = thinned.full_evaluator
    alike = (
        _N_FINAL_RATES if _has_final_rate(at) else 1
    )  # So many plans differ only in the final rate.
    size = VARIABLES_PER_MANEUVER * (at.scenario.maneuvers.count - _has_final_rate(at))
    learning = [_compute_refinement_time(at, t_end) for t_end in np.unique(times)]
    targets = [time for time in learning if time is not None]
    if not targets:
        return plans
    rows = [
        _find_nearest_rows(at, plans[:, :size], time, alike * _N_CANDIDATES) for time in targets
    ]
    which, until = np.concatenate(rows), np.repeat(targets, [len(each) for each in rows])
    bodies = _adapt_to_times(at, plans[which, :size], until)
    tails = np.tile(plans[which, size:], (len(bodies) // len(which), 1))
    best = thinned.select_best_per_time(bodies, np.resize(until, len(bodies)), alike * _N_EVALUATED)
    bodies, tails = bodies[best], tails[best]
    result = np.hstack([bodies, tails]) if _has_final_rate(at) else round_to_steps(at, bodies)
    return np.unique(result, axis=0)


def _sum_durations(designs: Floats) -> Floats:
    total: Floats = get_durations(designs).sum(axis=1)
    return total
