"""Whether a problem still gives the values that a run has of it."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from mgeo.evaluation.failures import attempt
from mgeo.evaluation.individuals import values_of

if TYPE_CHECKING:
    from pymoo.core.population import Population
    from pymoo.core.problem import Problem

_POINTS = 3
_ROUNDING = 1e-9  # of a column's largest value: other versions and other batches round differently


def changed_value(problem: Problem, known: Population, options: Mapping[str, Any]) -> str:
    """The first value that is another one now, in words; empty if there is none.

    A few points are evaluated again by the problem itself: no evaluator counts them, and the
    problem's callback does not see them.

    Parameters
    ----------
    problem : a pymoo problem that gives the same values for the same point.
    known : evaluated individuals; the first, the last and the one in the middle are looked at.
    options : further keywords for `Problem.evaluate`.
    """
    rows = np.unique(np.linspace(0, len(known) - 1, min(_POINTS, len(known))).round().astype(int))
    if not len(rows):
        return ""
    if problem.callback is not None:
        problem = copy.copy(problem)
        problem.callback = None
    points = known[rows]
    values, failures = attempt(problem, values_of(points, "X"), ["F", "G", "H"], options)
    for name in ("F", "G", "H"):
        kept = values_of(known, name).astype(float).reshape(len(known), -1)
        expected, found = kept[rows], values[name].reshape(len(rows), -1)
        tolerance = _ROUNDING * np.abs(kept).max(axis=0, initial=0.0)
        with np.errstate(invalid="ignore"):  # infinite constraints
            same = (found == expected) | (np.abs(found - expected) <= tolerance)
        for row, column in np.argwhere(~same):
            why = f" ({failures[row].cause})" if row in failures else ""
            x = points[row].X
            x = x.tolist() if isinstance(x, np.ndarray) else x
            return (
                f"at x = {x!r:.200} {name}[{column}] = {found[row, column]}{why}, "
                f"expected {expected[row, column]}"
            )
    return ""
