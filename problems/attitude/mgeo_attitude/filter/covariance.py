"""Code generation for the time update and the measurement update of the covariance.

Each function writes code (`symbols.py`) that changes a `Triangle` in place: the lower triangle of
the covariance P, followed by scratch space. The matrices F and H are never formed. F is a dict of
its nonzero entries, and H is a function `measure` that is applied to the columns of P. Loops run
over blocks of three states, because straight-line code for a large suite exceeds the instruction
cache many times. A loop body loads its values before it stores any value, since the compiler cannot
prove that the slots differ.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import reduce
from operator import mul
from typing import Any

import numpy as np

from mgeo_attitude.filter.symbols import Index, Symbol, Triangle, count_slots

_BLOCK = range(3)

#: Nonzero entries of a matrix by (row, column).
SparseMatrix = Mapping[tuple[int, int], Any]
Factor = dict[tuple[int, int], Any]
#: Function that multiplies the measurement matrix H by a state column.
MeasureFunction = Callable[[Sequence[Any]], Sequence[Any]]
#: Three rows of the scaled gain G, loaded once.
Rows = list[list[Symbol]]


def predict(P: Triangle, n: int, F: SparseMatrix, Q: SparseMatrix) -> None:
    """Generate code for the time update of the covariance.

    The update is P ← F P Fᵀ + Q, equation (3) of docs/explanation/models-and-filter.md. A row that
    is missing in F is a row of the identity matrix without process noise, for a constant state. The
    states after the last state on which other states depend must form blocks of three, and F and Q
    must be diagonal there.

    Parameters
    ----------
    P : Triangle
        Covariance, changed in place.
    n : int
        Number of states.
    F, Q : mapping of (row, column) to scalar
        Entries of the transition matrix, and of the lower triangle of the process noise.
    """
    rows: dict[int, list[int]] = {}
    for i, k in F:
        rows.setdefault(i, []).append(k)
    n_coupled = 1 + max(k for i in rows for k in rows[i] if rows[i] != [i])
    _predict_coupled(P, n_coupled, rows, F, Q)
    _predict_cross_covariance(P, n_coupled, n, rows, F)
    for block in (i for i in rows if i >= n_coupled and (i - n_coupled) % 3 == 0):
        _predict_diagonal(P, block, n, F, Q)


def _predict_coupled(
    P: Triangle, n_coupled: int, rows: Mapping[int, list[int]], F: SparseMatrix, Q: SparseMatrix
) -> None:
    """Generate code for the time update of the covariance of the first `n_coupled` states.

    Later states do not affect any other state.
    """
    code, coupled_rows = P.code, [i for i in rows if rows[i] != [i]]

    def format_product_slot(i: int, j: int | Index) -> str:
        return f"{len(coupled_rows)} * ({j}) + {P.scratch + coupled_rows.index(i)}"

    with code.loop(0, n_coupled) as column:
        for i, value in [(i, sum(F[i, k] * P[k, column] for k in rows[i])) for i in coupled_rows]:
            code.store(format_product_slot(i, column), value)
    for i in range(n_coupled):
        for j in range(i + 1):
            noise = Q.get((i, j), 0.0) if i in rows and j in rows else 0.0
            a, b = (i, j) if i in coupled_rows else (j, i)
            if a in coupled_rows and b in rows:
                P[i, j] = sum(
                    (code.slot(format_product_slot(a, k)) * F[b, k] for k in rows[b]), noise
                )
            elif a in coupled_rows:
                P[i, j] = code.slot(format_product_slot(a, b))
            elif a in rows or b in rows:
                factors = [F[k, k] for k in (a, b) if k in rows]
                P[i, j] = reduce(mul, factors, P[i, j]) + noise


def _predict_cross_covariance(
    P: Triangle, n_coupled: int, n: int, rows: Mapping[int, list[int]], F: SparseMatrix
) -> None:
    """Generate code for the time update of the covariance between the first `n_coupled` states and
    later states.

    Three rows are processed together, so that an entry of F is loaded once for three products.
    """
    with P.code.loop(n_coupled, n, 3) as i:
        values: dict[tuple[int, int], Any] = {}
        for j in (j for j in rows if j < n_coupled):
            for k in rows[j]:
                for a in _BLOCK:
                    values[a, j] = values.get((a, j), 0.0) + F[j, k] * P[i + a, k]
        for (a, j), value in values.items():
            P[i + a, j] = value


def _predict_diagonal(P: Triangle, block: int, n: int, F: SparseMatrix, Q: SparseMatrix) -> None:
    """Generate code for the time update of a block of three states with a diagonal transition
    matrix.

    The block starts at the index `block`.
    """
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
    """Generate code for the measurement update of the covariance with one sensor.

    The code computes P ← P - K H P with the gain K = P Hᵀ (R + H P Hᵀ)⁻¹, equation (4) of
    docs/explanation/models-and-filter.md. Up to three measurement rows are processed together. With
    R + H P Hᵀ = L Lᵀ and the scaled gain G = P Hᵀ L⁻ᵀ, the update is P ← P - G Gᵀ, equation (9).

    The states in `considered` have zero gain: G Gᵀ is not subtracted where both states are
    considered. With K = [K₁; 0] and the optimal gain K₁ of the estimated states, the result equals
    Joseph's form, (I - K H) P (I - K H)ᵀ + K R Kᵀ (S. F. Schmidt, Application of State-Space
    Methods to Navigation Problems, Advances in Control Systems 3 (1966) 293-340).

    Parameters
    ----------
    P : Triangle
        Covariance, changed in place.
    n : int
        Number of states.
    measure : function
        Multiplies H by a state column.
    variances : sequence of scalars
        Diagonal of R.
    gate : scalar
        1 to update; 0 to leave P unchanged, if the sensor cannot measure.
    considered : collection of int
        States that are not estimated, in whole blocks of three.
    """
    code, measured_states, n_rows = P.code, list_measured_states(n, measure), len(variances)

    # Compute P Hᵀ. Up to the block of a measured state, a symmetric entry of P is in a row of the
    # triangle, and after the block in a column. The loop is therefore split at the block.
    first = 0
    for last in (*sorted({j - j % 3 + 3 for j in measured_states}), n):
        if first < last:
            with code.loop(first, last) as state:
                projected = measure([P[i, state] for i in range(n)])
                for r, value in enumerate(projected):
                    code.store(_format_gain_slot(P, state, r), value)
        first = last

    L, gated_inverse = factor_innovation(
        {j: _list_row_slots(P, j, n_rows) for j in measured_states}, n, measure, variances, gate
    )
    with code.loop(0, n) as state:
        for r, value in enumerate(
            compute_gain_row(_list_row_slots(P, state, n_rows), L, gated_inverse)
        ):
            code.store(_format_gain_slot(P, state, r), value)

    def G(i: int | Index) -> Rows:
        return [
            [code.define(each.name) for each in _list_row_slots(P, i + a, n_rows)] for a in _BLOCK
        ]

    considered_blocks = sorted({i - i % 3 for i in considered})
    for first, last in _iterate_gaps(considered_blocks, n):
        _subtract(P, G, first, last, 0)
    for block in considered_blocks:
        block_gain = G(block)
        for first, last in _iterate_gaps([j for j in considered_blocks if j < block], block):
            with code.loop(first, last, 3) as j:
                _subtract_block(P, (block, block_gain), (j, G(j)))


def list_measured_states(n: int, measure: MeasureFunction) -> list[int]:
    """Return the indices of the states on which a measurement depends.

    These are the nonzero columns of the measurement matrix.
    """
    units = enumerate(np.eye(n).tolist())
    return [j for j, unit in units if any(y != 0.0 for y in measure(unit))]


def factor_innovation(
    PHt: Mapping[int, Sequence[Any]],
    n: int,
    measure: MeasureFunction,
    variances: Sequence[Any],
    gate: Any,
) -> tuple[Factor, list[Any]]:
    """Return the Cholesky factor of the innovation covariance R + H P Hᵀ.

    The factor consists of a dict of the entries below the diagonal and a list of the inverse
    diagonal entries. The inverse entries are multiplied by `gate`, which is 0 where the sensor
    cannot measure, so that the gain is then zero.

    Parameters
    ----------
    PHt : mapping of int to sequence
        Rows of P Hᵀ of the states with a nonzero column in H.
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
    """Return the Cholesky factor of the sum of a symmetric and a diagonal matrix.

    The factor consists of a dict of the entries below the diagonal, keyed by (row, column), and a
    list of the inverse diagonal entries.

    Parameters
    ----------
    columns : sequence of sequences
        Columns of the symmetric matrix, H P Hᵀ for an innovation covariance.
    variances : sequence of scalars
        Diagonal of the diagonal matrix, R for an innovation covariance.
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
    """Compute one row of the scaled gain G = P Hᵀ L⁻ᵀ by forward substitution.

    The argument `row` is the same row of P Hᵀ, and L is the Cholesky factor of the innovation
    covariance.
    """
    g: list[Any] = []
    for r in range(len(inverse)):
        g.append((row[r] - sum(g[k] * L[r, k] for k in range(r))) * inverse[r])
    return g


def compute_last_pivot(P: Triangle, n: int) -> Any:
    """Generate code for the last pivot of the Cholesky factorization of P, and return its symbol.

    The pivot is positive only if P is positive definite. No branch is needed, because the square
    root of a negative pivot is NaN and NaN propagates to all later pivots. The factorization uses a
    copy of P and processes three columns at a time.
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
    """Generate code that subtracts G Gᵀ from the covariance in the rows `first` to `last` - 1.

    In each row, the columns from `start` to the diagonal change.
    """
    with P.code.loop(first, last, 3) as i:
        row_gain = G(i)
        with P.code.loop(start, i, 3) as j:
            _subtract_block(P, (i, row_gain), (j, G(j)))
        _subtract_block(P, (i, row_gain), (i, row_gain))


