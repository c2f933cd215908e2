"""What plans promise and what they keep, told to people."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.objectives import OBJECTIVES
from mgeo_attitude.fields import InvalidValue

if TYPE_CHECKING:
    from mgeo_attitude.view.protocol import ManeuverProblem

#: What `AttitudeManeuverProblem.promises` asks for, in words.
MOST_FLIGHTS = "9 of 10 flights"
#: By what share of a promise it may be missed.
TOLERANCE = 0.1
#: Plans of a front that are looked at: with 200 flights of each a second or two.
MOST = 50


def spread(n: int) -> Ints:
    """Rows of n that are looked at, up to `MOST` at even distances."""
    rows: Ints = np.unique(np.linspace(0, n - 1, min(n, MOST)).round().astype(np.int64))
    return rows


def looked_at(rows: Ints, X: Floats) -> str:
    """How many of a front these are, in words."""
    return f"{len(rows)} plans" if len(rows) == len(X) else f"{len(rows)} plans looked at"


def kept(problem: ManeuverProblem, X: Floats) -> Floats:
    """Objectives that most flights of plans, shape (n, n_var), keep, shape (n, n_obj)."""
    table = problem.promises(X)
    found: Floats = table[[f"kept {label}" for label in problem.obj_names]].to_numpy(float)
    return found


class Times(NamedTuple):
    """t_end [s] of a plan over flights, infinite if too few converge; None if nobody knows.

    Attributes
    ----------
    kept
        By most of 200 flights; None where it is no objective, or the covariance was lost.
    promised
        By the plan's problem over its own flights; None, too, if these are none.
    """

    kept: float | None = None
    promised: float | None = None


#: Of a plan that nobody has flown.
UNKNOWN = Times()


def times(problem: ManeuverProblem, X: Floats) -> list[Times]:
    """The `Times` of each design, shape (n, n_var)."""
    if "t_end" not in problem.objectives:
        return [UNKNOWN] * len(X)
    table = problem.promises(X)
    longest = problem.model.longest

    def column(name: str) -> list[float | None]:
        found = table[f"{name} {OBJECTIVES['t_end'].label}"].tolist()
        return [None if t != t else math.inf if t >= longest else t for t in found]

    own = column("promised") if problem.scenario.flight else [None] * len(X)
    return [Times(*both) for both in zip(column("kept"), own, strict=True)]


def held_until(problem: ManeuverProblem, X: Floats, t_end: Floats) -> Floats:
    """Until when plans, shape (n, n_var), are flown before they end or slew back [s], shape (n,).

    One that promises a time over flights is flown until the later of what it promises and what most
    flights keep; until the end of the scenario, if too few converge. Any other is flown exactly,
    until `t_end`, shape (n,).
    """
    if not problem.scenario.flight:
        return t_end
    longest = problem.model.longest
    late = np.array(
        [[min(time or 0.0, longest) for time in found] for found in times(problem, X)], dtype=float
    )
    steps = np.ceil(late.max(axis=1) / problem.model.step - 1e-9)  # a mean may be on none
    held: Floats = np.maximum(t_end, steps * problem.model.step)
    return held


def ends(problem: ManeuverProblem, X: Floats, t_end: Floats) -> Floats:
    """When plans, shape (n, n_var), end that converge at `t_end`, shape (n,) [s], shape (n,).

    That is `held_until` or, with a slew back, when that ends, some 25 ms a plan: infinite where
    there is no way back within the scenario's duration. NaN where `t_end` is.
    """
    until = held_until(problem, X, t_end)
    if not problem.scenario.maneuvers.slew_back:
        return until
    from mgeo_attitude.maneuvers.trajectory import Trajectory  # imports scipy

    found = np.full(len(X), np.nan)
    for i in np.flatnonzero(np.isfinite(t_end)):
        trajectory = Trajectory(
            problem.scenario, problem.model, X[i], float(t_end[i]), float(until[i])
        )
        try:
            found[i] = trajectory.end
        except InvalidValue:
            found[i] = math.inf
    return found


def end_remarks(problem: ManeuverProblem, X: Floats) -> list[str]:
    """How many plans of a front, shape (n, n_var), slew back beyond the scenario's duration."""
    if not (len(X) and problem.scenario.maneuvers.slew_back):
        return []
    from mgeo_attitude.filter.evaluator import evaluate  # compiles

    rows, duration = spread(len(X)), problem.scenario.duration
    t_end = evaluate(problem.model, X[rows], problem.threads).t_end
    late = [end for end in ends(problem, X[rows], t_end).tolist() if duration < end < math.inf]
    if not late:
        return []
    return [
        f"duration = {duration:.6g} s limits the time to converge, it is no window: "
        f"{len(late)} of {looked_at(rows, X)} slew back later, until {max(late):.6g} s at most"
    ]


def remarks(problem: ManeuverProblem, X: Floats) -> list[str]:
    """How many plans of a front, shape (n, n_var), keep what they promise; none of no front."""
    if not len(X):
        return []
    rows = spread(len(X))
    table = problem.promises(X[rows])
    promised = table[[f"promised {label}" for label in problem.obj_names]].to_numpy(float)
    # false of NaN, too, where a covariance is lost
    in_time = kept(problem, X[rows]) - promised <= TOLERANCE * np.abs(promised)
    endless = [found.kept == math.inf for found in times(problem, X[rows])]
    keep = in_time.all(axis=1) & ~np.array(endless)
    label = problem.obj_names[0]
    ratio = table[f"kept / promised {label}"]
    return [
        f"{keep.sum()} of {looked_at(rows, X)} keep what they promise in {MOST_FLIGHTS}, to "
        f"{TOLERANCE:.0%}; {label} is then {ratio.median():.3g} times the promised in the median, "
        f"{ratio.max():.3g} at most"
    ]
