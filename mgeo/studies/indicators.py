"""Quality indicators of fronts, and the scaled objective space in which they are computed."""

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
from mgeo.evaluation.dominance import find_nondominated
from mgeo.plugins import protocol
from mgeo.plugins.protocol import call_optional
from mgeo.plugins.view import View, build_view
from mgeo.runs.hypervolume import MAX_OBJECTIVES, scale_objectives
from mgeo.studies.study_run import StudyRun
from mgeo.validation.arguments import validate_list, validate_number

#: Coordinates of the reference point if the space is scaled to the union of all fronts.
REFERENCE_COORDINATE = 1.1
#: Maximum number of points of the reference front.
MAX_REFERENCE_POINTS = 500
_N_PARTS = 3  # Default number of parts of the front.

POINT_KEYS = ("ideal", "nadir", "reference_point")
ScalingSource = Literal["problem", "union", "given", "objective"]


class NoFeasibleSolutionError(ValueError):
    """Error raised if every run failed, or no run found a feasible solution."""


@dataclass(frozen=True, eq=False)
class IndicatorSpace:
    """Scaled objective space in which quality indicators are computed.

    Calling the space maps objectives into it.

    Attributes
    ----------
    ideal, nadir : array, shape (n_obj,)
        Objectives that are mapped to 0 and 1; zeros and ones if the problem scales the objectives.
    reference_point : array, shape (n_obj,)
        Reference point of the hypervolume, in this space.
    reference_front : array, shape (m, n_obj)
        Reference front of IGD+ and the additive epsilon, in this space.
    origin : str
        Source of the scaling: "problem" (its ``map_to_indicator_space``), "union" (extent of all
        fronts), "given" (by the caller), or "objective" (a single objective, which is not scaled).
    transform : function or None
        ``map_to_indicator_space`` of the problem, if `origin` is "problem".
    parts : tuple of float
        Ascending values of the first objective that divide the front into parts, in the unit of the
        problem; empty for a single objective.
    cuts : tuple of float
        Values of `parts`, in this space.
    """

    ideal: FloatArray
    nadir: FloatArray
    reference_point: FloatArray
    reference_front: FloatArray
    origin: ScalingSource
    transform: Callable[[FloatArray], FloatArray] | None = None
    parts: tuple[float, ...] = ()
    cuts: tuple[float, ...] = ()

    def __call__(self, F: FloatArray) -> FloatArray:
        """Map objectives of shape (n, n_obj) into this space."""
        if not len(F):
            return np.empty((0, len(self.ideal)))
        F = F if self.transform is None else np.asarray(self.transform(F), dtype=float)
        return scale_objectives(F, self.ideal, self.nadir)

    def describe(self) -> dict[str, Any]:
        """Return the scaling, reference point and parts as a JSON-serializable dict."""
        if self.origin == "objective":
            return {"origin": self.origin}
        points = {key: getattr(self, key).tolist() for key in POINT_KEYS}
        return {
            "origin": self.origin,
            **points,
            "reference_front_points": len(self.reference_front),
            "parts": list(self.parts),
            "cuts": list(self.cuts),
        }


