"""Quality of fronts as numbers, and the one space in which all of a comparison are measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any, Literal

import moocore
import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem
from pymoo.indicators.hv import HV

from mgeo._typing import FloatArray
from mgeo.algorithms.archive import truncate
from mgeo.algorithms.base import is_dynamic
from mgeo.evaluation.dominance import nondominated
from mgeo.plugins import protocol
from mgeo.plugins.protocol import ask
from mgeo.plugins.view import View, view_of
from mgeo.runs.hypervolume import MAX_OBJECTIVES, scaled
from mgeo.studies.record import StudyRun
from mgeo.validation.arguments import validate_list, validate_number

BEYOND_NADIR = 1.1  # reference point where the union of fronts spans 0 to 1
REFERENCE_SIZE = 500  # points of the reference front
_PARTS = 3  # of the front, by default

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
    parts : where the first objective parts the front, ascending, in the problem's own unit; and in
        this space, `cuts`. None of a single objective.
    """

    ideal: FloatArray
    nadir: FloatArray
    reference_point: FloatArray
    reference_front: FloatArray
    origin: Origin
    transform: Callable[[FloatArray], FloatArray] | None = None
    parts: tuple[float, ...] = ()
    cuts: tuple[float, ...] = ()

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
            "parts": list(self.parts),
            "cuts": list(self.cuts),
        }


