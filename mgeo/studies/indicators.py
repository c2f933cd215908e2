"""Quality of a front as numbers: hypervolume, IGD+, additive epsilon; or the best value."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import moocore
import numpy as np
from pymoo.indicators.hv import HV

from mgeo._typing import FloatArray
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, view_of
from mgeo.runs.meters import MAX_OBJECTIVES

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

    from mgeo.store.study_run import StudyRun
    from mgeo.studies.space import IndicatorSpace


@dataclass(frozen=True)
class Indicator:
    """A number for a front in an `IndicatorSpace`; `larger` says which way is better."""

    name: str
    title: str
    larger: bool
    value: Callable[[FloatArray, IndicatorSpace], float]

    @property
    def direction(self) -> str:
        """Which way is better, in words."""
        return "higher is better" if self.larger else "lower is better"

    def better(self, values: Any) -> Any:
        """Values turned so that larger is better."""
        return values if self.larger else -values


def _hypervolume(points: FloatArray, space: IndicatorSpace) -> float:
    return float(HV(ref_point=space.reference_point)(points)) if len(points) else 0.0


def _igd_plus(points: FloatArray, space: IndicatorSpace) -> float:
    return float(moocore.igd_plus(points, ref=space.reference_front)) if len(points) else np.inf


def _epsilon(points: FloatArray, space: IndicatorSpace) -> float:
    known = space.reference_front
    return float(moocore.epsilon_additive(points, ref=known)) if len(points) else np.inf


def _best_value(points: FloatArray, space: IndicatorSpace) -> float:
    return float(points.min(initial=np.inf))


#: Of a single objective: the least value found.
BEST_VALUE = Indicator("best_value", "best value", False, _best_value)

#: Of several objectives.
#: Hypervolume: how much of the space up to the reference point is dominated; an empty front has 0.
#: IGD+ (Ishibuchi et al. 2015): mean over the reference front of how far the nearest point of the
#: front is from dominating it. Additive epsilon (Zitzler et al. 2003): by how much the front must
#: be moved to weakly dominate the whole reference front. An empty front is infinitely far.
INDICATORS = (
    Indicator("hypervolume", "hypervolume", True, _hypervolume),
    Indicator("igd_plus", "IGD+", False, _igd_plus),
    Indicator("epsilon", "additive epsilon", False, _epsilon),
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


def _slab(points: FloatArray, space: IndicatorSpace, low: float, high: float) -> float:
    end = space.reference_point.copy()
    end[0] = min(high, end[0])
    within = points[points[:, 0] < end[0]].copy()
    if low >= end[0] or not len(within):
        return 0.0
    within[:, 0] = np.maximum(within[:, 0], low)
    return float(HV(ref_point=end)(within))


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
