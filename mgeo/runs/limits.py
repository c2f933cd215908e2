"""Which limits solutions keep, and by how much; and what to do where nothing keeps them all."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, is_own

if TYPE_CHECKING:
    import pandas as pd

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


def constraints(view: View) -> list[list[Margin]]:
    """The constraints of each solution as they are computed, inequalities first."""
    return _read(View.limits(view))


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
    pairs = zip(limits(view), constraints(view), strict=True)
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