def build_indicator_space(
    problem: Problem,
    fronts: Iterable[FloatArray],
    *,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    reference_front: ArrayLike | None = None,
    parts: Sequence[float] | None = None,
) -> IndicatorSpace:
    """Build the scaled objective space for the indicators of a comparison.

    The scaling comes from `bounds` if given, otherwise from ``map_to_indicator_space`` of the
    problem if it is defined; the reference point is then (1, ..., 1). Otherwise, the nondominated
    union of all fronts and of the given reference front is scaled to [0, 1], and each coordinate of
    the reference point is `REFERENCE_COORDINATE`. A single objective is not scaled.

    The default reference front is the nondominated union of all fronts, truncated to
    `MAX_REFERENCE_POINTS` evenly spaced points, so that an algorithm with crowded points does not
    determine the weight of each region. The problem's ``pareto_front()`` is not used, because pymoo
    samples some of these fronts at random and downloads others; pass it as `reference_front` if it
    is suitable.

    Parameters
    ----------
    problem : Problem
        Compared problem.
    fronts : iterable of arrays, shape (n, n_obj)
        Objectives of the front of each run.
    bounds : (array_like, array_like), optional
        Ideal and nadir point, in the units of the objectives.
    reference_front : array_like, shape (m, n_obj), optional
        Reference front, in the units of the objectives.
    parts : sequence of float, optional
        Ascending values of the first objective that divide the front into parts. By default, each
        of three parts contains a third of the points of the reference front.

    Returns
    -------
    IndicatorSpace
        Space with scaling, reference point, reference front and parts.

    Raises
    ------
    NoFeasibleSolutionError
        If no front has a point.
    ValueError
        If an argument is invalid or is given for a single objective, or the problem is dynamic.
    """
    ends, reference, part_values = validate_space_arguments(problem, bounds, reference_front, parts)
    n_obj = problem.n_obj
    union = np.concatenate([np.empty((0, n_obj)), *fronts])
    candidates = union if reference is None else np.concatenate([union, reference])
    best = candidates[find_nondominated(candidates)]
    if not len(best):
        raise NoFeasibleSolutionError("no run found a feasible solution")
    if n_obj == 1:
        return SINGLE_OBJECTIVE_SPACE
    transform = protocol.get_indicator_map(problem)
    origin: ScalingSource = "problem"
    ideal, nadir, reference_point = np.zeros(n_obj), np.ones(n_obj), np.ones(n_obj)
    if ends is not None:
        origin, transform, (ideal, nadir) = "given", None, ends
    elif transform is None:
        origin, ideal, nadir = "union", best.min(axis=0), best.max(axis=0)
        reference_point = np.full(n_obj, REFERENCE_COORDINATE)
    space = IndicatorSpace(ideal, nadir, reference_point, np.empty((0, n_obj)), origin, transform)
    front = best if reference is None else reference
    points = space(front)
    if reference is None:
        rows = truncate(points, max(MAX_REFERENCE_POINTS, 2 * n_obj))
        front, points = front[rows], points[rows]
    divisions, cuts = _divide_front(space, front, points, part_values)
    return replace(space, reference_front=points, parts=divisions, cuts=cuts)


