"""The one space in which all fronts of a comparison are measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray
from mgeo.algorithms.archive import truncate
from mgeo.algorithms.dominance import nondominated
from mgeo.plugins import protocol
from mgeo.runs.meters import scaled

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

BEYOND_NADIR = 1.1  # reference point where the union of fronts spans 0 to 1
REFERENCE_SIZE = 500  # points of the reference front

POINTS = ("ideal", "nadir", "reference_point")
Origin = Literal["problem", "union", "given", "objective"]


class NothingToCompareError(ValueError):
    """No run finished, or none found a feasible solution."""


@dataclass(frozen=True, eq=False)
class IndicatorSpace:
    """Objectives as the indicators see them, the same for every run.

    Attributes
    ----------
    ideal, nadir : (n_obj,) what is at 0 and at 1, in the problem's own objectives, or zeros and
        ones where the problem's `indicator_space` does the scaling.
    reference_point : (n_obj,) of the hypervolume, in this space.
    reference_front : (m, n_obj) for IGD+ and the additive epsilon, in this space.
    origin : where it comes from: the "problem", the "union" of the fronts, or "given"; or the
        single "objective", in its own units.
    transform : the problem's `indicator_space`, if it has one.
    """

    ideal: FloatArray
    nadir: FloatArray
    reference_point: FloatArray
    reference_front: FloatArray
    origin: Origin
    transform: Callable[[FloatArray], FloatArray] | None = None

    def __call__(self, F: FloatArray) -> FloatArray:
        """Objectives, shape (n, n_obj), in this space."""
        if not len(F):
            return np.empty((0, len(self.ideal)))
        F = F if self.transform is None else np.asarray(self.transform(F), dtype=float)
        return scaled(F, self.ideal, self.nadir)

    def describe(self) -> dict[str, Any]:
        """What a reader must know to compute the same indicators, as JSON's types."""
        if self.origin == "objective":
            return {"origin": self.origin}
        points = {key: getattr(self, key).tolist() for key in POINTS}
        return {
            "origin": self.origin,
            **points,
            "reference_front_points": len(self.reference_front),
        }


def indicator_space(
    problem: Problem,
    fronts: Iterable[FloatArray],
    *,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    reference_front: ArrayLike | None = None,
) -> IndicatorSpace:
    """The space of a comparison.

    With `bounds` (ideal, nadir), or else from the problem's `indicator_space`, either with the
    reference point (1, ..., 1); or else with the extent of the nondominated union of all fronts
    (and of the reference front, if given) between 0 and 1, and the reference point at
    `BEYOND_NADIR`.

    The reference front is the one given, or else the nondominated union, truncated to
    `REFERENCE_SIZE` evenly spaced points: otherwise an algorithm that crowds its points would also
    decide where the indicators look. The problem's ``pareto_front()`` is not asked for: pymoo
    draws some of them at random, and downloads others. Where it is good, pass it.

    A single objective is its own space.

    Parameters
    ----------
    fronts : (n, n_obj) objectives each, of all runs.
    bounds, reference_front : in the problem's own objectives.

    Raises
    ------
    NothingToCompareError
        If there is nothing to take the space from.
    ValueError
        If a shape does not fit, or bounds or a reference front are given for a single objective.
    """
    n_obj = problem.n_obj
    if n_obj == 1 and not (bounds is None and reference_front is None):
        raise ValueError("bounds, reference_front: expected none for a single objective")
    known = None if reference_front is None else _checked(reference_front, n_obj)
    union = np.concatenate([np.empty((0, n_obj)), *fronts])
    everything = union if known is None else np.concatenate([union, known])
    best = everything[nondominated(everything)]
    if not len(best):
        raise NothingToCompareError("no run found a feasible solution")
    if n_obj == 1:
        return OBJECTIVE_SPACE
    transform = protocol.indicator_space(problem)
    ideal, nadir = np.zeros(n_obj), np.ones(n_obj)
    reference_point = np.ones(n_obj)
    origin: Origin = "problem"
    if bounds is not None:
        origin, transform = "given", None
        ideal, nadir = (np.broadcast_to(np.asarray(b, dtype=float), (n_obj,)) for b in bounds)
        if not (np.isfinite([ideal, nadir]).all() and (ideal < nadir).all()):
            raise ValueError(f"bounds = {bounds}: expected finite values, ideal < nadir")
    elif transform is None:
        origin, ideal, nadir = "union", best.min(axis=0), best.max(axis=0)
        reference_point = np.full(n_obj, BEYOND_NADIR)
    bare = IndicatorSpace(ideal, nadir, reference_point, np.empty((0, n_obj)), origin, transform)
    points = bare(best if known is None else known)
    if known is None:
        points = points[truncate(points, max(REFERENCE_SIZE, 2 * n_obj))]
    return replace(bare, reference_front=points)


#: The space of a single objective: its values as they are.
OBJECTIVE_SPACE = IndicatorSpace(np.zeros(1), np.ones(1), np.ones(1), np.empty((0, 1)), "objective")


def _checked(front: ArrayLike, n_obj: int) -> FloatArray:
    points = np.asarray(front, dtype=float)
    if points.ndim != 2 or points.shape[1] != n_obj or not len(points):
        raise ValueError(f"reference_front of shape {points.shape}: expected (n, {n_obj}), n >= 1")
    if not np.isfinite(points).all():
        raise ValueError("reference_front: expected finite values")
    return points
