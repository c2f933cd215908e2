"""Hypervolume of a run's fronts, seen as the problem says indicators should see them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Strict
from pymoo.indicators.hv import HV

from mgeo.evaluation.individuals import succeeded
from mgeo.plugins.protocol import indicator_space
from mgeo.store.models import Table

if TYPE_CHECKING:
    from pymoo.core.population import Population
    from pymoo.core.problem import Problem

# The exact hypervolume takes 1 ms for 300 points in 5 objectives, 40 ms in 6, a minute in 8.
MAX_OBJECTIVES = 5
Point = Annotated[tuple[float, ...], Strict(False)]  # of JSON, it is a list


class Hypervolume(Table):
    """A hypervolume with reference point (1, ..., 1), and the space it was measured in.

    ``space`` is "problem" (the problem's `indicator_space`) or "seen": objectives scaled so that
    everything the run evaluated lies between 0 (``ideal``) and 1 (``nadir``), in which case the
    value does not compare with that of another run.
    """

    value: float
    space: Literal["problem", "seen"]
    ideal: Point = ()
    nadir: Point = ()


class HypervolumeMeter:
    """Measures fronts of one problem; watches what a run evaluates where it needs the range."""

    def __init__(self, problem: Problem) -> None:
        self._n_obj: int = problem.n_obj
        self._indicator_space = indicator_space(problem)
        #: Least values of the objectives seen, and greatest; empty before there are any.
        self.seen: list[list[float]] = []

    def see(self, population: Population) -> None:
        """Take evaluated solutions into the range seen (the finite, feasible, not failed ones)."""
        if self._indicator_space is not None or not len(population):
            return
        F = population.get("F")[population.get("feas") & succeeded(population)]
        F = F[np.isfinite(F).all(axis=1)]
        if len(F):
            F = np.vstack([*self.seen, F])
            self.seen = [F.min(axis=0).tolist(), F.max(axis=0).tolist()]

    def __call__(self, F: ArrayLike) -> Hypervolume | None:
        """Hypervolume of a front, shape (n, n_obj).

        None where there is only one objective, or more than `MAX_OBJECTIVES`.
        """
        front = np.asarray(F, dtype=float)
        if not 1 < self._n_obj <= MAX_OBJECTIVES:
            return None
        if self._indicator_space is not None:
            value = _hypervolume(self._indicator_space(front)) if len(front) else 0.0
            return Hypervolume(value=value, space="problem")
        if not len(front):
            return Hypervolume(value=0.0, space="seen")
        ideal, nadir = self.seen
        value = _hypervolume(scaled(front, np.array(ideal), np.array(nadir)))
        return Hypervolume(value=value, space="seen", ideal=tuple(ideal), nadir=tuple(nadir))


def scaled(
    F: NDArray[np.float64], ideal: NDArray[np.float64], nadir: NDArray[np.float64]
) -> NDArray[np.float64]:
    """`F` with `ideal` at 0 and `nadir` at 1; an objective without extent only moves to 0."""
    extent = nadir - ideal
    return (F - ideal) / np.where(extent > 0, extent, 1.0)


def _hypervolume(points: NDArray[np.float64]) -> float:
    return float(HV(ref_point=np.ones(points.shape[1]))(points))
