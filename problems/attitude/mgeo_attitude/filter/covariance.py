"""One predict, one update and the last pivot of the covariance, as code with loops.

Each writes lines of the generated kernel (`symbols.py`) that work in place on a `Triangle`, the
lower triangle of P, and its scratch. F and H are never formed: a sensor's `measure` is applied to
the columns of P, and F is a sparse table. Loops go over blocks of three states: straight-line code
of a large suite is many times as long as the instruction cache. Where a loop's body stores what it
has loaded before, the loads come first: the compiler cannot know that they are of other slots.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import reduce
from operator import mul
from typing import Any

import numpy as np

from mgeo_attitude.filter.symbols import Index, Symbol, Triangle, slots_of

_BLOCK = range(3)

#: Entries of a sparse matrix by (row, column).
Sparse = Mapping[tuple[int, int], Any]
Factor = dict[tuple[int, int], Any]
#: Applies H to a column.
Measure = Callable[[Sequence[Any]], Sequence[Any]]
#: Three rows of G, loaded once.
Rows = list[list[Symbol]]


def predict(P: Triangle, n: int, F: Sparse, Q: Sparse) -> None:
    """P ← F P Fᵀ + Q, equation (3).

    Rows that F leaves out are rows of the identity, and without noise: those states are constant.
    Rows past all those that others refer to come in threes, and are diagonal in F and Q.

    Parameters
    ----------
    n : int
        Number of states.
    F, Q : sparse matrices
        Transition, and the lower triangle of the process noise.
    """
    rows: dict[int, list[int]] = {}
    for i, k in F:
        rows.setdefault(i, []).append(k)
    corner = 1 + max(k for i in rows for k in rows[i] if rows[i] != [i])
    _mix(P, corner, rows, F, Q)
    _mix_below(P, corner, n, rows, F)
    for block in (i for i in rows if i >= corner and (i - corner) % 3 == 0):
        _scale(P, block, n, F, Q)


def _mix(P: Triangle, corner: int, rows: Mapping[int, list[int]], F: Sparse, Q: Sparse) -> None:
    """Predict the states that others depend on, of each other; rows that are sums first."""
    code, wide = P.code, [i for i in rows if rows[i] != [i]]

    def FP(i: int, j: int | Index) -> str:
        return f"{len(wide)} * ({j}) + {P.scratch + wide.index(i)}"

    with code.loop(0, corner) as column:
        for i, value in [(i, sum(F[i, k] * P[k, column] for k in rows[i])) for i in wide]:
            code.store(FP(i, column), value)
    for i in range(corner):
        for j in range(i + 1):
            noise = Q.get((i, j), 0.0) if i in rows and j in rows else 0.0
            a, b = (i, j) if i in wide else (j, i)
            if a in wide and b in rows:
                P[i, j] = sum((code.slot(FP(a, k)) * F[b, k] for k in rows[b]), noise)
            elif a in wide:
                P[i, j] = code.slot(FP(a, b))
            elif a in rows or b in rows:
                factors = [F[k, k] for k in (a, b) if k in rows]
                P[i, j] = reduce(mul, factors, P[i, j]) + noise


def _mix_below(P: Triangle, corner: int, n: int, rows: Mapping[int, list[int]], F: Sparse) -> None:
    """Predict their columns in the rows of all others.

    Three rows at a time: an entry of F is then loaded once for three products.
    """
    with P.code.loop(corner, n, 3) as i:
        values: dict[tuple[int, int], Any] = {}
        for j in (j for j in rows if j < corner):
            for k in rows[j]:
                for a in _BLOCK:
                    values[a, j] = values.get((a, j), 0.0) + F[j, k] * P[i + a, k]
        for (a, j), value in values.items():
            P[i + a, j] = value


def _scale(P: Triangle, block: int, n: int, F: Sparse, Q: Sparse) -> None:
    """Predict rows and columns of states whose rows of F are a diagonal's."""
    states = range(block, block + 3)
    with P.code.loop(0, block) as column:
        for i in states:
            P[i, column] = P[i, column] * F[i, i]
    for i in states:
        for j in range(block, i + 1):
            P[i, j] = P[i, j] * F[i, i] * F[j, j] + Q.get((i, j), 0.0)
    with P.code.loop(block + 3, n) as row:
        for j in states:
            P[row, j] = P[row, j] * F[j, j]


def update(
    P: Triangle,
    n: int,
    measure: Measure,
    variances: Sequence[Any],
    gate: Any = 1.0,
    considered: Collection[int] = (),
) -> None:
    """P ← P - K H P with K = P Hᵀ (R + H P Hᵀ)⁻¹, equation (4), up to three rows together.

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
        Applies H to a state column.
    variances : sequence of scalars
        Diagonal of R.
    considered : collection of int
        States that are not estimated, in whole blocks of three.
    """
    code, support, m = P.code, looked_at(n, measure), len(variances)

    # P Hᵀ. Of a state that H looks at, row or column of the triangle is what is needed: one up to
    # that state's block, the other past it.
    first = 0
    for last in (*sorted({j - j % 3 + 3 for j in support}), n):
        if first < last:
            with code.loop(first, last) as state:
                projected = measure([P[i, state] for i in range(n)])
                for r, value in enumerate(projected):
                    code.store(_entry(P, state, r), value)
        first = last

    L, gated = innovation({j: _row(P, j, m) for j in support}, n, measure, variances, gate)
    with code.loop(0, n) as state:
        for r, value in enumerate(gain(_row(P, state, m), L, gated)):
            code.store(_entry(P, state, r), value)

    def G(i: int | Index) -> Rows:
        return [[code.line(each.name) for each in _row(P, i + a, m)] for a in _BLOCK]

    held = sorted({i - i % 3 for i in considered})
    for first, last in _gaps(held, n):
        _take(P, G, first, last, 0)
    for block in held:
        left = G(block)
        for first, last in _gaps([j for j in held if j < block], block):
            with code.loop(first, last, 3) as j:
                _take_block(P, (block, left), (j, G(j)))