def indicator_space(
    problem: Problem,
    fronts: Iterable[FloatArray],
    *,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    reference_front: ArrayLike | None = None,
    parts: Sequence[float] | None = None,
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
    parts : values of the first objective, ascending, at which the front is parted; default: those
        that leave a third of the reference front's points in each part.

    Raises
    ------
    NothingToCompareError
        If there is nothing to take the space from.
    ValueError
        If a shape does not fit, or bounds, a reference front or parts are given for a single
        objective.
    """
    ends, known, given = check_space(problem, bounds, reference_front, parts)
    n_obj = problem.n_obj
    union = np.concatenate([np.empty((0, n_obj)), *fronts])
    everything = union if known is None else np.concatenate([union, known])
    best = everything[nondominated(everything)]
    if not len(best):
        raise NothingToCompareError("no run found a feasible solution")
    if n_obj == 1:
        return OBJECTIVE_SPACE
    transform = protocol.indicator_space(problem)
    origin: Origin = "problem"
    ideal, nadir, reference_point = np.zeros(n_obj), np.ones(n_obj), np.ones(n_obj)
    if ends is not None:
        origin, transform, (ideal, nadir) = "given", None, ends
    elif transform is None:
        origin, ideal, nadir = "union", best.min(axis=0), best.max(axis=0)
        reference_point = np.full(n_obj, BEYOND_NADIR)
    bare = IndicatorSpace(ideal, nadir, reference_point, np.empty((0, n_obj)), origin, transform)
    whole = best if known is None else known
    points = bare(whole)
    if known is None:
        rows = truncate(points, max(REFERENCE_SIZE, 2 * n_obj))
        whole, points = whole[rows], points[rows]
    own, cuts = _parted(bare, whole, points, given)
    return replace(bare, reference_front=points, parts=own, cuts=cuts)


def check_space(
    problem: Problem,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    reference_front: ArrayLike | None = None,
    parts: Sequence[float] | None = None,
) -> tuple[tuple[FloatArray, FloatArray] | None, FloatArray | None, list[float] | None]:
    """Return the arguments of `indicator_space` as numbers, before any run is made.

    Raises
    ------
    ValueError
        As `indicator_space`, or if the values of the problem change with time.
    """
    n_obj, ends, front, given = problem.n_obj, None, None, None
    if is_dynamic(problem):
        raise ValueError(
            f"{type(problem).__name__} is a dynamic problem: its values change with time, so that "
            "no indicator can compare those of different generations; expected a problem whose "
            "values stay, such as one problem for each time"
        )
    if n_obj == 1 and not (bounds is None and reference_front is None and parts is None):
        raise ValueError("bounds, reference_front, parts: expected none for a single objective")
    if bounds is not None:
        ideal, nadir = (np.broadcast_to(np.asarray(b, dtype=float), (n_obj,)) for b in bounds)
        if not (np.isfinite([ideal, nadir]).all() and (ideal < nadir).all()):
            raise ValueError(f"bounds = {bounds}: expected finite values, ideal < nadir")
        ends = ideal, nadir
    if reference_front is not None:
        front = np.asarray(reference_front, dtype=float)
        if front.ndim != 2 or front.shape[1] != n_obj or not len(front):
            raise ValueError(
                f"reference_front of shape {front.shape}: expected (n, {n_obj}), n >= 1"
            )
        if not np.isfinite(front).all():
            raise ValueError("reference_front: expected finite values")
    if parts is not None:
        given = validate_list("parts", parts, validate_number)
        if not given or any(low >= high for low, high in pairwise(given)):
            raise ValueError(f"parts = {given}: expected one or more ascending values")
    return ends, front, given


def _parted(
    space: IndicatorSpace, own: FloatArray, points: FloatArray, given: list[float] | None
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Where to part the front: in the first objective's own unit, and in the space.

    A value that is given is mapped beside the reference front's other objectives: a space treats
    each objective by itself.
    """
    if given is None:
        order = np.argsort(points[:, 0], kind="stable")
        rows = order[[len(order) * k // _PARTS for k in range(1, _PARTS)]]
        cuts = dict(zip(points[rows, 0], own[rows, 0], strict=True))  # each once, ascending
        return tuple(map(float, cuts.values())), tuple(map(float, cuts))
    beside = np.repeat(own[:1], len(given), axis=0)
    beside[:, 0] = given
    return tuple(given), tuple(space(beside)[:, 0].tolist())


#: The space of a single objective: its values as they are.
OBJECTIVE_SPACE = IndicatorSpace(np.zeros(1), np.ones(1), np.ones(1), np.empty((0, 1)), "objective")


#: Value of a front, shape (n, n_obj), n >= 1, in a space.
Measure = Callable[[FloatArray, IndicatorSpace], float]


@dataclass(frozen=True)
class Indicator:
    """A number for a front in an `IndicatorSpace`; `larger` says which way is better."""

    name: str
    title: str
    larger: bool
    measure: Measure

    def value(self, points: FloatArray, space: IndicatorSpace) -> float:
        """Return the value of a front, shape (n, n_obj), in the space; the worst if it is empty."""
        if not len(points):
            return 0.0 if self.larger else np.inf
        return float(self.measure(points, space))

    @property
    def direction(self) -> str:
        """Which way is better, in words."""
        return "higher is better" if self.larger else "lower is better"

    def better(self, values: Any) -> Any:
        """Values turned so that larger is better."""
        return values if self.larger else -values


def _to_reference_front(measure: Callable[..., float]) -> Measure:
    return lambda points, space: measure(points, ref=space.reference_front)


def _slab(
    points: FloatArray, space: IndicatorSpace, low: float = -np.inf, high: float = np.inf
) -> float:
    """Return the hypervolume between two values of the first objective, by default the whole."""
    end = space.reference_point.copy()
    end[0] = min(high, end[0])
    within = points[points[:, 0] < end[0]].copy()
    if low >= end[0] or not len(within):
        return 0.0
    within[:, 0] = np.maximum(within[:, 0], low)
    return float(HV(ref_point=end)(within))


#: Of a single objective: the least value found.
BEST_VALUE = Indicator("best_value", "best value", False, lambda points, space: points.min())

#: Of several objectives.
#: Hypervolume: how much of the space up to the reference point is dominated; an empty front has 0.
#: IGD+ (Ishibuchi et al. 2015): mean over the reference front of how far the nearest point of the
#: front is from dominating it. Additive epsilon (Zitzler et al. 2003): by how much the front must
#: be moved to weakly dominate the whole reference front. An empty front is infinitely far.
INDICATORS = (
    Indicator("hypervolume", "hypervolume", True, _slab),
    Indicator("igd_plus", "IGD+", False, _to_reference_front(moocore.igd_plus)),
    Indicator("epsilon", "additive epsilon", False, _to_reference_front(moocore.epsilon_additive)),
)


def parts_of(space: IndicatorSpace, objective: str) -> list[Indicator]:
    """The hypervolume by parts of the front along the first objective, which add up to the whole.

    That of a part is the dominated volume between its ends; that of the last ends at the reference
    point.
    """
    edges = [-np.inf, *space.cuts, float("inf")]
    names = [f"{value:.6g}" for value in space.parts]
    titles = [f"to {low}" for low in names[:1]]
    titles += [f"from {low} to {high}" for low, high in pairwise(names)]
    titles += [f"from {high}" for high in names[-1:]]
    return [
        Indicator(
            f"hypervolume_{i + 1}",
            f"hypervolume, {objective} {title}",
            True,
            partial(_slab, low=edges[i], high=edges[i + 1]),
        )
        for i, title in enumerate(titles)
    ]


def applicable(n_obj: int) -> list[Indicator]:
    """The indicators for so many objectives: the exact hypervolume up to `MAX_OBJECTIVES`."""
    if n_obj == 1:
        return [BEST_VALUE]
    return [i for i in INDICATORS if n_obj <= MAX_OBJECTIVES or i.name != "hypervolume"]


def trace(
    problem: Problem, record: StudyRun, grid: Sequence[int], space: IndicatorSpace
) -> list[dict[str, Any]]:
    """One row per number of evaluations in `grid`.

    Its columns are ``evaluations``, the indicators, the hypervolume by parts, ``points`` of the
    front (of a single objective 1, or 0 where nothing feasible was found), and what
    ``front_summary(F)`` of the problem's view makes of the front in the problem's own objectives.
    """
    indicators = applicable(problem.n_obj)
    if problem.n_obj <= MAX_OBJECTIVES:
        indicators += parts_of(space, "")
    rows, view = [], view_of(problem)
    for evaluations, F in zip(grid, record.fronts(grid), strict=True):
        points = space(F)
        values = {i.name: i.value(points, space) for i in indicators}
        rows.append(
            {"evaluations": int(evaluations), **values, "points": len(F)}
            | {str(name): value for name, value in ask(view, View.front_summary, F).items()}
        )
    return rows
