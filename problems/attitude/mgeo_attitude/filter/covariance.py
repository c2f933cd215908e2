"""Prediction, update and last Cholesky pivot of the covariance, as generated code with loops.

Each function writes lines of the kernel (`symbols.py`) that work in place on a `Triangle`, the
lower triangle of P, and on its scratch space. F and H are never formed: F is a sparse table, and H
is a `measure` function that is applied to the columns of P. Loops run over blocks of three states,
because straight-line code of a large suite exceeds the instruction cache many times. A loop body
loads its values before it stores any, since the compiler cannot prove that the slots differ.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import reduce
from operator import mul
from typing import Any

import numpy as np

from mgeo_attitude.filter.symbols import Index, Symbol, Triangle, count_slots

_BLOCK = range(3)

#: Entries of a sparse matrix by (row, column).
SparseMatrix = Mapping[tuple[int, int], Any]
Factor = dict[tuple[int, int], Any]
#: Function that applies H to a column.
MeasureFunction = Callable[[Sequence[Any]], Sequence[Any]]
#: Three rows of G, loaded once.
Rows = list[list[Symbol]]


def predict(P: Triangle, n: int, F: SparseMatrix, Q: SparseMatrix) -> None:
    """Write the prediction P ← F P Fᵀ + Q, equation (3).

    A row that is missing in F is a row of the identity without process noise: the state is
    constant. Rows after the last state that other states depend on must come in blocks of three,
    diagonal in F and in Q.

    Parameters
    ----------
    P : Triangle
        Covariance, changed in place.
    n : int
        Number of states.
    F, Q : mapping of (row, column) to scalar
        Transition, and the lower triangle of the process noise.
    """
    rows: dict[int, list[int]] = {}
    for i, k in F:
        rows.setdefault(i, []).append(k)
    corner = 1 + max(k for i in rows for k in rows[i] if rows[i] != [i])
    _predict_coupled(P, corner, rows, F, Q)
    _predict_below(P, corner, n, rows, F)
    for block in (i for i in rows if i >= corner and (i - corner) % 3 == 0):
        _predict_diagonal(P, block, n, F, Q)


def _predict_coupled(
    P: Triangle, corner: int, rows: Mapping[int, list[int]], F: SparseMatrix, Q: SparseMatrix
) -> None:
    """Predict the leading `corner` states, which other states depend on; coupled rows first."""
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


def _predict_below(
    P: Triangle, corner: int, n: int, rows: Mapping[int, list[int]], F: SparseMatrix
) -> None:
    """Predict the columns of the leading `corner` states in all rows below.

    Three rows are processed together, so that an entry of F is loaded once for three products.
    """
    with P.code.loop(corner, n, 3) as i:
        values: dict[tuple[int, int], Any] = {}
        for j in (j for j in rows if j < corner):
            for k in rows[j]:
                for a in _BLOCK:
                    values[a, j] = values.get((a, j), 0.0) + F[j, k] * P[i + a, k]
        for (a, j), value in values.items():
            P[i + a, j] = value


def _predict_diagonal(P: Triangle, block: int, n: int, F: SparseMatrix, Q: SparseMatrix) -> None:
    """Predict rows and columns of a block of three states whose rows of F are diagonal."""
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
    measure: MeasureFunction,
    variances: Sequence[Any],
    gate: Any = 1.0,
    considered: Collection[int] = (),
) -> None:
    """Write the measurement update P ← P - K H P, K = P Hᵀ (R + H P Hᵀ)⁻¹, equation (4).

    Up to three measurement rows are processed together. With R + H P Hᵀ = L Lᵀ and G = P Hᵀ L⁻ᵀ the
    update is P ← P - G Gᵀ, equation (8).

    States in `considered` have zero gain: G Gᵀ is subtracted except where both states are
    considered. With K = [K₁; 0] and the optimal gain K₁ of the estimated states this equals
    Joseph's form, (I - K H) P (I - K H)ᵀ + K R Kᵀ (S. F. Schmidt, Application of State-Space
    Methods to Navigation Problems, Advances in Control Systems 3 (1966) 293-340).

    Parameters
    ----------
    P : Triangle
        Covariance, changed in place.
    n : int
        Number of states.
    measure : function
        Applies H to a state column.
    variances : sequence of scalars
        Diagonal of R.
    gate : scalar
        1 to update; 0 to leave P unchanged, for a sensor that is not available.
    considered : collection of int
        States that are not estimated, in whole blocks of three.
    """
    code, support, m = P.code, list_measured_states(n, measure), len(variances)

    # P Hᵀ. A symmetric entry is in a row of the triangle up to the block of a measured state and
    # in a column past the block, so the loop is split there.
    first = 0
    for last in (*sorted({j - j % 3 + 3 for j in support}), n):
        if first < last:
            with code.loop(first, last) as state:
                projected = measure([P[i, state] for i in range(n)])
                for r, value in enumerate(projected):
                    code.store(_format_slot(P, state, r), value)
        first = last

    L, gated = factor_innovation(
        {j: _list_row_slots(P, j, m) for j in support}, n, measure, variances, gate
    )
    with code.loop(0, n) as state:
        for r, value in enumerate(compute_gain_row(_list_row_slots(P, state, m), L, gated)):
            code.store(_format_slot(P, state, r), value)

    def G(i: int | Index) -> Rows:
        return [[code.define(each.name) for each in _list_row_slots(P, i + a, m)] for a in _BLOCK]

    considered_blocks = sorted({i - i % 3 for i in considered})
    for first, last in _iterate_gaps(considered_blocks, n):
        _subtract(P, G, first, last, 0)
    for block in considered_blocks:
        block_gain = G(block)
        for first, last in _iterate_gaps([j for j in considered_blocks if j < block], block):
            with code.loop(first, last, 3) as j:
                _subtract_block(P, (block, block_gain), (j, G(j)))


def list_measured_states(n: int, measure: MeasureFunction) -> list[int]:
    """Return the states with a nonzero column in H."""
    units = enumerate(np.eye(n).tolist())
    return [j for j, unit in units if any(y != 0.0 for y in measure(unit))]


def factor_innovation(
    PHt: Mapping[int, Sequence[Any]],
    n: int,
    measure: MeasureFunction,
    variances: Sequence[Any],
    gate: Any,
) -> tuple[Factor, list[Any]]:
    """Return L of R + H P Hᵀ = L Lᵀ, and the inverse diagonal of L times `gate`; see `factor`.

    Parameters
    ----------
    PHt : mapping of int to sequence
        Rows of P Hᵀ for the states with a nonzero column in H.
    n, measure, variances, gate
        See `update`.
    """
    columns = [
        list(measure([PHt[j][r] if j in PHt else 0.0 for j in range(n)]))
        for r in range(len(variances))
    ]
    L, inverse = factor_cholesky(columns, variances)
    return L, [value * gate for value in inverse]


def factor_cholesky(
    columns: Sequence[Sequence[Any]], variances: Sequence[Any]
) -> tuple[Factor, list[Any]]:
    """Return the Cholesky factor L of R + H P Hᵀ below the diagonal, and its inverse diagonal.

    Parameters
    ----------
    columns : sequence of sequences
        Columns of H P Hᵀ.
    variances : sequence of scalars
        Diagonal of R.
    """
    L: Factor = {}
    inverse: list[Any] = []
    for j in range(len(variances)):
        pivot = columns[j][j] + variances[j] - sum(L[j, k] * L[j, k] for k in range(j))
        inverse.append(1.0 / np.sqrt(pivot))
        for i in range(j + 1, len(variances)):
            L[i, j] = (columns[j][i] - sum(L[i, k] * L[j, k] for k in range(j))) * inverse[j]
    return L, inverse


def compute_gain_row(row: Sequence[Any], L: Factor, inverse: Sequence[Any]) -> list[Any]:
    """Return a row of G = P Hᵀ L⁻ᵀ from a row of P Hᵀ and the factors of `factor`."""
    g: list[Any] = []
    for r in range(len(inverse)):
        g.append((row[r] - sum(g[k] * L[r, k] for k in range(r))) * inverse[r])
    return g


def compute_last_pivot(P: Triangle, n: int) -> Any:
    """Return the last pivot of P = L Lᵀ, which is positive only if P is positive definite.

    No branch is needed: the root of a negative pivot is NaN, and NaN propagates to all later
    pivots. The factorization runs on a copy of P, three columns at a time.
    """
    code, A = P.code, Triangle(P.code, first=P.scratch)

    def pivots(j: int | Index) -> tuple[Factor, list[Any]]:
        columns = [[A.lower_entry(j + max(a, b), j + min(a, b)) for a in _BLOCK] for b in _BLOCK]
        return factor_cholesky(columns, [0.0, 0.0, 0.0])

    with code.loop(0, count_slots(n)) as k:
        code.store(f"{k} + {P.scratch}", code.slot(str(k)))
    with code.loop(0, n - 3, 3) as j:
        L, inverse = pivots(j)
        with code.loop(j + 3, n) as i:
            row = [A.lower_entry(i, j + r) for r in _BLOCK]
            for slot, value in zip(row, compute_gain_row(row, L, inverse), strict=True):
                code.assign(slot, value)

        def columns(i: int | Index, j: Index = j) -> Rows:
            return [[code.define(A.lower_entry(i + a, j + r).name) for r in _BLOCK] for a in _BLOCK]

        _subtract(A, columns, j + 3, n, j + 3)
    _, inverse = pivots(n - 3)
    return 1.0 / inverse[2]


def _subtract(
    P: Triangle,
    G: Callable[[int | Index], Rows],
    first: int | Index,
    last: int,
    start: int | Index,
) -> None:
    """Subtract G Gᵀ from the rows `first` to `last` of P, from column `start` on."""
    with P.code.loop(first, last, 3) as i:
        row_gain = G(i)
        with P.code.loop(start, i, 3) as j:
            _subtract_block(P, (i, row_gain), (j, G(j)))
        _subtract_block(P, (i, row_gain), (i, row_gain))


def _subtract_block(
    P: Triangle, left: tuple[int | Index, Rows], right: tuple[int | Index, Rows]
) -> None:
    """Subtract G Gᵀ from a 3 x 3 block of P, on or below the diagonal."""
    (i, G), (j, other) = left, right
    for a in _BLOCK:
        for b in range(a + 1) if i is j else _BLOCK:
            entry: Any = P.lower_entry(i + a, j + b)
            value = reduce(lambda x, r: x - G[a][r] * other[b][r], range(len(G[a])), entry)
            P.code.assign(entry, value)


def _iterate_gaps(blocks: Sequence[int], end: int) -> Iterator[tuple[int, int]]:
    """Yield the ranges of states before `end` that none of the blocks of three covers."""
    starts, ends = [0, *(block + 3 for block in blocks)], [*blocks, end]
    return ((a, b) for a, b in zip(starts, ends, strict=True) if a < b)


def _format_slot(P: Triangle, i: int | Index, r: int) -> str:
    """Return the slot of entry (i, r) of P Hᵀ, which later holds G."""
    return f"3 * ({i}) + {P.scratch + r}"


def _list_row_slots(P: Triangle, i: int | Index, m: int) -> list[Symbol]:
    return [P.code.slot(_format_slot(P, i, r)) for r in range(m)]
