"""Summary of a front: the solutions shown first, the limits they exceed, and suggestions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo.plugins.protocol import ask, indicator_space, is_own
from mgeo.plugins.view import View
from mgeo.runs.hypervolume import scaled

if TYPE_CHECKING:
    import pandas as pd
    from pymoo.core.problem import Problem

_FLAT = 1e-9  # bulges smaller than this, of a front of size 1, are rounding
_COLUMNS = ["margin", "unit", "value", "bound", "limit"]
_MOST_WAYS = 3  # suggestions that are printed


@dataclass(frozen=True)
class Answer:
    """The solution of a front that is shown first.

    Attributes
    ----------
    solution, count
        Its row, and the number of solutions.
    label
        Why it was chosen.
    text
        Summary by the problem.
    exceeded
        Limits that the problem reports as exceeded although all constraints are satisfied.
    """

    solution: int
    count: int
    label: str
    text: str
    exceeded: tuple[str, ...] = ()

    def __str__(self) -> str:
        line = f"solution {self.solution} of {self.count:,}, {self.label}: {self.text}"
        return "; ".join([line, *(f"BUT {limit}" for limit in self.exceeded)])


def answer(view: View) -> Answer:
    """Return the `default_solution` of a front of at least one solution, as the problem puts it."""
    shown = default_solution(view.problem, view.F)
    chosen = view.take([shown.row])
    (line,) = ask(chosen, View.answers)
    # a front satisfies the constraints: without limits of its own a problem is not evaluated again
    (known,) = limits(chosen) if is_own(view, View.limits) else [[]]
    exceeded = tuple(str(limit) for limit in known if not limit.kept)
    return Answer(shown.row, len(view.X), shown.label, line, exceeded)


@dataclass(frozen=True)
class RepresentativeSolution:
    """A row of the front and why it is shown."""

    row: int
    label: str


def representative_solutions(
    problem: Problem, F: ArrayLike, names: tuple[str, ...]
) -> list[RepresentativeSolution]:
    """Return the best of each objective, the knee, and solutions between, by first objective.

    Five in all (more if there are more than four objectives, fewer if the front is smaller),
    chosen in the problem's indicator space or else with the front scaled to its own extent.

    Parameters
    ----------
    F
        Front, shape (n, n_obj).
    names
        Objectives, for the labels.
    """
    front = np.asarray(F, dtype=float)
    if not len(front):
        return []
    points = _points(problem, front)
    labels: dict[int, list[str]] = {}
    for row, name in zip(extremes(points), names, strict=True):
        labels.setdefault(row, []).append(f"best {name}")
    knee_row = knee(points)
    if knee_row is not None:
        labels[knee_row] = ["knee"]
    for row in _spread(points, list(labels), max(5, len(labels))):
        labels[row] = ["between"]
    rows = sorted(labels, key=lambda row: tuple(front[row]))
    return [RepresentativeSolution(row, ", ".join(labels[row])) for row in rows]


def default_solution(problem: Problem, F: ArrayLike) -> RepresentativeSolution:
    """Return the knee of a front, or the best of its first objective if it has none.

    Parameters
    ----------
    F
        Front, shape (n, n_obj), n >= 1.
    """
    points = _points(problem, np.asarray(F, dtype=float))
    row = knee(points)
    if row is not None:
        return RepresentativeSolution(row, "knee")
    return RepresentativeSolution(extremes(points)[0], "best of the first objective")


def extremes(points: NDArray[np.float64]) -> list[int]:
    """Return the row with the least value of each objective, of ties that with the least sum."""
    total = points.sum(axis=1)
    return [int(np.lexsort((total, column))[0]) for column in points.T]


def knee(points: NDArray[np.float64]) -> int | None:
    """Return the row farthest from the plane through the extremes, toward the ideal point.

    None if no row lies on that side (a straight or concave front, or fewer than three points).
    """
    corners = points[extremes(points)]
    normal = _normal(corners)
    bulge = (corners[0] - points) @ normal
    row = int(np.argmax(bulge))
    return row if bulge[row] > _FLAT else None


def _points(problem: Problem, front: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the front in the problem's indicator space, or else scaled to its own extent."""
    space = indicator_space(problem)
    return space(front) if space else scaled(front, front.min(axis=0), front.max(axis=0))


