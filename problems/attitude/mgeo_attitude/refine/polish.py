"""A front of plans made better one by one, by the slopes of what is known at their ends."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.objectives import smooth_objective
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.at_time import (
    AtTime,
    ending_at,
    slowed,
    stretched,
)
from mgeo_attitude.refine.front import Front
from mgeo_attitude.refine.held import held_rates
from mgeo_attitude.refine.judging import (
    PlanProblem,
    at_time,
    begins_with,
    judged_by,
    parts,
)
from mgeo_attitude.refine.roughly import SHORT, Roughly
from mgeo_attitude.refine.splitting import split, without_unneeded
from mgeo_attitude.refine.starts import receding_horizon

#: Plans of a front that are polished, and iterations for each.
MOST, ITERATIONS = 24, 30
#: How many times as many, with as much less of them, follow between those.
_BETWEEN = 3
#: How much longer than the first of a front's plans, over their number, all of it takes.
_STEPS = 2.0
#: From how many plans each of the former, and of the latter, is begun.
_BEGUN = 4, 2
#: Of the rates held after a plan those that are judged, over flights, and tried at other times.
_JUDGED, _FLOWN, _TRIED = 16, 4, 6
#: Share of the longest run before which plans are not polished.
_EARLIEST = 0.02
#: Ratio of the times of plans between which others are added.
_RATIO = 1.015
#: Polished plans from which others begin.
_NEAREST = 3
#: Shares of the number of maneuvers that are the stages of receding horizons to begin from; steps
#: after which these are no good begin.
_STAGES, _LATEST = (0.5, 0.6, 0.8, 1.0), 3000


def polish(
    problem: PlanProblem, designs: ArrayLike, most: int = MOST, iterations: int = ITERATIONS
) -> Floats:
    """Plans that end no later than those given and know more then, row by row.

    Of a front, `most` plans at even ratios of their times are polished, in the order of these. Each
    begins from the best of itself, those before and a `receding_horizon`; then as many between them
    as it takes to have three times `most`, with a third of the iterations. By the rule "trace" of
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
        Within the problem's bounds. A free start stays as it is.
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


class Steps(Iterator[Floats]):
    """Tables, and about how many steps as long as the first are left: its length hint."""

    def __init__(self, tables: Iterator[Floats], length: int) -> None:
        self._tables, self._length = tables, length

    def __next__(self) -> Floats:
        table = next(self._tables)
        self._length = max(self._length - 1, 0)
        return table

    def __length_hint__(self) -> int:
        return self._length


