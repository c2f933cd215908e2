"""A front of plans made better one by one, by the slopes of what is known at their ends."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.objectives import smooth_objective
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

#: Plans of a front that are polished, and iterations for each.
MOST, ITERATIONS = 16, 48
#: Of these so many are polished side by side, which takes less than one by one: a step.
_TOGETHER = 4
#: Levels of rates of a beam, its width, and how much shorter stages become.
Beam = tuple[int, int, float]
#: Those of plans of at most so many turns at the greatest rate, which want wide ones of that rate,
#: and of longer ones, which want stages that become shorter.
_TURNS = 4.0
_EARLY_BEAMS: tuple[Beam, ...] = ((2, 100, 1.0), (3, 10, 0.9))
_LATE_BEAMS: tuple[Beam, ...] = ((3, 15, 0.9), (3, 15, 0.8))
#: How many of a beam's plans are begins.
_OF_BEAM = 8
#: Of the plans that are polished first, and of those between them: from how many each is begun, its
#: share of the iterations, and whether from beams.
_ROUNDS = (16, 0.6, True), (3, 0.4, False)
#: Of plans with rates held after them, those judged over flights, and those tried at other times.
_FLOWN, _HELD = 4, 6
#: How many of the polished plans are tried at another time, and how many of what comes of them.
_TRIED, _TAKEN = 3, 2
#: By how much of a step a time is late that is on a step but for rounding.
_EARLY = 1e-6
#: Share of the longest run before which plans are not polished.
_EARLIEST = 0.02
#: Ratio of the times of plans between which others are added.
_RATIO = 1.01
#: Polished plans from which others begin.
_NEAREST = 3


def polish(
    problem: PlanProblem, designs: ArrayLike, most: int = MOST, iterations: int = ITERATIONS
) -> Floats:
    """Plans that end no later than those given and know more then, row by row.

    Of a front, `most` plans at even ratios of their times are polished, in the order of these, a
    few side by side. Each begins from the best of itself, those before and beams (`starts.beam`);
    then those between them, without beams and with fewer iterations. By the rule "trace" of
    convergence what is polished is what a plan knows a window before its end; then it holds a rate
    by which the rule finds it converged. What is found is tried at the times of all others, too,
    and at last maneuvers that are of no use are left out. A row for which nothing better was found,
    or that would break a limit, stays as it is.

    Where plans are judged over flights, slopes are those of plans flown exactly; the flights tell
    whether what is found is better.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
        Whose objectives are the time and one that tells how much is known.
    designs : array_like, shape (n, n_var)
        Within the problem's bounds.
    most, iterations : int
        How many plans are polished, and the most iterations for each.

    Returns
    -------
    array, shape (n, n_var)

    Raises
    ------
    ValueError
        For a problem with other objectives.

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
    found = np.atleast_2d(np.array(designs, dtype=float))
    for better in polish_steps(problem, found, most, iterations):
        found = better
    return found


def polish_steps(
    problem: PlanProblem,
    designs: ArrayLike,
    most: int = MOST,
    iterations: int = ITERATIONS,
    more: bool = False,
) -> Iterator[Floats]:
    """What `polish` has after each plan, each table as good as the one before or better.

    With `more`, plans for times between those of the rows follow these, as they are found.
    """
    name = smooth_objective(problem.objectives)
    found = np.atleast_2d(np.array(designs, dtype=float))
    return _tables(problem, name, found, (most, iterations), more)


def _tables(
    problem: PlanProblem, name: str, found: Floats, size: tuple[int, int], more: bool
) -> Iterator[Floats]:
    (most, iterations), judge = size, judged_by(problem)
    if not found.size:
        return
    at = at_time(problem, name)
    time = problem.objectives.index("t_end")
    order = [time, 1 - time]

    def in_order(designs: Floats) -> tuple[Floats, Floats]:
        F, violation = judge(designs)
        return F[:, order], violation

    flown = problem.scenario.flight is not None
    front = Front(in_order, found, _RATIO if more else np.inf)
    learned: list[Floats] = []
    thinned = ThinnedSamples(at)
    new: list[Floats] = []
    done: set[int] = set()
    for between, (tried, share, beams) in enumerate(_ROUNDS):
        rows = [row for row in _spread(at, front, most, bool(between)) if row not in done]
        done.update(rows)
        for own in _alike(thinned, front, rows):
            ends = np.array([_learning(at, front.times[row]) for row in own])
            begins = [
                _begins(thinned, plan, learned, until, _beams(at, until) if beams else ())
                for plan, until in zip(front.X[own], ends, strict=True)
            ]
            better = thinned.descended(begins, ends, max(round(share * iterations), 1), tried)
            learned += list(better)
            of_plans = None if flown else in_order
            held = [
                _ended(thinned, each, until, of_plans)
                for each, until in zip(better, ends, strict=True)
            ]
            front.take(np.vstack([each[:_FLOWN] if flown else each for each in held]))
            new.extend(np.vstack([each[:_HELD] for each in held]))
            yield front.plans
    if new and not flown:
        front.take(_at_other_times(thinned, np.array(new), front.times))
        yield front.plans
    front.settle()
    yield front.plans
    if learned and not flown:
        yield without_unneeded(problem, front.plans)


