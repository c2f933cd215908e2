"""What plans promise and what they keep, told to people."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from mgeo_attitude._typing import Floats, Ints

if TYPE_CHECKING:
    from mgeo_attitude.protocol import ManeuverProblem

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


def kept(problem: ManeuverProblem, X: Floats) -> Floats:
    """Objectives that most flights of plans, shape (n, n_var), keep, shape (n, n_obj)."""
    table = problem.promises(X)
    found: Floats = table[[f"kept {label}" for label in problem.obj_names]].to_numpy(float)
    return found


def time_kept(problem: ManeuverProblem, X: Floats) -> list[float | None]:
    """t_end [s] that most flights of each plan keep, infinite if too few converge.

    None where it is no objective, or the covariance was lost.
    """
    if "t_end" not in problem.objectives:
        return [None] * len(X)
    column = kept(problem, X)[:, problem.objectives.index("t_end")].tolist()
    longest = problem.model.n_steps * problem.model.step
    return [None if t != t else math.inf if t >= longest else t for t in column]


def remarks(problem: ManeuverProblem, X: Floats) -> list[str]:
    """How many plans of a front, shape (n, n_var), keep what they promise; none of no front."""
    if not len(X):
        return []
    rows = spread(len(X))
    table = problem.promises(X[rows])
    promised = table[[f"promised {label}" for label in problem.obj_names]].to_numpy(float)
    missed = kept(problem, X[rows]) - promised > TOLERANCE * np.abs(promised)
    label = problem.obj_names[0]
    ratio = table[f"kept / promised {label}"]
    of = f"{len(rows)} plans" if len(rows) == len(X) else f"{len(rows)} plans looked at"
    return [
        f"{(~missed.any(axis=1)).sum()} of {of} keep what they promise in {MOST_FLIGHTS}, to "
        f"{TOLERANCE:.0%}; {label} is then {ratio.median():.3g} times the promised in the median, "
        f"{ratio.max():.3g} at most"
    ]