def polish_steps(
    problem: PlanProblem,
    designs: ArrayLike,
    most: int = MOST,
    iterations: int = ITERATIONS,
    more: bool = False,
) -> Steps:
    """What `polish` has after each plan, each table as good as the one before or better.

    With `more`, plans for times between those of the rows follow these, as they are found.
    """
    name = smooth_objective(problem.objectives)
    found = np.atleast_2d(np.array(designs, dtype=float))
    return Steps(_tables(problem, name, found, (most, iterations), more), round(_STEPS * most))


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
    shapes: list[Floats] = []
    done: set[int] = set()
    roughs: dict[bytes, Roughly] = {}  # of each start
    between = _BETWEEN * most, -(-iterations // _BETWEEN)
    for (rows, each), tried in zip(((most, iterations), between), _BEGUN, strict=True):
        new: list[Floats] = []
        for row in _spread(front, rows, _EARLIEST * at.model.longest):
            ends = _learning(at, front.times[row])
            if ends is None or row in done:
                continue
            (plan,), (start,) = parts(problem, front.X[[row]])
            if start.tobytes() not in roughs:
                roughs[start.tobytes()] = Roughly(at_time(problem, name, start))
            roughly = roughs[start.tobytes()]
            begins = _begins(roughly, plan, learned, ends, horizon=rows == most)
            learned.append(roughly.descended(begins, ends, each, tried))
            better = begins_with(_ended(roughly.exact, learned[-1]), start)
            front.take(better[: _FLOWN if flown else _JUDGED])
            new.extend(better[:_TRIED])
            done.add(int(row))
            yield front.plans
        if new and not flown:
            front.take(_at_other_times(at, new, front.times))
            yield front.plans
        shapes += new
    front.settle()
    yield front.plans
    if shapes and not flown:
        yield without_unneeded(problem, front.plans)


def _spread(front: Front, most: int, earliest: float) -> Ints:
    """Rows whose times are at about even ratios, the earliest first, at most so many."""
    times, rows = front.times, front.rows
    known: Ints = rows[np.isfinite(times[rows]) & (times[rows] >= earliest)]
    if not len(known):
        return known
    order = known[np.argsort(times[known], kind="stable")]
    logs = np.log(times[order])
    asked = np.linspace(logs[0], logs[-1], most)
    nearest = np.unique(np.abs(logs[:, None] - asked).argmin(axis=0))
    found: Ints = order[nearest]
    return found


def _holds(at: AtTime) -> bool:
    """Whether the last maneuver is there to converge, and not to learn."""
    return at.model.rule == "trace" and at.scenario.maneuvers.count > 1


def _learning(at: AtTime, t_end: float) -> float | None:
    """Until when a plan that ends at a time [s] learns; None if there is nothing of it."""
    if not np.isfinite(t_end):
        return None
    steps = round(t_end / at.model.step) - (at.model.window_steps if _holds(at) else 0)
    return steps * at.model.step if steps >= 2 else None


def _begins(
    roughly: Roughly, design: Floats, learned: list[Floats], time: float, *, horizon: bool
) -> Floats:
    """Plans to begin the polish for a time [s] from, shape (k, 4 m)."""
    at = roughly.exact
    count = design.size // VARIABLES_PER_MANEUVER - _holds(at)
    longest = at.scenario.maneuvers.max_duration
    found = [ending_at(design[: VARIABLES_PER_MANEUVER * count], time, longest)]
    if horizon and time <= _LATEST * at.model.step:
        stages = {max(round(share * count), 1) for share in _STAGES}
        for n in sorted(stages) if time <= SHORT * at.model.step else [count]:
            found.append(split(receding_horizon(roughly.at(time), n, time), count)[0])
    for plan in _nearest(at, learned, time, _NEAREST):
        found += _ending_then(at, plan, time)
    return np.array(found)


def _ending_then(at: AtTime, plan: Floats, time: float) -> list[Floats]:
    """A plan of another length that ends at a time [s]: cut or held, made longer, and slower."""
    limits, factor = at.scenario.maneuvers, time / _total(plan)
    return [
        ending_at(plan, time, limits.max_duration),
        stretched(plan, factor, limits.max_duration),
        slowed(plan, factor, limits.max_duration, limits.max_rate_deg_s),
    ]


def _nearest(at: AtTime, plans: list[Floats], time: float, most: int) -> list[Floats]:
    """Of plans that last, the few that last about as long as a time."""
    known = [plan for plan in plans if _total(plan) >= at.model.step]
    far = [abs(np.log(_total(plan) / time)) for plan in known]
    return [known[i] for i in np.argsort(far, kind="stable")[:most]]


def _ended(at: AtTime, learned: Floats) -> Floats:
    """What is learned, with rates held until the filter has converged, the best first."""
    if not _holds(at):
        return learned[None]
    held = held_rates(learned, at.scenario.maneuvers.max_rate_deg_s)
    order, trace = at.by_convergence(held)
    # of those that converge soonest each that knows more than all before
    least = np.minimum.accumulate(np.nan_to_num(trace[order], nan=np.inf))
    ended: Floats = held[order[np.diff(least, prepend=np.inf) < 0.0]]
    return ended


def _at_other_times(at: AtTime, shapes: list[Floats], times: Floats) -> Floats:
    """Polished plans as they are made longer, slower or shorter, to end at other times.

    Each from its own start, if that is free.
    """
    held = VARIABLES_PER_MANEUVER * _holds(at)
    tried = []
    for t_end in np.unique(times):
        time = _learning(at, t_end)
        if time is None:
            continue
        for shape in _nearest(at, shapes, time, _TRIED):
            maneuvers = VARIABLES_PER_MANEUVER * at.scenario.maneuvers.count
            body, tail = np.split(shape, [maneuvers - held])  # with its start
            tried += [np.append(each, tail) for each in _ending_then(at, body, time)]
    if not tried:
        return np.empty((0, shapes[0].size))
    distinct: Floats = np.unique(np.array(tried), axis=0)
    return distinct


def _total(design: Floats) -> float:
    """Of all maneuvers [s]; a start that follows them does not count."""
    return float(design[VARIABLES_PER_MANEUVER - 1 :: VARIABLES_PER_MANEUVER].sum())
