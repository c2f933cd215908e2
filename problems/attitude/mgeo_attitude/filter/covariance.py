"""One predict and one update of the covariance, equations (3) and (4), over any scalar.

Both work in place on the lower triangle of P. On floats they are a plain filter, which the tests
use; on symbols (`symbols.py`) every assignment becomes a line of the generated kernel. F and H are
never formed: a sensor's `measure` is applied to the columns of P, and F is a sparse table.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Any, Protocol

from ..vector import Vec3

#: Entries of a sparse matrix by (row, column); the entries that are one are the float 1.0.
Sparse = Mapping[tuple[int, int], Any]


class Triangle(Protocol):
    """A symmetric matrix of which only entries (i, j) with i >= j are stored."""

    def __getitem__(self, index: tuple[int, int]) -> Any: ...
    def __setitem__(self, index: tuple[int, int], value: Any) -> None: ...


class Arithmetic(Protocol):
    """What the scalars cannot do by operators."""

    def keep(self, value: Any) -> Any:
        """Give an intermediate result that is used more than once a name."""

    def sqrt(self, value: Any) -> Any: ...


class FloatArithmetic:
    """Arithmetic of plain numbers."""

    def keep(self, value: float) -> float:
        return value

    def sqrt(self, value: float) -> float:
        return math.sqrt(value)


def predict(P: Triangle, n: int, F: Sparse, Q: Sparse, ops: Arithmetic) -> None:
    """P ← F P Fᵀ + Q, equation (3).

    Rows that F leaves out are rows of the identity, and without noise: those states are constant.
    Q holds the lower triangle of the process noise.
    """
    rows = _rows(F)
    reach = sorted({*rows, *(k for support in rows.values() for k in support)})
    # F P in the columns that F Fᵀ reaches first: it needs P as it was.
    FP = {(i, j): ops.keep(_dot(F, rows[i], P, i, j)) for i in rows for j in reach}
    for j in (j for j in range(n) if j not in reach):
        for i, value in [(i, ops.keep(_dot(F, rows[i], P, i, j))) for i in rows]:
            P[i, j] = value
    for i in rows:
        for j in reach:
            if j not in rows:
                P[i, j] = FP[i, j]
            elif j <= i:
                # (F P Fᵀ)ᵢⱼ from the sparser of the two rows
                a, b = (i, j) if len(rows[j]) <= len(rows[i]) else (j, i)
                P[i, j] = sum((FP[a, k] * F[b, k] for k in rows[b]), Q.get((i, j), 0.0))


def update(
    P: Triangle,
    n: int,
    measure: Callable[[Sequence[Any]], Vec3],
    variances: Sequence[Any],
    ops: Arithmetic,
    gate: Any = 1.0,
) -> None:
    """P ← P - K H P with K = P Hᵀ (R + H P Hᵀ)⁻¹, equation (4), the three rows together.

    With R + H P Hᵀ = L Lᵀ and G = P Hᵀ L⁻ᵀ this is P ← P - G Gᵀ, equation (8).
    A `gate` of zero leaves P as it is (sensor not available), one updates it.

    Parameters
    ----------
    measure : function
        Applies H to a state column and returns a `Vec3`.
    variances : three scalars
        Diagonal of R.
    """

    def project(j: int) -> list[Any]:
        """Row j of P Hᵀ."""
        return [ops.keep(y) for y in measure([P[i, j] for i in range(n)])]

    # H (P Hᵀ) needs only the rows of P Hᵀ that H looks at.
    PHt = {j: project(j) for j in range(n) if _looks_at(measure, n, j)}
    columns = [list(measure([PHt[j][r] if j in PHt else 0.0 for j in range(n)])) for r in range(3)]
    S = {(i, j): columns[j][i] for i in range(3) for j in range(i + 1)}
    L: dict[tuple[int, int], Any] = {}
    inverse: list[Any] = []
    for j in range(3):
        pivot = S[j, j] + variances[j] - sum(L[j, k] * L[j, k] for k in range(j))
        inverse.append(ops.keep(1.0 / ops.sqrt(pivot)))
        for i in range(j + 1, 3):
            value = S[i, j] - sum(L[i, k] * L[j, k] for k in range(j))
            L[i, j] = ops.keep(value * inverse[j])
    gated = [ops.keep(value * gate) for value in inverse]
    G: list[list[Any]] = []
    # Three rows of P at a time: an entry of G is then loaded once for three products. Rows below
    # are still as they were when P Hᵀ is taken from them.
    for first in range(0, n, 3):
        for j in range(first, first + 3):
            row, g = PHt.get(j) or project(j), list[Any]()
            for r in range(3):
                g.append(ops.keep((row[r] - sum(g[k] * L[r, k] for k in range(r))) * gated[r]))
            G.append(g)
        for j in range(first + 3):
            for i in range(max(first, j), first + 3):
                P[i, j] = reduce(lambda left, r: left - G[i][r] * G[j][r], range(3), P[i, j])


def last_pivot(P: Triangle, n: int, ops: Arithmetic) -> Any:
    """Last pivot of P = L Lᵀ, which is no positive number unless P is positive definite.

    It is so by arithmetic alone: the root of a negative pivot is NaN, and spoils the ones after
    it. (Plain Python's root raises a ValueError instead.)
    """
    L: dict[tuple[int, int], Any] = {}
    pivot: Any = 1.0
    for j in range(n):
        pivot = reduce(lambda value, k: value - L[j, k] * L[j, k], range(j), P[j, j])
        pivot = ops.keep(ops.sqrt(pivot))
        inverse = ops.keep(1.0 / pivot)
        for i in range(j + 1, n):
            value = reduce(lambda value, k: value - L[i, k] * L[j, k], range(j), P[i, j])
            L[i, j] = ops.keep(value * inverse)
    return pivot


def _rows(F: Sparse) -> dict[int, list[int]]:
    rows: dict[int, list[int]] = {}
    for i, k in F:
        rows.setdefault(i, []).append(k)
    return rows


def _dot(F: Sparse, support: Sequence[int], P: Triangle, i: int, j: int) -> Any:
    return sum(F[i, k] * P[k, j] for k in support)


def _looks_at(measure: Callable[[Sequence[Any]], Vec3], n: int, j: int) -> bool:
    """Whether column j of H has an entry that is not zero."""
    unit = [float(i == j) for i in range(n)]
    return any(not isinstance(y, float) or y != 0.0 for y in measure(unit))
