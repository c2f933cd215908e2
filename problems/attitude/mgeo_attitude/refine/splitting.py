"""Plans of a few maneuvers as plans of more, and plans without maneuvers that are of no use."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, decode
from mgeo_attitude.refine.at_time import PlanProblem, judged_by

#: A maneuver whose rate turns by more than this from a neighbor's is of use [deg].
_TURN = 20.0


def split(designs: ArrayLike, count: int) -> Floats:
    """The same plans in `count` maneuvers: the longest is halved as often as it takes.

    Parameters
    ----------
    designs : array_like, shape (n, 4 m)
        Of at most `count` maneuvers.

    Returns
    -------
    array, shape (n, 4 count)

    Raises
    ------
    ValueError
        For designs of more maneuvers, or those that `decode` refuses.

    Examples
    --------
    >>> from mgeo_attitude import split
    >>> split([[0.5, 0.0, 0.0, 100.0, 0.0, 0.5, 0.0, 40.0]], count=3)
    array([[ 0.5,  0. ,  0. , 50. ,  0.5,  0. ,  0. , 50. ,  0. ,  0.5,  0. ,
            40. ]])
    """
    _, durations = decode(designs)
    if durations.shape[1] > count:
        raise ValueError(
            f"designs of {durations.shape[1]} maneuvers: expected at most count = {count}"
        )
    table = np.atleast_2d(np.asarray(designs, dtype=float))
    maneuvers = table.reshape(len(table), -1, VARIABLES_PER_MANEUVER)
    rows = np.arange(len(table))
    while maneuvers.shape[1] < count:
        longest = maneuvers[:, :, 3].argmax(axis=1)
        order = np.arange(maneuvers.shape[1] + 1)
        maneuvers = maneuvers[rows[:, None], order - (order > longest[:, None])]
        maneuvers[rows, longest, 3] /= 2.0
        maneuvers[rows, longest + 1, 3] /= 2.0
    return maneuvers.reshape(len(table), -1)


def without_unneeded(problem: PlanProblem, designs: ArrayLike) -> Floats:
    """Plans with fewer commands and values that are as good, in place of those with more.

    A maneuver is left out where a neighbor takes its time and no objective is worse for it, if that
    turns by at most 20 deg more or less. Its place in the design stays, with no duration and a
    neighbor's rate.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
        By whose objectives and limits.
    designs : array_like, shape (n, n_var)

    Returns
    -------
    array, shape (n, n_var)

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude import AttitudeManeuverProblem, without_unneeded
    >>> problem = AttitudeManeuverProblem()
    >>> twice = np.array([[0.5, 0.3, -0.2, 400.0, 0.5, 0.3, -0.2, 500.0, 0.2, -0.4, 0.7, 600.0]])
    >>> without_unneeded(problem, twice)[0, 3::4]
    array([  0., 900., 600.])
    """
    table = np.atleast_2d(np.array(designs, dtype=float))
    decode(table)
    found, row_of = np.unique(table, axis=0, return_inverse=True)
    n, count = len(found), problem.scenario.maneuvers.count
    if not n or count < 2:
        return table
    judge = judged_by(problem)
    F, violation = judge(found)
    rows, longest = np.arange(n), problem.scenario.maneuvers.max_duration
    while len(rows):
        left_out, which = _each_left_out(found[rows], longest)
        if not len(which):
            break
        found_F, kept = judge(left_out)
        of = rows[which]
        good = (found_F <= F[of]).all(axis=1) & (kept <= violation[of])
        # of several the one that is best in the last objective
        order = np.lexsort((*found_F[good].T, of[good]))
        first, at = np.unique(of[good][order], return_index=True)
        chosen = np.flatnonzero(good)[order][at]
        found[first], F[first], violation[first] = left_out[chosen], found_F[chosen], kept[chosen]
        rows = first
    return found[row_of]


def _flown(durations: Floats) -> Bools:
    """Maneuvers that last, and the last one, whose rate is held in any case; shape (n, m)."""
    flown: Bools = durations > 0.0
    flown[:, -1] = True
    return flown


def _each_left_out(designs: Floats, longest: float) -> tuple[Floats, Ints]:
    """Designs without one of their flown maneuvers, whose time a neighbor takes; and of which.

    None in which a maneuver would be longer than the `longest`, or that turn otherwise by much.
    """
    maneuvers = designs.reshape(len(designs), -1, VARIABLES_PER_MANEUVER)
    row, place = np.nonzero(_flown(maneuvers[:, :, 3]))
    pairs = np.flatnonzero(row[1:] == row[:-1])
    together = maneuvers[row[pairs], place[pairs], 3] + maneuvers[row[pairs], place[pairs + 1], 3]
    pairs = np.repeat(pairs[together <= longest], 2)  # either of the two keeps its rate
    left, right = place[pairs], place[pairs + 1]
    keeps, gone = np.where(np.arange(len(pairs)) % 2, (right, left), (left, right))
    rates, lasts = maneuvers[row[pairs], :, :3], maneuvers[row[pairs], gone, 3]
    each = np.arange(len(pairs))
    turned = lasts * np.abs(rates[each, left] - rates[each, right]).max(axis=1)
    near = turned <= _TURN
    which, left, right, keeps = row[pairs][near], left[near], right[near], keeps[near]
    each, found = np.arange(len(which)), maneuvers[which]
    found[each, right, 3] += found[each, left, 3]
    found[each, left, 3] = 0.0
    places = np.arange(found.shape[1])
    changed = (places >= left[:, None]) & (places <= right[:, None])
    kept = found[each, keeps, :3][:, None]
    found[:, :, :3] = np.where(changed[:, :, None], kept, found[:, :, :3])
    return found.reshape(-1, designs.shape[1]), which
