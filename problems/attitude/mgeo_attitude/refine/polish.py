"""Local refinement of the plans of a front, by gradients of the final value."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.objectives import find_smooth_objective
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, durations_of
from mgeo_attitude.refine.at_time import (
    AtTime,
    Judge,
    PlanProblem,
    at_time,
    ending_at,
    judged_by,
    on_steps,
    slowed,
    stretched,
)
from mgeo_attitude.refine.front import Front
from mgeo_attitude.refine.splitting import without_unneeded
from mgeo_attitude.refine.starts import beam, until_converged
from mgeo_attitude.refine.thinned_samples import ThinnedSamples

#: Number of plans of a front to refine, and of iterations for each.
MOST, ITERATIONS = 16, 48
#: Number of plans that are refined in one batch.
_TOGETHER = 4
#: Beam search: rate levels per axis, width, and ratio of the lengths of consecutive stages.
Beam = tuple[int, int, float]
#: Beam searches for plans of at most `_TURNS` rotations at the maximum rate, which need a wide beam
#: of maximum rates, and for longer plans, which need stages of decreasing length.
_TURNS = 4.0
_EARLY_BEAMS: tuple[Beam, ...] = ((2, 100, 1.0), (3, 10, 0.9))
_LATE_BEAMS: tuple[Beam, ...] = ((3, 15, 0.9), (3, 15, 0.8))
#: Number of plans of a beam search that become initial designs.
_OF_BEAM = 8
#: For the first round of plans and for the plans between them: number of initial designs, share of
#: the iterations, and whether beam searches provide initial designs.
_ROUNDS = (16, 0.6, True), (3, 0.4, False)
#: Number of final rates per plan that Monte Carlo runs evaluate, and that are tried at other times.
_FLOWN, _HELD = 4, 6
#: Number of refined plans that are tried at another time, and of results that are evaluated.
_TRIED, _TAKEN = 3, 2
#: Tolerance for a time on a step, in steps.
_EARLY = 1e-6
#: Earliest end of a plan to refine, as a share of the longest run.
_EARLIEST = 0.02
#: Ratio of the times of neighboring plans above which plans are added between them.
_RATIO = 1.01
#: Number of refined plans that serve as initial designs of another plan.
_NEAREST = 3


def polish(
    problem: PlanProblem, designs: ArrayLike, most: int = MOST, iterations: int = ITERATIONS
) -> Floats:
    """Return plans that end no later than the given ones and have no higher value, row by row.

    Up to `most` plans of the front, at approximately equal ratios of their times, are refined. The
    initial designs of a refinement are the plan, other refined plans and beam searches
    (`starts.beam`). The plans between them follow, with fewer iterations and without beam searches.
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
    most : int
        Largest number of plans to refine in each round.
    iterations : int
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
    for better in polish_steps(problem, result, most, iterations):
        result = better
    return result


def polish_steps(
    problem: PlanProblem,
    designs: ArrayLike,
    most: int = MOST,
    iterations: int = ITERATIONS,
    more: bool = False,
) -> Iterator[Floats]:
    """Return an iterator over the plans after each batch of refinements.

    No table of plans is worse than the one before.

    Parameters
    ----------
    problem, designs, most, iterations
        See `polish`.
    more : bool
        Whether to append plans for times between those of the rows.

    Raises
    ------
    ValueError
        If the problem has other objectives than `polish` needs.
    """
    name = find_smooth_objective(problem.objectives)
    table = np.atleast_2d(np.array(designs, dtype=float))
    return _refine_tables(problem, name, table, (most, iterations), more)


def _refine_tables(
    problem: PlanProblem, name: str, table: Floats, size: tuple[int, int], more: bool
) -> Iterator[Floats]:
    (most, iterations), judge = size, judged_by(problem)
    if not table.size:
        return
    at = at_time(problem, name)
    time = problem.objectives.index("t_end")
    order = [time, 1 - time]

    def in_order(designs: Floats) -> tuple[Floats, Floats]:
        F, violation = judge(designs)
        return F[:, order], violation

    is_robust = problem.scenario.flight is not None
    front = Front(in_order, table, _RATIO if more else np.inf)
    refined: list[Floats] = []
    thinned = ThinnedSamples(at)
    new: list[Floats] = []
    finished: set[int] = set()
    for between, (n_initial, share, uses_beams) in enumerate(_ROUNDS):
        rows = [row for row in _select_rows(at, front, most, bool(between)) if row not in finished]
        finished.update(rows)
        for own in _group_rows(thinned, front, rows):
            ends = np.array([_refinement_time(at, front.times[row]) for row in own])
            initial = [
                _initial_designs(
                    thinned, plan, refined, until, _beam_searches(at, until) if uses_beams else ()
                )
                for plan, until in zip(front.X[own], ends, strict=True)
            ]
            better = thinned.descended(initial, ends, max(round(share * iterations), 1), n_initial)
            refined += list(better)
            of_plans = None if is_robust else in_order
            with_rates = [
                _append_final_rates(thinned, each, until, of_plans)
                for each, until in zip(better, ends, strict=True)
            ]
            front.take(np.vstack([each[:_FLOWN] if is_robust else each for each in with_rates]))
            new.extend(np.vstack([each[:_HELD] for each in with_rates]))
            yield front.plans
    if new and not is_robust:
        front.take(_retime(thinned, np.array(new), front.times))
        yield front.plans
    front.settle()
    yield front.plans
    if refined and not is_robust:
        yield without_unneeded(problem, front.plans)