def _subtract_block(
    P: Triangle, left: tuple[int | Index, Rows], right: tuple[int | Index, Rows]
) -> None:
    """Generate code that subtracts G Gᵀ from one 3 x 3 block of the covariance.

    The block is on or below the diagonal.
    """
    (i, G), (j, other) = left, right
    for a in _BLOCK:
        for b in range(a + 1) if i is j else _BLOCK:
            entry: Any = P.lower_entry(i + a, j + b)
            value = reduce(lambda x, r: x - G[a][r] * other[b][r], range(len(G[a])), entry)
            P.code.assign(entry, value)


def _iterate_gaps(blocks: Sequence[int], end: int) -> Iterator[tuple[int, int]]:
    """Yield the index ranges (start, stop) below `end` that lie between blocks of three states.

    The argument `blocks` contains the first index of each block, in increasing order.
    """
    starts, ends = [0, *(block + 3 for block in blocks)], [*blocks, end]
    return ((a, b) for a, b in zip(starts, ends, strict=True) if a < b)


def _format_gain_slot(P: Triangle, i: int | Index, r: int) -> str:
    """Return the source text of the workspace index that stores entry (i, r) of the matrix P Hᵀ.

    The index i is the state, and r is the component of the measurement. Entry (i, r) of the scaled
    gain G later overwrites the slot.
    """
    return f"3 * ({i}) + {P.scratch + r}"


def _list_row_slots(P: Triangle, i: int | Index, m: int) -> list[Symbol]:
    return [P.code.slot(_format_gain_slot(P, i, r)) for r in range(m)]
