"""What a run comes to: the solutions that a person would look at first, and the first in a line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo.plugins.protocol import indicator_space
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, is_own
from mgeo.runs.limits import limits, nearest_kept
from mgeo.runs.meters import scaled

if TYPE_CHECKING:
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
