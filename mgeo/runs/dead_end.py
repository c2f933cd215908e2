"""What to tell of a run that finds nothing that keeps all limits: what binds, and ways out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mgeo.plugins import protocol
from mgeo.runs.limits import Limit, constraints, limits

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

    from mgeo.store.run import Nearest

_MOST_WAYS = 3  # are told


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
