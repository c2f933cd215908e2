"""Plans that are good from the first: stage by stage whichever rate teaches most until its end."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.at_time import AtTime
from mgeo_attitude.refine.held import rate_grid, until_converged
from mgeo_attitude.refine.judging import PlanProblem, at_time

#: Stages shorter than this many steps are not worth a maneuver.
_SHORTEST = 5


def receding_horizon(at: AtTime, count: int, time: float) -> Floats:
    """A plan of `count` maneuvers of equally many steps until about a time [s], shape (4 count,).

    Each rate is the one, of a grid of seven about each axis, that leaves the least value at the
    end of its own stage without breaking a limit on the way.
    """
    plan: Floats = beam(at, count, time)[0]
    return plan


def beam(at: AtTime, count: int, time: float, n_levels: int = 7, width: int = 1) -> Floats:
    """As many such plans as the `width`, the best first, shape (width, 4 count).

    From stage to stage those are kept that leave the least values then: a beam search, by which a
    rate may be chosen that teaches more later than others do at once.
    """
    limits, step = at.scenario.maneuvers, at.model.step
    rates = rate_grid(limits.max_rate_deg_s, n_levels)
    n_steps = max(int(min(time / count, limits.max_duration) / step), 1)
    own = np.column_stack([rates, np.full(len(rates), n_steps * step)])
    plans = np.empty((1, 0))
    for stage in range(1, count + 1):
        tried = np.hstack([np.repeat(plans, len(own), axis=0), np.tile(own, (len(plans), 1))])
        plans = at.best(tried, min(stage * n_steps, at.model.n_steps), width)
    return plans


def starts(problem: PlanProblem, n: int, random_state: np.random.Generator) -> Floats:
    """Designs to begin a search with, shape (n, n_var), for as many times.

    Times are spread evenly in their logarithm, each drawn within its share. By the rule "trace" of
    convergence a plan learns until a window before its time, and then holds a rate at which it
    learns little more; by any other it learns to its end. A free start is drawn, too.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    n : int
        From 0.
    random_state : numpy Generator
        Draws the times, and starts.

    Raises
    ------
    ValueError
        For a number below 0.
    """
    if n < 0:
        raise ValueError(f"n = {n}: expected a number of designs >= 0")
    at = at_time(problem)
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
    begins = np.empty((n, 0))
    if problem.start_times is not None:
        begins = random_state.choice(problem.start_times.times, (n, 1))
    found = np.empty((n, VARIABLES_PER_MANEUVER * count))
    for row, time in enumerate(times):
        at = at_time(problem, start=begins[row])
        plan = receding_horizon(at, learning, float(time))
        if holds:
            plan = until_converged(at, plan)[0]
        found[row] = plan
    return np.hstack([found, begins])
