"""Plans that are good from the first: stage by stage whichever rate teaches most until its end."""

from __future__ import annotations

import dataclasses

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, durations_of
from mgeo_attitude.refine.at_time import AtTime, Judge, PlanProblem, at_time
from mgeo_attitude.scenario.actuators import slew_limits

#: Rates about each axis, from the greatest backward to the greatest forward.
_LEVELS = 7
#: Share by which few samples are wrong of a trace.
_HARDLY = 0.02
#: Stages shorter than this many steps are not worth a maneuver.
_SHORTEST = 5


def rate_grid(greatest: float, n_levels: int = _LEVELS) -> Floats:
    """Rates [deg/s] on a grid about the three axes, shape (n_levels³, 3)."""
    levels = np.linspace(-greatest, greatest, n_levels)
    return np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)


def until_converged(
    at: AtTime, design: Floats, judge: Judge | None = None, few: AtTime | None = None
) -> Floats:
    """A design, shape (4 m,), with rates held after it, shape (k, 4 (m + 1)), from k = 1.

    Of the rates of `rate_grid` those by which it converges and knows more than by any by which it
    does so sooner, as it is judged, or else by the trace; first those by which it takes about the
    window of the rule, as what they teach then is as little as the rule allows. Those that a `few`
    samples say to teach far less are not judged.
    """
    last = rate_grid(at.scenario.maneuvers.max_rate_deg_s)
    before = np.broadcast_to(design, (len(last), len(design)))
    held = np.hstack([before, last, np.zeros((len(last), 1))])
    if few is not None:
        held = held[_nearly_soonest(few.converging(held)[0])]
    F, violation = (judge or at.converging)(held)
    rows = _soonest(F, violation)
    late = np.abs(F[rows, 0] - durations_of(design).sum() - at.model.step * at.model.window_steps)
    return held[rows[np.argsort(late, kind="stable")]]


def receding_horizon(at: AtTime, count: int, time: float) -> Floats:
    """A plan of `count` maneuvers of equally many steps until about a time [s], shape (4 count,).

    Each rate is the one, of a grid of seven about each axis, that leaves the least value at the
    end of its own stage without breaking a limit on the way.
    """
    plan: Floats = beam(at, count, time)[0]
    return plan


def beam(
    at: AtTime,
    count: int,
    time: float,
    n_levels: int = _LEVELS,
    width: int = 1,
    shorter: float = 1.0,
) -> Floats:
    """As many such plans as the `width`, the best first, shape (width, 4 count).

    From stage to stage those are kept that leave the least values then: a beam search, by which a
    rate may be chosen that teaches more later than others do at once. Each stage is `shorter` than
    the one before by this factor: what is known at the end depends on the last ones most.
    """
    limits, step = at.scenario.maneuvers, at.model.step
    rates = rate_grid(limits.max_rate_deg_s, n_levels)
    lengths = shorter ** np.arange(count)
    durations = np.minimum(time * lengths / lengths.sum(), limits.max_duration)
    n_steps = np.maximum((durations / step).astype(int), 1)
    plans = np.empty((1, 0))
    for own_steps, until in zip(n_steps, np.cumsum(n_steps), strict=True):
        own = np.column_stack([rates, np.full(len(rates), own_steps * step)])
        tried = np.hstack([np.repeat(plans, len(own), axis=0), np.tile(own, (len(plans), 1))])
        plans = at.best(tried, min(int(until), at.model.n_steps), width)
    return plans


def starts(problem: PlanProblem, n: int, random_state: np.random.Generator) -> Floats:
    """Designs to begin a search with, shape (n, n_var), for as many times.

    Times are spread evenly in their logarithm, each drawn within its share. By the rule "trace" of
    convergence a plan learns until a window before its time, and then holds a rate at which it
    learns little more; by any other it learns to its end.

    Where coils turn the satellite, they are those of rates that it has at once: what coils fly
    teaches about as much, and takes far longer to tell.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    n : int
        From 0.
    random_state : numpy Generator
        Draws the times.

    Raises
    ------
    ValueError
        For a number below 0.
    """
    if n < 0:
        raise ValueError(f"n = {n}: expected a number of designs >= 0")
    at = _freely(at_time(problem))
    scenario, model = at.scenario, at.model
    count, window = scenario.maneuvers.count, model.window_steps * model.step
    holds = model.rule == "trace" and count > 1
    learning = count - 1 if holds else count
    first = min(_SHORTEST * learning * model.step, 0.5 * model.longest)
    first = max(first, 0.02 * model.longest)
    last = min(
        model.longest - (window if holds else 0.0), learning * scenario.maneuvers.max_duration
    )
    shares = (np.arange(n) + random_state.random(n)) / max(n, 1)
    times = first * (max(last, first) / first) ** shares
    found = np.empty((n, VARIABLES_PER_MANEUVER * count))
    for row, time in enumerate(times):
        plan = receding_horizon(at, learning, float(time))
        if holds:
            plan = until_converged(at, plan)[0]
        found[row] = plan
    return found


def _freely(at: AtTime) -> AtTime:
    """The same, but where coils turn the satellite it has rates at once."""
    if not at.scenario.turned_by_coils:
        return at
    scenario = dataclasses.replace(at.scenario, coils=None)
    limits = slew_limits(scenario.maneuvers, scenario.wheels, at.model.initial_rate)
    model = dataclasses.replace(at.model, slew_limits=limits)
    return dataclasses.replace(at, scenario=scenario, model=model)


def _soonest(F: Floats, violation: Floats) -> Ints:
    """Rows that break limits least, each that knows more than all that converge sooner; or one.

    F are times and what is known then, shape (n, 2).
    """
    order = np.lexsort((F[:, 1], F[:, 0], violation))
    least = np.minimum.accumulate(np.nan_to_num(F[order, 1], nan=np.inf))
    rows: Ints = order[np.diff(least, prepend=np.inf) < 0.0]
    return rows if len(rows) else order[:1]


def _nearly_soonest(F: Floats) -> Ints:
    """Rows that know nearly as much as all that converge sooner, F as in `_soonest`."""
    order = np.lexsort((F[:, 1], F[:, 0]))
    known = np.nan_to_num(F[order, 1], nan=np.inf)
    rows: Ints = order[known <= (1.0 + _HARDLY) * np.minimum.accumulate(known)]
    return np.sort(rows)
