"""What a run comes to: the solutions that a person would look at first, and the first in a line.

And which limits they keep, by how much; and what to do where nothing keeps them all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo.plugins.protocol import indicator_space
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, is_own
from mgeo.runs.hypervolume import scaled

if TYPE_CHECKING:
    import pandas as pd
    from pymoo.core.problem import Problem

_FLAT = 1e-9  # bulges smaller than this, of a front of size 1, are rounding


@dataclass(frozen=True)
class Answer:
    """A solution by its number, of how many, why this one, and what it is worth.

    Attributes
    ----------
    exceeded
        Limits of which the problem tells that it exceeds them, though it keeps all constraints.
    instead
        Then the nearest solution that exceeds none, by its number, if one is found.
    """

    solution: int
    count: int
    label: str
    text: str
    exceeded: tuple[str, ...] = ()
    instead: int | None = None

    def __str__(self) -> str:
        said = f"solution {self.solution} of {self.count:,}, {self.label}: {self.text}"
        if not self.exceeded:
            return said
        other = "" if self.instead is None else f"; solution {self.instead} keeps all limits"
        return f"{said}; BUT {'; '.join(self.exceeded)}{other}"


def answer(view: View) -> Answer:
    """The `default_solution` of a front, of at least one solution, in the problem's words."""
    shown = default_solution(view.problem, view.F)
    chosen = view.take([shown.row])
    (line,) = ask(chosen, View.answers)
    # whatever is on a front keeps the constraints: none is evaluated again
    (known,) = limits(chosen) if is_own(view, View.limits) else [[]]
    exceeded = tuple(str(limit) for limit in known if not limit.kept)
    instead = nearest_kept(view, shown.row) if exceeded else None
    return Answer(shown.row, len(view.X), shown.label, line, exceeded, instead)


@dataclass(frozen=True)
class RepresentativeSolution:
    """A row of the front and why it is shown."""

    row: int
    label: str


def representative_solutions(
    problem: Problem, F: ArrayLike, names: tuple[str, ...]
) -> list[RepresentativeSolution]:
    """The best of each objective, the knee, and solutions between, ordered by first objective.

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
    """What is shown of a front where nobody chose: its knee, or the best of its first objective.

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
    """Row with the least value of each objective; ties go to the least sum of the others."""
    total = points.sum(axis=1)
    return [int(np.lexsort((total, column))[0]) for column in points.T]


def knee(points: NDArray[np.float64]) -> int | None:
    """Row farthest from the line or plane through the extremes, on the side of the ideal point.

    None if no row lies on that side (a straight or concave front, or fewer than three points).
    """
    corners = points[extremes(points)]
    normal = _normal(corners)
    bulge = (corners[0] - points) @ normal
    row = int(np.argmax(bulge))
    return row if bulge[row] > _FLAT else None


def _points(problem: Problem, front: NDArray[np.float64]) -> NDArray[np.float64]:
    """The front in the problem's indicator space, or else scaled to its own extent."""
    space = indicator_space(problem)
    return space(front) if space else scaled(front, front.min(axis=0), front.max(axis=0))


