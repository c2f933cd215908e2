"""One predict and one update of the covariance, equations (3) and (4), over any scalar.

Both work in place on the lower triangle of P. On floats they are a plain filter; on symbols
(`symbols.py`) every operation becomes a line of the generated kernel. F and H are never formed: a
sensor's `measure` is applied to the columns of P, and F is a sparse table.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import reduce
from typing import Any

import numpy as np

from mgeo_attitude.vector import Vec3

#: Entries of a sparse matrix by (row, column).
Sparse = Mapping[tuple[int, int], Any]
Factor = dict[tuple[int, int], Any]


def predict(P: Any, n: int, F: Sparse, Q: Sparse) -> None:
    """P ← F P Fᵀ + Q, equation (3).

    Rows that F leaves out are rows of the identity, and without noise: those states are constant.

    Parameters
    ----------
    P : symmetric matrix
        Only entries (i, j) with i >= j are written.
    n : int
        Number of states.
    F, Q : sparse matrices
        Transition, and the lower triangle of the process noise.
    """
    rows: dict[int, list[int]] = {}
    for i, k in F:
        rows.setdefault(i, []).append(k)
    reach = sorted({*rows, *(k for support in rows.values() for k in support)})

    def product(i: int, j: int) -> Any:
        return sum(F[i, k] * P[k, j] for k in rows[i])

    # F P in the columns that F Fᵀ reaches first: it needs P as it was.
    FP = {(i, j): product(i, j) for i in rows for j in reach}
    for j in (j for j in range(n) if j not in reach):
        for i, value in [(i, product(i, j)) for i in rows]:
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
    P: Any,
    n: int,
    measure: Callable[[Sequence[Any]], Vec3],
    variances: Sequence[Any],
    gate: Any = 1.0,
    considered: Collection[int] = (),
) -> None:
    """P ← P - K H P with K = P Hᵀ (R + H P Hᵀ)⁻¹, equation (4), the three rows together.

    With R + H P Hᵀ = L Lᵀ and G = P Hᵀ L⁻ᵀ this is P ← P - G Gᵀ, equation (8).
    A `gate` of zero leaves P as it is (sensor not available), one updates it.

    States that are `considered` have no gain: G Gᵀ is taken from P but where both states are
    such. With K = [K₁; 0], K₁ the optimal gain of the others, that is what the filter of any gain
    has, (I - K H) P (I - K H)ᵀ + K R Kᵀ (S. F. Schmidt, Application of State-Space Methods to
    Navigation Problems, Advances in Control Systems 3 (1966) 293-340).

    Parameters
    ----------
    P, n
        As of `predict`.
    measure : function
        Applies H to a state column and returns a `Vec3`.
    variances : three scalars
        Diagonal of R.
    considered : collection of int
        States that are not estimated.
    """

    def project(j: int) -> list[Any]:
        """Row j of P Hᵀ."""
        return list(measure([P[i, j] for i in range(n)]))

    PHt = {j: project(j) for j in looked_at(n, measure)}
    L, gated = innovation(PHt, n, measure, variances, gate)
    G: list[list[Any]] = []
    # Three rows of P at a time: an entry of G is then loaded once for three products. Rows below
    # are still as they were when P Hᵀ is taken from them.
    for first in range(0, n, 3):
        for j in range(first, first + 3):
            G.append(gain(PHt.get(j) or project(j), L, gated))
        for j in range(first + 3):
            for i in range(max(first, j), first + 3):
                if i in considered and j in considered:
                    continue
                P[i, j] = reduce(lambda left, r: left - G[i][r] * G[j][r], range(3), P[i, j])


def looked_at(n: int, measure: Callable[[Sequence[Any]], Vec3]) -> list[int]:
    """States that H looks at."""
    units = enumerate(np.eye(n).tolist())
    return [j for j, unit in units if any(y != 0.0 for y in measure(unit))]


def innovation(
    PHt: Mapping[int, Sequence[Any]],
    n: int,
    measure: Callable[[Sequence[Any]], Vec3],
    variances: Sequence[Any],
    gate: Any,
) -> tuple[Factor, list[Any]]:
    """`factor` of R + H P Hᵀ, the inverse times a gate; of P Hᵀ, only the rows that H looks at."""
    columns = [list(measure([PHt[j][r] if j in PHt else 0.0 for j in range(n)])) for r in range(3)]
    L, inverse = factor(columns, variances)
    return L, [value * gate for value in inverse]


def factor(columns: Sequence[Sequence[Any]], variances: Sequence[Any]) -> tuple[Factor, list[Any]]:
    """L of R + H P Hᵀ = L Lᵀ below its diagonal, and the inverse of that.

    `columns` are those of H P Hᵀ, `variances` the diagonal of R.
    """
    L: Factor = {}
    inverse: list[Any] = []
    for j in range(3):
        pivot = columns[j][j] + variances[j] - sum(L[j, k] * L[j, k] for k in range(j))
        inverse.append(1.0 / np.sqrt(pivot))
        for i in range(j + 1, 3):
            L[i, j] = (columns[j][i] - sum(L[i, k] * L[j, k] for k in range(j))) * inverse[j]
    return L, inverse


def gain(row: Sequence[Any], L: Factor, inverse: Sequence[Any]) -> list[Any]:
    """A row of G = P Hᵀ L⁻ᵀ from that of P Hᵀ."""
    g: list[Any] = []
    for r in range(3):
        g.append((row[r] - sum(g[k] * L[r, k] for k in range(r))) * inverse[r])
    return g


def last_pivot(P: Any, n: int) -> Any:
    """Last pivot of P = L Lᵀ, which is no positive number unless P is positive definite.

    It is so by arithmetic alone: the root of a negative pivot is NaN, and spoils the ones after it.
    """
    L: dict[tuple[int, int], Any] = {}
    pivot: Any = 1.0
    for j in range(n):
        pivot = np.sqrt(reduce(lambda value, k: value - L[j, k] * L[j, k], range(j), P[j, j]))
        inverse = 1.0 / pivot
        for i in range(j + 1, n):
            value = reduce(lambda value, k: value - L[i, k] * L[j, k], range(j), P[i, j])
            L[i, j] = value * inverse
    return pivot