def _group_rows(thinned: ThinnedSamples, front: Front, rows: list[int]) -> list[list[int]]:
    groups: dict[int, list[int]] = {}
    for row in rows:
        n_merged = thinned.every(_refinement_time(thinned.exact, front.times[row]) or 0.0)
        groups.setdefault(n_merged, []).append(row)
    return [
        own[first : first + _TOGETHER]
        for own in groups.values()
        for first in range(0, len(own), _TOGETHER)
    ]


def _select_rows(at: AtTime, front: Front, most: int, between: bool) -> list[int]:
    """Return up to `most` rows at approximately equal ratios of their times, earliest first.

    With `between`, return up to `most` - 1 rows between them.
    """
    rows = front.rows
    times = front.times[rows]
    learning = np.array([_refinement_time(at, time) or 0.0 for time in times])
    candidates = np.flatnonzero((learning > 0.0) & (times >= _EARLIEST * at.model.duration))
    if not len(candidates):
        return []
    candidates = candidates[np.argsort(times[candidates], kind="stable")]
    order, logs = rows[candidates], np.log(learning[candidates])
    targets = np.linspace(logs[0], logs[-1], 2 * most - 1)[int(between) :: 2]
    nearest = np.unique(np.abs(logs[:, None] - targets).argmin(axis=0))
    selection: list[int] = order[nearest].tolist()
    return selection


def _has_final_rate(at: AtTime) -> bool:
    """Return whether the last maneuver only serves convergence, not observability."""
    return at.model.rule == "trace" and at.scenario.maneuvers.count > 1


def _refinement_time(at: AtTime, t_end: float) -> float | None:
    """Return the time [s] at which the value of a plan with this end is refined, or None."""
    if not np.isfinite(t_end):
        return None
    steps = math.floor(t_end / at.model.step + _EARLY)
    steps -= at.model.window_steps if _has_final_rate(at) else 0
    return steps * at.model.step if steps >= 2 else None


def _beam_searches(at: AtTime, time: float) -> tuple[Beam, ...]:
    turns = at.scenario.maneuvers.max_rate_deg_s * time / 360.0
    return _EARLY_BEAMS if turns <= _TURNS else _LATE_BEAMS


def _initial_designs(
    thinned: ThinnedSamples,
    design: Floats,
    refined: list[Floats],
    time: float,
    beams: Iterable[Beam],
) -> Floats:
    at = thinned.exact
    count = design.size // VARIABLES_PER_MANEUVER - _has_final_rate(at)
    longest = at.scenario.maneuvers.max_duration
    parts = [ending_at(design[None, : VARIABLES_PER_MANEUVER * count], time, longest)]
    for levels, width, shorter in beams:
        plans = beam(thinned.at(time), count, time, levels, width, shorter)
        parts.append(plans[:: -(-len(plans) // _OF_BEAM)])
    if refined:
        plans = np.array(refined)
        parts.append(_adapt_to_times(at, plans[_nearest_rows(at, plans, time, _NEAREST)], time))
    return np.vstack(parts)


def _adapt_to_times(at: AtTime, plans: Floats, times: Floats | float) -> Floats:
    """Return plans, shape (k, 4 m), that end at other times: cut or extended, stretched, slowed."""
    limits, factors = at.scenario.maneuvers, times / _total_durations(plans)
    return np.vstack(
        [
            ending_at(plans, times, limits.max_duration),
            stretched(plans, factors, limits.max_duration),
            slowed(plans, factors, limits.max_duration, limits.max_rate_deg_s),
        ]
    )


def _nearest_rows(at: AtTime, plans: Floats, time: float, most: int) -> Ints:
    """Return the rows of the `most` plans whose total duration is closest to a time [s]."""
    total = _total_durations(plans)
    nonzero = np.flatnonzero(total >= at.model.step)
    far = np.abs(np.log(total[nonzero] / time))
    return nonzero[np.argsort(far, kind="stable")[:most]]


def _append_final_rates(
    thinned: ThinnedSamples, refined: Floats, time: float, judge: Judge | None
) -> Floats:
    """Return designs that end a refined plan with a final rate, if the rule needs one."""
    if not _has_final_rate(thinned.exact):
        return on_steps(thinned.exact, refined[None])
    return until_converged(thinned.exact, refined, judge, thinned.at(time))


def _retime(thinned: ThinnedSamples, plans: Floats, times: Floats) -> Floats:
    """Adapt refined plans to other end times.

    Thinned samples select the few best plans for each time.
    """
    at = thinned.exact
    alike = _HELD if _has_final_rate(at) else 1  # So many plans differ only in the final rate.
    size = VARIABLES_PER_MANEUVER * (at.scenario.maneuvers.count - _has_final_rate(at))
    learning = [_refinement_time(at, t_end) for t_end in np.unique(times)]
    targets = [time for time in learning if time is not None]
    if not targets:
        return plans
    rows = [_nearest_rows(at, plans[:, :size], time, alike * _TRIED) for time in targets]
    which, until = np.concatenate(rows), np.repeat(targets, [len(each) for each in rows])
    bodies = _adapt_to_times(at, plans[which, :size], until)
    tails = np.tile(plans[which, size:], (len(bodies) // len(which), 1))
    best = thinned.best_of_each(bodies, np.resize(until, len(bodies)), alike * _TAKEN)
    bodies, tails = bodies[best], tails[best]
    result = np.hstack([bodies, tails]) if _has_final_rate(at) else on_steps(at, bodies)
    return np.unique(result, axis=0)


def _total_durations(designs: Floats) -> Floats:
    total: Floats = durations_of(designs).sum(axis=1)
    return total