def _normal(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit normal, pointing away from the ideal, of the plane through m points."""
    diagonal = np.full(corners.shape[1], corners.shape[1] ** -0.5)
    _, sizes, rows = np.linalg.svd(corners[1:] - corners[0])
    if len(sizes) and sizes[-1] < _FLAT:  # extremes coincide: any plane would do
        return diagonal
    normal: NDArray[np.float64] = rows[-1]
    return normal if normal @ diagonal >= 0 else -normal


def _spread(points: NDArray[np.float64], chosen: list[int], count: int) -> list[int]:
    """Return rows to add until there are `count`, each the farthest from those chosen before."""
    added: list[int] = []
    while len(chosen) + len(added) < min(count, len(points)):
        taken = points[chosen + added]
        distance = np.linalg.norm(points[:, None] - taken[None], axis=2).min(axis=1)
        distance[chosen + added] = -1.0  # duplicates of a chosen point are at distance 0
        added.append(int(np.argmax(distance)))
    return added


@dataclass(frozen=True)
class Margin:
    """A limit, and the margin of one solution.

    Attributes
    ----------
    margin
        Distance to the limit, negative where it is exceeded; NaN if it is not known.
    unit, value, bound, limit
        For a problem with ``limits``: ``value`` must be ``bound`` ("at most" or "at least") the
        ``limit``. Without, both are NaN and the margin is that of the constraint, in its units.
    """

    name: str
    margin: float
    unit: str = ""
    value: float = math.nan
    bound: str = ""
    limit: float = math.nan

    @property
    def kept(self) -> bool:
        return self.margin >= 0.0

    @property
    def _unit(self) -> str:
        return f" {self.unit}" if self.unit not in ("", "-") else ""

    def __str__(self) -> str:
        state = "margin" if self.kept else "exceeded by"
        off = f"{state} {abs(self.margin):.3g}{self._unit}"
        if math.isnan(self.value):
            return f"{self.name}: {off}"
        asked = f"{self.bound} {self.limit:.4g}{self._unit}"
        return f"{self.name}: {self.value:.4g}{self._unit}, {asked}: {off}"

    def relaxed(self) -> str:
        """Return by how much to relax an exceeded limit, rounded up to three digits."""
        excess = -self.margin
        if math.isfinite(excess):
            unit = 10.0 ** (math.floor(math.log10(excess)) - 2)
            excess = math.ceil(excess / unit) * unit
        return f"{self.name} by {excess:.3g}{self._unit}"


def limits(view: View) -> list[list[Margin]]:
    """Return the limits of each solution of a view, in the problem's order."""
    return _margins(ask(view, View.limits))


def _margins(tables: list[pd.DataFrame]) -> list[list[Margin]]:
    return [
        [Margin(str(name), *row) for name, *row in table[_COLUMNS].itertuples(name=None)]
        for table in tables
    ]


@dataclass(frozen=True)
class DeadEnd:
    """Why no solution is feasible.

    Attributes
    ----------
    exceeded
        Each limit that the nearest solutions exceed: by how much at least, and how many do.
    ways
        Suggestions of the problem, then limits to relax together, the fewest first.
    """

    exceeded: tuple[str, ...]
    ways: tuple[str, ...]


def dead_end(view: View) -> DeadEnd:
    """Return the limits that the nearest solutions exceed, at least one, and suggestions."""
    # where all limits that the problem reports are satisfied, its constraints are not
    pairs = zip(limits(view), _margins(View.limits(view)), strict=True)
    rows = [
        [limit for limit in reported if not limit.kept]
        or [limit for limit in computed if not limit.kept]
        for reported, computed in pairs
    ]
    by_name: dict[str, list[Margin]] = {}
    ways: dict[frozenset[str], str] = {}  # by the names of the limits
    for row in sorted(rows, key=len):
        for limit in row:
            by_name.setdefault(limit.name, []).append(limit)
        names = frozenset(limit.name for limit in row)
        ways.setdefault(names, f"relax {' and '.join(limit.relaxed() for limit in row)}")
    exceeded = (
        f"{max(found, key=lambda limit: limit.margin)} at least ({len(found)} of {len(rows)})"
        for found in by_name.values()
    )
    suggestions = (*ask(view, View.ways_out), *list(ways.values())[:_MOST_WAYS])
    return DeadEnd(tuple(exceeded), suggestions)
