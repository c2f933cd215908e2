"""Division of plans into more maneuvers, and removal of maneuvers without effect."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, decode_designs
from mgeo_attitude.refine.evaluators import PlanProblem, build_design_evaluator

#: Largest change of the rotation angle by the removal of a maneuver [deg].
_MAX_ROTATION_CHANGE_DEG = 20.0


def split_maneuvers(designs: ArrayLike, n_maneuvers: int) -> Floats:
    """Split maneuvers until each plan has `n_maneuvers`, without changing the motion.

    The longest maneuver of each plan is halved repeatedly.

    Parameters
    ----------
    designs : array_like, shape (n, 4 m)
        Plans with at most `n_maneuvers` maneuvers.
    n_maneuvers : int
        Number of maneuvers of the result.

    Returns
    -------
    array, shape (n, 4 n_maneuvers)

    Raises
    ------
    ValueError
        If the designs have more than `n_maneuvers` maneuvers or are invalid; see `decode_designs`.

    Examples
    --------
    >>> from mgeo_attitude import split_maneuvers
    >>> split_maneuvers([[0.5, 0.0, 0.0, 100.0, 0.0, 0.5, 0.0, 40.0]], n_maneuvers=3)
    array([[ 0.5,  0. ,  0. , 50. ,  0.5,  0. ,  0. , 50. ,  0. ,  0.5,  0. ,
            40. ]])
    """
    _, durations = decode_designs(designs)
    if durations.shape[1] > n_maneuvers:
        raise ValueError(
            f"designs of {durations.shape[1]} maneuvers: expected at most n_maneuvers = "
            f"{n_maneuvers}"
        )
    table = np.atleast_2d(np.asarray(designs, dtype=float))
    maneuvers = table.reshape(len(table), -1, VARIABLES_PER_MANEUVER)
    rows = np.arange(len(table))
    while maneuvers.shape[1] < n_maneuvers:
        longest = maneuvers[:, :, 3].argmax(axis=1)
        order = np.arange(maneuvers.shape[1] + 1)
        maneuvers = maneuvers[rows[:, None], order - (order > longest[:, None])]
        maneuvers[rows, longest, 3] /= 2.0
        maneuvers[rows, longest + 1, 3] /= 2.0
    return maneuvers.reshape(len(table), -1)


def remove_ineffective_maneuvers(problem: PlanProblem, designs: ArrayLike) -> Floats:
    """Remove maneuvers that can be omitted without worsening objectives or constraints.

    A neighboring maneuver then extends over the time of the removed one. The rotation may change by
    at most 20 deg. The removed maneuver stays in the design with zero duration and the rate of a
    neighbor.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
        Problem whose objectives and constraints are evaluated.
    designs : array_like, shape (n, n_var)

    Returns
    -------
    array, shape (n, n_var)

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude import AttitudeManeuverProblem, remove_ineffective_maneuvers
    >>> problem = AttitudeManeuverProblem()
    >>> twice = np.array([[0.5, 0.3, -0.2, 400.0, 0.5, 0.3, -0.2, 500.0, 0.2, -0.4, 0.7, 600.0]])
    >>> remove_ineffective_maneuvers(problem, twice)[0, 3::4]
    array([  0., 900., 600.])
    """
    table = np.atleast_2d(np.array(designs, dtype=float))
    decode_designs(table)
    plans, row_of = np.unique(table, axis=0, return_inverse=True)
    n, count = len(plans), problem.scenario.maneuvers.count
    if not n or count < 2:
        return table
    evaluate_designs = build_design_evaluator(problem)
    F, violation = evaluate_designs(plans)
    rows, longest = np.arange(n), problem.scenario.maneuvers.max_duration
    while len(rows):
        shorter_plans, originals_of = _remove_single_maneuvers(plans[rows], longest)
        if not len(originals_of):
            break
        new_F, new_violation = evaluate_designs(shorter_plans)
        originals = rows[originals_of]
        is_accepted = (new_F <= F[originals]).all(axis=1) & (new_violation <= violation[originals])
        # Of several acceptable removals, the best one in the last objective is taken.
        order = np.lexsort((*new_F[is_accepted].T, originals[is_accepted]))
        first, best = np.unique(originals[is_accepted][order], return_index=True)
        chosen = np.flatnonzero(is_accepted)[order][best]
        plans[first], F[first], violation[first] = (
            shorter_plans[chosen],
            new_F[chosen],
            new_violation[chosen],
        )
        rows = first
    return plans[row_of]


def _has_effect(durations: Floats) -> Bools:
    """Return a mask of the maneuvers that have an effect.

    These are the maneuvers of nonzero duration and the last maneuver of each design.
    """
    result: Bools = durations > 0.0
    result[:, -1] = True
    return result


def _remove_single_maneuvers(designs: Floats, max_duration: float) -> tuple[Floats, Ints]:
    """Remove one maneuver at a time from each design.

    Return the shortened copies, and the row index of the original design of each copy. Copies in
    which a maneuver would exceed `max_duration` [s] or the rotation would change too much are left
    out.
    """
    maneuvers = designs.reshape(len(designs), -1, VARIABLES_PER_MANEUVER)
    row, position = np.nonzero(_has_effect(maneuvers[:, :, 3]))
    pairs = np.flatnonzero(row[1:] == row[:-1])
    together = (
        maneuvers[row[pairs], position[pairs], 3] + maneuvers[row[pairs], position[pairs + 1], 3]
    )
    pairs = np.repeat(pairs[together <= max_duration], 2)  # Either rate of a pair may remain.
    left, right = position[pairs], position[pairs + 1]
    remaining, removed = np.where(np.arange(len(pairs)) % 2, (right, left), (left, right))
    rates, lasts = maneuvers[row[pairs], :, :3], maneuvers[row[pairs], removed, 3]
    each = np.arange(len(pairs))
    rotation = lasts * np.abs(rates[each, left] - rates[each, right]).max(axis=1)
    near = rotation <= _MAX_ROTATION_CHANGE_DEG
    which, left, right, remaining = row[pairs][near], left[near], right[near], remaining[near]
    each, result = np.arange(len(which)), maneuvers[which]
    result[each, right, 3] += result[each, left, 3]
    result[each, left, 3] = 0.0
    places = np.arange(result.shape[1])
    changed = (places >= left[:, None]) & (places <= right[:, None])
    new_rate = result[each, remaining, :3][:, None]
    result[:, :, :3] = np.where(changed[:, :, None], new_rate, result[:, :, :3])
    return result.reshape(-1, designs.shape[1]), which