def _alike(thinned: ThinnedSamples, front: Front, rows: list[int]) -> list[list[int]]:
    """Rows that are polished side by side: of as few samples."""
    groups: dict[int, list[int]] = {}
    for row in rows:
        few = thinned.every(_learning(thinned.exact, front.times[row]) or 0.0)
        groups.setdefault(few, []).append(row)
    return [
        own[first : first + _TOGETHER]
        for own in groups.values()
        for first in range(0, len(own), _TOGETHER)
    ]


def _spread(at: AtTime, front: Front, most: int, between: bool) -> list[int]:
    """Rows that learn until times at about even ratios, the earliest first.

    At most so many; and as many, less one, `between` them.
    """
    rows = front.rows
    times = front.times[rows]
    learning = np.array([_learning(at, time) or 0.0 for time in times])
    known = np.flatnonzero((learning > 0.0) & (times >= _EARLIEST * at.model.longest))
    if not len(known):
        return []
    known = known[np.argsort(times[known], kind="stable")]
    order, logs = rows[known], np.log(learning[known])
    asked = np.linspace(logs[0], logs[-1], 2 * most - 1)[int(between) :: 2]
    nearest = np.unique(np.abs(logs[:, None] - asked).argmin(axis=0))
    found: list[int] = order[nearest].tolist()
    return found


def _holds(at: AtTime) -> bool:
    """Whether the last maneuver is there to converge, and not to learn."""
    return at.model.rule == "trace" and at.scenario.maneuvers.count > 1


def _learning(at: AtTime, t_end: float) -> float | None:
    """Until when a plan that ends at a time [s] learns; None if there is nothing of it."""
    if not np.isfinite(t_end):
        return None
    steps = math.floor(t_end / at.model.step + _EARLY)
    steps -= at.model.window_steps if _holds(at) else 0
    return steps * at.model.step if steps >= 2 else None


def _beams(at: AtTime, time: float) -> tuple[Beam, ...]:
    """That plans for a time [s] begin from."""
    turns = at.scenario.maneuvers.max_rate_deg_s * time / 360.0
    return _EARLY_BEAMS if turns <= _TURNS else _LATE_BEAMS


def _begins(
    thinned: ThinnedSamples,
    design: Floats,
    learned: list[Floats],
    time: float,
    beams: Iterable[Beam],
) -> Floats:
    """Plans to begin the polish for a time [s] from, shape (k, 4 m)."""
    at = thinned.exact
    count = design.size // VARIABLES_PER_MANEUVER - _holds(at)
    longest = at.scenario.maneuvers.max_duration
    found = [ending_at(design[None, : VARIABLES_PER_MANEUVER * count], time, longest)]
    for levels, width, shorter in beams:
        plans = beam(thinned.at(time), count, time, levels, width, shorter)
        found.append(plans[:: -(-len(plans) // _OF_BEAM)])
    if learned:
        plans = np.array(learned)
        found.append(_ending_then(at, plans[_nearest(at, plans, time, _NEAREST)], time))
    return np.vstack(found)


def _ending_then(at: AtTime, plans: Floats, times: Floats | float) -> Floats:
    """Plans, shape (k, 4 m), as they end at times: cut or held, made longer, and slower."""
    limits, factors = at.scenario.maneuvers, times / _total(plans)
    return np.vstack(
        [
            ending_at(plans, times, limits.max_duration),
            stretched(plans, factors, limits.max_duration),
            slowed(plans, factors, limits.max_duration, limits.max_rate_deg_s),
        ]
    )


def _nearest(at: AtTime, plans: Floats, time: float, most: int) -> Ints:
    """Rows of plans that last, of the few that last about as long as a time."""
    total = _total(plans)
    lasting = np.flatnonzero(total >= at.model.step)
    far = np.abs(np.log(total[lasting] / time))
    return lasting[np.argsort(far, kind="stable")[:most]]


def _ended(thinned: ThinnedSamples, learned: Floats, time: float, judge: Judge | None) -> Floats:
    """What is learned until a time [s], with rates held until the filter has converged."""
    if not _holds(thinned.exact):
        return on_steps(thinned.exact, learned[None])
    return until_converged(thinned.exact, learned, judge, thinned.at(time))


def _at_other_times(thinned: ThinnedSamples, plans: Floats, times: Floats) -> Floats:
    """Polished plans as they are made longer, slower or shorter, to end at other times.

    Of those for a time the few that few samples say to teach most until then.
    """
    at = thinned.exact
    alike = _HELD if _holds(at) else 1  # but for the rate that is held
    size = VARIABLES_PER_MANEUVER * (at.scenario.maneuvers.count - _holds(at))
    learning = [_learning(at, t_end) for t_end in np.unique(times)]
    asked = [time for time in learning if time is not None]
    if not asked:
        return plans
    rows = [_nearest(at, plans[:, :size], time, alike * _TRIED) for time in asked]
    which, until = np.concatenate(rows), np.repeat(asked, [len(each) for each in rows])
    bodies = _ending_then(at, plans[which, :size], until)
    tails = np.tile(plans[which, size:], (len(bodies) // len(which), 1))
    best = thinned.best_of_each(bodies, np.resize(until, len(bodies)), alike * _TAKEN)
    bodies, tails = bodies[best], tails[best]
    found = np.hstack([bodies, tails]) if _holds(at) else on_steps(at, bodies)
    return np.unique(found, axis=0)


def _total(designs: Floats) -> Floats:
    """Of all maneuvers [s], shape (n,)."""
    total: Floats = durations_of(designs).sum(axis=1)
    return total
