"""Sequential quadratic programming on what a plan is worth at a time."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.at_time import AtTime
from mgeo_attitude.refine.minimizers import minimize_bounded, minimize_constrained

#: Change of a rate, of the greatest, by which slopes are taken; of a duration, of a step.
_SMALL, _PART = 1e-5, 1e-2
#: By how much of their bounds limits are kept, so that rounding does not break them.
_MARGIN = 1e-6
#: A change of the logarithm of the value that is not worth another iteration.
_ENOUGH = 3e-5
#: After how many points which share of several descents is left.
_LEFT = {3: 1 / 3, 8: 1 / 2, 20: 1 / 2}
#: A share of the time that is none.
_NOTHING = 1e-12
#: What stands for an infinite value.
_WORST = 1e3


@dataclass
class Descent:
    """Plans' values and slopes at times [s], as functions of variables between -1 and 1.

    Variables are the rates over the greatest, and the shares that durations have of the time; they
    need not sum up to one.

    Attributes
    ----------
    times : float or array, shape (n,)
        Of each plan.
    """

    at: AtTime
    times: float | Floats
    count: int

    @property
    def steps(self) -> Ints:
        """Of the model, which may be a coarse one, shape () or (n,)."""
        steps = np.rint(np.asarray(self.times) / self.at.model.step).astype(np.int64)
        return np.clip(steps, 1, self.at.model.n_steps)

    @property
    def bounds(self) -> Floats:
        """Least and greatest, shape (4 m, 2)."""
        return np.array([(-1.0, 1.0)] * (3 * self.count) + [(0.0, 1.0)] * self.count)

    def of(self, rows: Ints | list[int]) -> Descent:
        """Some of the plans."""
        return Descent(self.at, np.asarray(self.times)[rows], self.count)

    def variables(self, designs: Floats) -> Floats:
        """Of a design, shape (4 m,), or of one for each time, shape (n, 4 m)."""
        maneuvers = designs.reshape(*designs.shape[:-1], -1, VARIABLES_PER_MANEUVER)
        rates = maneuvers[..., :3] / self.at.scenario.maneuvers.max_rate_deg_s
        shares = maneuvers[..., 3] / np.asarray(self.times)[..., None]
        found = np.concatenate([rates.reshape(*shares.shape[:-1], -1), shares], axis=-1)
        within: Floats = np.clip(found, *self.bounds.T)
        return within

    def designs(self, variables: Floats) -> Floats:
        """Of rows of variables, shape (n, 4 m) or (4 m,), which fill the times where they can."""
        z = np.clip(np.atleast_2d(variables), *self.bounds.T)
        limits, n = self.at.scenario.maneuvers, len(z)
        rates = limits.max_rate_deg_s * z[:, : 3 * self.count].reshape(n, -1, 3)
        shares = z[:, 3 * self.count :] + _NOTHING
        times = np.broadcast_to(self.times, n)[:, None]
        durations = times * shares / shares.sum(axis=1, keepdims=True)
        # what would be longer than a maneuver may be goes to those with room, by their room
        room = np.maximum(limits.max_duration - durations, 0.0)
        over = np.maximum(durations - limits.max_duration, 0.0).sum(axis=1, keepdims=True)
        given = np.minimum(over / np.maximum(room.sum(axis=1, keepdims=True), _NOTHING), 1.0)
        durations = np.minimum(durations, limits.max_duration) + given * room
        return np.concatenate([rates, durations[:, :, None]], axis=2).reshape(n, -1)

    def taken(self, variables: Floats) -> tuple[Floats, Floats]:
        """Values and margins, shape (n, 1 + k), and their slopes, shape (n, 1 + k, 4 m).

        Of rows of variables, by one batch of the kernel, which costs less than each.
        """
        model, (n, size) = self.at.model, variables.shape
        smooth = model.slew_limits is None  # or else ramps begin on steps
        times = np.broadcast_to(self.times, n)
        steps = np.full((n, size), _SMALL)
        steps[:, 3 * self.count :] = (_PART if smooth else 1.0) * model.step / times[:, None]
        steps = np.where(variables + steps > self.bounds[:, 1], -steps, steps)
        tried = np.repeat(variables[:, None], 1 + size, axis=1)
        tried[:, 1:] += steps[:, :, None] * np.eye(size)
        each = Descent(self.at, np.repeat(times, 1 + size), self.count)
        designs = each.designs(tried.reshape(-1, size))
        value, excess = self.at.values(designs, each.steps, required=True, within_steps=True)
        found = np.column_stack([np.minimum(value, _WORST), -_MARGIN - np.minimum(excess, _WORST)])
        found = found.reshape(n, 1 + size, -1)
        differences = found[:, 1:] - found[:, :1]
        return found[:, 0], np.moveaxis(differences / steps[:, :, None], 1, 2)


def descend(at: AtTime, designs: Floats, times: float | Floats, iterations: int) -> Floats:
    """Designs that are worth more at their times [s], within all limits, as far as can be found.

    Each by itself, side by side. Slopes are differences. Steps are those of `minimize_constrained`
    where there are limits, or else of `minimize_bounded`.

    Parameters
    ----------
    designs : array, shape (n, 4 m)
        Whose maneuvers are over by then.
    times : float or array, shape (n,)
    """
    count = designs.shape[1] // VARIABLES_PER_MANEUVER
    problem = Descent(at, np.broadcast_to(times, len(designs)), count)
    begins = problem.variables(designs)
    with warnings.catch_warnings():
        # SLSQP's line search may leave the bounds by rounding, and says so
        warnings.filterwarnings("ignore", "Values in x were outside bounds", RuntimeWarning)
        ends = _side_by_side(problem, begins, iterations)
    sound: Bools = np.asarray(np.isfinite(ends).all(axis=1))[:, None]
    return np.where(sound, problem.designs(np.where(sound, ends, begins)), designs)


def descend_from_best(
    at: AtTime, designs: Floats, times: Floats, which: Ints, iterations: int
) -> Floats:
    """The best that `descend` finds from several designs for each of some times, without limits.

    All side by side. After a few points the better third of each time's goes on, then the better
    half of these, and again.

    Parameters
    ----------
    designs : array, shape (n, 4 m)
    times : array, shape (k,)
    which : array of int, shape (n,)
        The time of each design, ascending, all of them.

    Returns
    -------
    array, shape (k, 4 m)
    """
    problem = Descent(at, times[which], designs.shape[1] // VARIABLES_PER_MANEUVER)
    groups = [np.flatnonzero(which == k).tolist() for k in range(len(times))]
    ends = _side_by_side(problem, problem.variables(designs), iterations, groups)
    return problem.designs(ends)[[group[0] for group in groups]]


def _side_by_side(
    problem: Descent, begins: Floats, iterations: int, groups: Sequence[list[int]] = ()
) -> Floats:
    """Where each ends; of groups the best that are left, the very best first."""
    ends, least = begins.copy(), np.full(len(begins), np.inf)
    limited = bool(problem.at.limits or problem.at.requirements)
    method: Any = minimize_constrained if limited else minimize_bounded
    ways = [method(z, problem.bounds, iterations, _ENOUGH) for z in begins]
    asked = {row: next(way) for row, way in enumerate(ways)}
    points = 0
    while asked:
        rows = list(asked)
        values, slopes = problem.of(rows).taken(np.array(list(asked.values())))
        for row, value, slope in zip(rows, values, slopes, strict=True):
            least[row] = min(least[row], value[0])
            try:
                answer = (value, slope) if limited else (float(value[0]), slope[0])
                asked[row] = ways[row].send(answer)
            except StopIteration as end:
                ends[row] = end.value
                del asked[row]
        points += 1
        if points in _LEFT:
            for group in groups:
                group.sort(key=lambda row: least[row])
                left = max(int(_LEFT[points] * len(group)), 1)
                for row in group[left:]:
                    asked.pop(row, None)
                del group[left:]
    for group in groups:
        group.sort(key=lambda row: least[row])
    return ends