def validate_space_arguments(
    problem: Problem,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    reference_front: ArrayLike | None = None,
    parts: Sequence[float] | None = None,
) -> tuple[tuple[FloatArray, FloatArray] | None, FloatArray | None, list[float] | None]:
    """Validate the arguments that define an indicator space, and convert them to arrays.

    Returns
    -------
    bounds, reference_front, parts
        Validated arguments, None for those that are not given.

    Raises
    ------
    ValueError
        If an argument is invalid or is given for a single objective, or the problem is dynamic.
    """
    n_obj, ends, front, part_values = problem.n_obj, None, None, None
    if is_dynamic(problem):
        raise ValueError(
            f"{type(problem).__name__} is a dynamic problem: its values change with time, so that "
            "fronts of different generations cannot be compared; expected a static problem, such "
            "as one problem for each time"
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
        part_values = validate_list("parts", parts, validate_number)
        if not part_values or any(low >= high for low, high in pairwise(part_values)):
            raise ValueError(f"parts = {part_values}: expected one or more ascending values")
    return ends, front, part_values


def _divide_front(
    space: IndicatorSpace, front: FloatArray, points: FloatArray, part_values: list[float] | None
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the values of the first objective that divide the front, unscaled and scaled.

    A given value is mapped together with the other objectives of a point of the reference front,
    because the space scales each objective separately.
    """
    if part_values is None:
        order = np.argsort(points[:, 0], kind="stable")
        rows = order[[len(order) * k // _N_PARTS for k in range(1, _N_PARTS)]]
        cuts = dict(zip(points[rows, 0], front[rows, 0], strict=True))  # Distinct and ascending.
        return tuple(map(float, cuts.values())), tuple(map(float, cuts))
    rows_at_values = np.repeat(front[:1], len(part_values), axis=0)
    rows_at_values[:, 0] = part_values
    return tuple(part_values), tuple(space(rows_at_values)[:, 0].tolist())


#: Indicator space of a single objective, which is not scaled.
SINGLE_OBJECTIVE_SPACE = IndicatorSpace(
    np.zeros(1), np.ones(1), np.ones(1), np.empty((0, 1)), "objective"
)


#: Function that returns the indicator of a front, shape (n, n_obj) with n >= 1, in a space.
IndicatorFunction = Callable[[FloatArray, IndicatorSpace], float]


@dataclass(frozen=True)
class Indicator:
    """Quality indicator of a front, such as the hypervolume.

    Attributes
    ----------
    name : str
        Name of the column in tables.
    title : str
        Name in reports and figures.
    is_maximized : bool
        Whether larger values are better.
    measure : function
        Returns the value of a front that is not empty.
    """

    name: str
    title: str
    is_maximized: bool
    measure: IndicatorFunction

    def evaluate(self, points: FloatArray, space: IndicatorSpace) -> float:
        """Return the indicator value of a front, or the worst value for an empty front.

        Parameters
        ----------
        points : array, shape (n, n_obj)
            Front, mapped into the space.
        space : IndicatorSpace
            Space of the comparison.
        """
        if not len(points):
            return 0.0 if self.is_maximized else np.inf
        return float(self.measure(points, space))

    @property
    def direction(self) -> str:
        """Phrase "higher is better" or "lower is better"."""
        return "higher is better" if self.is_maximized else "lower is better"

    def negate_if_minimized(self, values: Any) -> Any:
        """Return the values, negated if lower values are better."""
        return values if self.is_maximized else -values


def _use_reference_front(measure: Callable[..., float]) -> IndicatorFunction:
    return lambda points, space: measure(points, ref=space.reference_front)


def _hypervolume_between(
    points: FloatArray, space: IndicatorSpace, low: float = -np.inf, high: float = np.inf
) -> float:
    """Compute the hypervolume of a front within a range of the first objective."""
    end = space.reference_point.copy()
    end[0] = min(high, end[0])
    within = points[points[:, 0] < end[0]].copy()
    if low >= end[0] or not len(within):
        return 0.0
    within[:, 0] = np.maximum(within[:, 0], low)
    return float(HV(ref_point=end)(within))


#: Indicator of a single objective: the minimum of all evaluations.
BEST_VALUE = Indicator("best_value", "best value", False, lambda points, space: points.min())

#: Indicators of several objectives.
#: Hypervolume: dominated volume up to the reference point; 0 for an empty front.
#: IGD+ (Ishibuchi et al. 2015): mean distance from each point of the reference front to the region
#: that the front dominates. Additive epsilon (Zitzler et al. 2003): smallest translation of the
#: front after which it weakly dominates the reference front. Both are infinite for an empty front.
INDICATORS = (
    Indicator("hypervolume", "hypervolume", True, _hypervolume_between),
    Indicator("igd_plus", "IGD+", False, _use_reference_front(moocore.igd_plus)),
    Indicator("epsilon", "additive epsilon", False, _use_reference_front(moocore.epsilon_additive)),
)


def build_part_indicators(space: IndicatorSpace, objective: str) -> list[Indicator]:
    """Build one hypervolume indicator for each part of a front.

    The values of all parts add up to the hypervolume. The last part ends at the reference
    point.

    Parameters
    ----------
    space : IndicatorSpace
        Space with the `cuts` between the parts.
    objective : str
        Name of the first objective, for the titles.
    """
    edges = [-np.inf, *space.cuts, float("inf")]
    names = [f"{value:.0f}" if abs(value) >= 1e3 else f"{value:.3g}" for value in space.parts]
    titles = [f"to {low}" for low in names[:1]]
    titles += [f"from {low} to {high}" for low, high in pairwise(names)]
    titles += [f"from {high}" for high in names[-1:]]
    return [
        Indicator(
            f"hypervolume_{i + 1}",
            f"hypervolume, {objective} {title}",
            True,
            partial(_hypervolume_between, low=edges[i], high=edges[i + 1]),
        )
        for i, title in enumerate(titles)
    ]


def select_indicators(n_obj: int) -> list[Indicator]:
    """Return the quality indicators that apply to the given number of objectives.

    The hypervolume, which is computed exactly, is included up to `MAX_OBJECTIVES` objectives.
    """
    if n_obj == 1:
        return [BEST_VALUE]
    has_hypervolume = n_obj <= MAX_OBJECTIVES
    return [
        indicator for indicator in INDICATORS if has_hypervolume or indicator.name != "hypervolume"
    ]


def build_indicator_rows(
    problem: Problem, run: StudyRun, grid: Sequence[int], space: IndicatorSpace
) -> list[dict[str, Any]]:
    """Compute the indicators of a run, with one dict per evaluation count in `grid`.

    Each dict has ``evaluations``, the indicators, the hypervolume of each part, the number of
    ``points`` on the front (at most 1 for a single objective), and the values of
    ``front_summary(F)`` of the problem's view.
    """
    indicators = select_indicators(problem.n_obj)
    if problem.n_obj <= MAX_OBJECTIVES:
        indicators += build_part_indicators(space, "")
    rows, view = [], build_view(problem)
    for evaluations, F in zip(grid, run.iterate_fronts(grid), strict=True):
        points = space(F)
        values = {indicator.name: indicator.evaluate(points, space) for indicator in indicators}
        rows.append(
            {"evaluations": int(evaluations), **values, "points": len(F)}
            | {
                str(name): value
                for name, value in call_optional(view, View.front_summary, F).items()
            }
        )
    return rows