def looked_at(n: int, measure: Measure) -> list[int]:
    """States that H looks at."""
    units = enumerate(np.eye(n).tolist())
    return [j for j, unit in units if any(y != 0.0 for y in measure(unit))]


def innovation(
    PHt: Mapping[int, Sequence[Any]],
    n: int,
    measure: Measure,
    variances: Sequence[Any],
    gate: Any,
) -> tuple[Factor, list[Any]]:
    """`factor` of R + H P Hᵀ, the inverse times a gate; of P Hᵀ, only the rows that H looks at."""
    columns = [
        list(measure([PHt[j][r] if j in PHt else 0.0 for j in range(n)]))
        for r in range(len(variances))
    ]
    L, inverse = factor(columns, variances)
    return L, [value * gate for value in inverse]


def factor(columns: Sequence[Sequence[Any]], variances: Sequence[Any]) -> tuple[Factor, list[Any]]:
    """L of R + H P Hᵀ = L Lᵀ below its diagonal, and the inverse of that.

    `columns` are those of H P Hᵀ, `variances` the diagonal of R.
    """
    L: Factor = {}
    inverse: list[Any] = []
    for j in range(len(variances)):
        pivot = columns[j][j] + variances[j] - sum(L[j, k] * L[j, k] for k in range(j))
        inverse.append(1.0 / np.sqrt(pivot))
        for i in range(j + 1, len(variances)):
            L[i, j] = (columns[j][i] - sum(L[i, k] * L[j, k] for k in range(j))) * inverse[j]
    return L, inverse


def gain(row: Sequence[Any], L: Factor, inverse: Sequence[Any]) -> list[Any]:
    """A row of G = P Hᵀ L⁻ᵀ from that of P Hᵀ."""
    g: list[Any] = []
    for r in range(len(inverse)):
        g.append((row[r] - sum(g[k] * L[r, k] for k in range(r))) * inverse[r])
    return g


def last_pivot(P: Triangle, n: int) -> Any:
    """Last pivot of P = L Lᵀ, which is no positive number unless P is positive definite.

    It is so by arithmetic alone: the root of a negative pivot is NaN, and spoils the ones after it.
    Three columns at a time, on a copy of P.
    """
    code, A = P.code, Triangle(P.code, first=P.scratch)

    def pivots(j: int | Index) -> tuple[Factor, list[Any]]:
        columns = [[A.below(j + max(a, b), j + min(a, b)) for a in _BLOCK] for b in _BLOCK]
        return factor(columns, [0.0, 0.0, 0.0])

    with code.loop(0, slots_of(n)) as k:
        code.store(f"{k} + {P.scratch}", code.slot(str(k)))
    with code.loop(0, n - 3, 3) as j:
        L, inverse = pivots(j)
        with code.loop(j + 3, n) as i:
            row = [A.below(i, j + r) for r in _BLOCK]
            for slot, value in zip(row, gain(row, L, inverse), strict=True):
                code.assign(slot, value)

        def columns(i: int | Index, j: Index = j) -> Rows:
            return [[code.line(A.below(i + a, j + r).name) for r in _BLOCK] for a in _BLOCK]

        _take(A, columns, j + 3, n, j + 3)
    _, inverse = pivots(n - 3)
    return 1.0 / inverse[2]


def _take(
    P: Triangle,
    G: Callable[[int | Index], Rows],
    first: int | Index,
    last: int,
    start: int | Index,
) -> None:
    """Take G Gᵀ from the rows `first` to `last`, columns from `start` on."""
    with P.code.loop(first, last, 3) as i:
        left = G(i)
        with P.code.loop(start, i, 3) as j:
            _take_block(P, (i, left), (j, G(j)))
        _take_block(P, (i, left), (i, left))


def _take_block(
    P: Triangle, left: tuple[int | Index, Rows], right: tuple[int | Index, Rows]
) -> None:
    """Take G Gᵀ from a block of P, on or below the diagonal."""
    (i, G), (j, other) = left, right
    for a in _BLOCK:
        for b in range(a + 1) if i is j else _BLOCK:
            entry: Any = P.below(i + a, j + b)
            value = reduce(lambda x, r: x - G[a][r] * other[b][r], range(len(G[a])), entry)
            P.code.assign(entry, value)


def _gaps(taken: Sequence[int], end: int) -> Iterator[tuple[int, int]]:
    """Ranges of states before `end` that are in none of the blocks."""
    starts, ends = [0, *(block + 3 for block in taken)], [*taken, end]
    return ((a, b) for a, b in zip(starts, ends, strict=True) if a < b)


def _entry(P: Triangle, i: int | Index, r: int) -> str:
    """Slot of an entry of P Hᵀ, later of G."""
    return f"3 * ({i}) + {P.scratch + r}"


def _row(P: Triangle, i: int | Index, m: int) -> list[Symbol]:
    return [P.code.slot(_entry(P, i, r)) for r in range(m)]
