"""Which limits solutions keep, and by how much; and what to do where nothing keeps them all."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mgeo._typing import FloatArray
from mgeo.algorithms.variables import designs_of
from mgeo.plugins import protocol

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

    from mgeo.store.run import Nearest

#: Solutions that `nearest_kept` looks at.
_NEAREST, _SPREAD = 16, 34
#: By how much equality constraints may be off, as in pymoo.
TOLERANCE = 1e-4

_MOST_WAYS = 3  # are told


@dataclass(frozen=True)
class Limit:
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


def limits(problem: Problem, X: NDArray[Any]) -> list[list[Limit]]:
    """The limits of each solution, shape (n, n_var), in the problem's order."""
    found = told(problem, X)
    return constraints(problem, X) if found is None else found


def told(problem: Problem, X: NDArray[Any]) -> list[list[Limit]] | None:
    """Those of a problem with ``limits``, which may tell more than its constraints; else None."""
    tables = protocol.limits(problem, X)
    if tables is None:
        return None
    keys = ("margin", "unit", "value", "bound", "limit")
    columns = [[table[key].tolist() for key in keys] for table in tables]
    return [
        [Limit(str(name), *cells) for name, *cells in zip(table.index, *each, strict=True)]
        for table, each in zip(tables, columns, strict=True)
    ]


def nearest_kept(problem: Problem, X: NDArray[Any], row: int) -> int | None:
    """The row nearest to this one of which the problem tells that it keeps all limits.

    Rows are those of a front, in the order of its first objective. Looked at are the nearest, and
    others at even distances, `_NEAREST` and `_SPREAD` of them: the limits of one can take a tenth
    of a second. None if none of these keeps all, or if the problem tells of no limits.
    """
    rows = sorted(range(len(X)), key=lambda i: (abs(i - row), i))
    spread = np.linspace(0, len(X) - 1, min(len(X), _SPREAD)).round().astype(int)
    looked_at = {*rows[:_NEAREST], *spread.tolist()}
    for i in filter(looked_at.__contains__, rows):
        found = told(problem, X[[i]])
        if found is None:
            return None
        if all(limit.kept for limit in found[0]):
            return i
    return None


def constraints(problem: Problem, X: NDArray[Any]) -> list[list[Limit]]:
    """The constraints of each solution as they are computed, inequalities first."""
    names = protocol.constraint_names(problem)
    if not names or not len(X):
        return [[] for _ in X]
    margins = -excess(*problem.evaluate(designs_of(problem, X), return_values_of=["G", "H"]))
    return [
        [Limit(name, margin) for name, margin in zip(names, row, strict=True)]
        for row in margins.tolist()
    ]


def excess(G: FloatArray, H: FloatArray) -> FloatArray:
    """By how much constraints are exceeded, at most zero where they are kept, shape (n, g + h)."""
    return np.hstack([np.asarray(G, dtype=float), np.abs(np.asarray(H, dtype=float)) - TOLERANCE])


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


def dead_end(problem: Problem, nearest: Nearest) -> DeadEnd:
    """What stands in the way of solutions, of which there is at least one."""
    X = nearest.X
    # a problem may be stricter than what it tells
    pairs = zip(limits(problem, X), constraints(problem, X), strict=True)
    exceeded = [_exceeded(told) or _exceeded(computed) for told, computed in pairs]
    return DeadEnd(tuple(_binding(exceeded)), (*protocol.ways_out(problem, X), *_ways(exceeded)))


def _exceeded(told: list[Limit]) -> list[Limit]:
    return [limit for limit in told if not limit.kept]


def _binding(exceeded: list[list[Limit]]) -> list[str]:
    by_name: dict[str, list[Limit]] = {}
    for limit in (limit for each in exceeded for limit in each):
        by_name.setdefault(limit.name, []).append(limit)
    return [
        f"{max(found, key=lambda limit: limit.margin)} at least ({len(found)} of {len(exceeded)})"
        for found in by_name.values()
    ]


def _ways(exceeded: list[list[Limit]]) -> list[str]:
    """Of solutions that exceed the same limits only the first; those with the fewest come first."""
    first: dict[frozenset[str], int] = {}
    for row, each in enumerate(exceeded):
        first.setdefault(frozenset(limit.name for limit in each), row)
    rows = sorted(first.values(), key=lambda row: (len(exceeded[row]), row))
    return [
        f"relax {' and '.join(map(_relaxed, exceeded[row]))} (nearest solution {row})"
        for row in rows[:_MOST_WAYS]
    ]


def _relaxed(limit: Limit) -> str:
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