def _normal(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit normal, pointing away from the ideal, of the hyperplane through m points in m-space."""
    diagonal = np.full(corners.shape[1], corners.shape[1] ** -0.5)
    _, sizes, rows = np.linalg.svd(corners[1:] - corners[0])
    if len(sizes) and sizes[-1] < _FLAT:  # extremes coincide: any plane would do
        return diagonal
    normal: NDArray[np.float64] = rows[-1]
    return normal if normal @ diagonal >= 0 else -normal


def _spread(points: NDArray[np.float64], chosen: list[int], count: int) -> list[int]:
    """Rows to add until there are `count`: each time the one farthest from all chosen so far."""
    added: list[int] = []
    while len(chosen) + len(added) < min(count, len(points)):
        taken = points[chosen + added]
        distance = np.linalg.norm(points[:, None] - taken[None], axis=2).min(axis=1)
        distance[chosen + added] = -1.0  # duplicates of a chosen point are at distance 0
        added.append(int(np.argmax(distance)))
    return added


#: Solutions that `nearest_kept` looks at.
_NEAREST, _SPREAD = 16, 34
_MOST_WAYS = 3  # are told


@dataclass(frozen=True)
class Margin:
    """A limit, and how far one solution is from it.

    Attributes
    ----------
    margin
        What is left until the limit, below zero where it is exceeded; NaN if it is not known.
    unit, value, bound, limit
        Of a problem with ``limits``: ``value`` must be ``bound`` ("at most" or "at least") the
        ``limit``. Of any other the margin is that of the constraint, in whatever it is computed in.
    """

    name: str
    margin: float
    unit: str = ""
    value: float | None = None
    bound: str = ""
    limit: float | None = None

    @property
    def kept(self) -> bool:
        return self.margin >= 0.0

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit not in ("", "-") else ""
        state = "margin" if self.kept else "exceeded by"
        off = f"{state} {abs(self.margin):.3g}{unit}"
        if self.value is None:
            return f"{self.name}: {off}"
        return f"{self.name}: {self.value:.4g}{unit}, {self.bound} {self.limit:.4g}{unit}: {off}"


def limits(view: View) -> list[list[Margin]]:
    """The limits of each solution of a view, in the problem's order."""
    return _read(ask(view, View.limits))


def nearest_kept(view: View, row: int) -> int | None:
    """The row nearest to this one of which the problem tells that it keeps all limits.

    Rows are those of a front, in the order of its first objective. Looked at are the nearest, and
    others at even distances, `_NEAREST` and `_SPREAD` of them: the limits of one can take a tenth
    of a second. None if none of these keeps all, or if the problem tells of no limits.
    """
    if not is_own(view, View.limits):
        return None
    n = len(view.X)
    rows = sorted(range(n), key=lambda i: (abs(i - row), i))
    spread = np.linspace(0, n - 1, min(n, _SPREAD)).round().astype(int)
    looked_at = {*rows[:_NEAREST], *spread.tolist()}
    for i in filter(looked_at.__contains__, rows):
        (found,) = limits(view.take([i]))
        if all(limit.kept for limit in found):
            return i
    return None


def _read(tables: list[pd.DataFrame]) -> list[list[Margin]]:
    found = []
    for table in tables:
        columns = [table[key].tolist() for key in ("margin", "unit", "value", "bound", "limit")]
        rows = zip(table.index, *columns, strict=True)
        found.append([_limit(str(name), *cells) for name, *cells in rows])
    return found


def _limit(name: str, margin: float, unit: str, value: float, bound: str, limit: float) -> Margin:
    """Of a constraint that is no more than a number only the margin is known."""
    if np.isnan(limit):
        return Margin(name, margin)
    return Margin(name, margin, unit, value, bound, limit)


@dataclass(frozen=True)
class DeadEnd:
    """Lines for people.

    Attributes
    ----------
    exceeded
        Each limit that some of the nearest solutions exceed: by how much at least, and how many.
    ways
        What the problem itself says, then limits that would have to be relaxed together, and to
        what, the fewest first.
    """

    exceeded: tuple[str, ...]
    ways: tuple[str, ...]


def dead_end(view: View) -> DeadEnd:
    """What stands in the way of the solutions that come nearest, at least one."""
    # a problem may be stricter than what it tells
    pairs = zip(limits(view), _read(View.limits(view)), strict=True)  # as told, as computed
    exceeded = [_exceeded(told) or _exceeded(computed) for told, computed in pairs]
    return DeadEnd(tuple(_binding(exceeded)), (*ask(view, View.ways_out), *_ways(exceeded)))


def _exceeded(told: list[Margin]) -> list[Margin]:
    return [limit for limit in told if not limit.kept]


def _binding(exceeded: list[list[Margin]]) -> list[str]:
    by_name: dict[str, list[Margin]] = {}
    for limit in (limit for each in exceeded for limit in each):
        by_name.setdefault(limit.name, []).append(limit)
    return [
        f"{max(found, key=lambda limit: limit.margin)} at least ({len(found)} of {len(exceeded)})"
        for found in by_name.values()
    ]


def _ways(exceeded: list[list[Margin]]) -> list[str]:
    """Of solutions that exceed the same limits only the first; those with the fewest come first."""
    first: dict[frozenset[str], int] = {}
    for row, each in enumerate(exceeded):
        first.setdefault(frozenset(limit.name for limit in each), row)
    rows = sorted(first.values(), key=lambda row: (len(exceeded[row]), row))
    return [
        f"relax {' and '.join(map(_relaxed, exceeded[row]))} (nearest solution {row})"
        for row in rows[:_MOST_WAYS]
    ]


def _relaxed(limit: Margin) -> str:
    """To what a limit that is exceeded would have to be relaxed."""
    if limit.value is None or limit.limit is None:
        return f"{limit.name} by {_outward(-limit.margin, up=True)}"
    unit = f" {limit.unit}" if limit.unit not in ("", "-") else ""
    value = _outward(limit.value, up=limit.bound == "at most")
    return f"{limit.name} from {limit.limit:.4g} to {value}{unit}"


def _outward(value: float, *, up: bool) -> str:
    """Three digits, rounded so that the value itself is allowed."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - 2)
    steps = math.ceil(value / unit) if up else math.floor(value / unit)
    return f"{steps * unit:.3g}"
