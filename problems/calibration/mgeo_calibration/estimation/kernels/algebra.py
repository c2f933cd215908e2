"""Linear algebra shared by the compiled loops."""

import math

from numba import njit

#: Decorator of functions that are compiled into their callers.
helper = njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
#: Decorator of functions in which the compiler may reorder sums.
reorderable = njit(error_model="numpy", fastmath={"reassoc", "contract", "nsz"})

#: Number of rows in one Householder update, a multiple of three.
BLOCK_LENGTH = 96
#: Squared norms below this are rounding errors, and their reciprocals may overflow.
MIN_SQUARED_NORM = 1e-200


@reorderable
def compute_dot_products(A, i, B, j, low, high):
    """Return all nine dot products between three rows of A, starting at row i, and three rows of B,
    starting at row j. Only the columns `low` to `high` - 1 are used.
    """
    a = b = c = d = e = f = g = h = o = 0.0
    for m in range(low, high):
        x, y, z, u, v, w = A[i, m], A[i + 1, m], A[i + 2, m], B[j, m], B[j + 1, m], B[j + 2, m]
        a, b, c = a + x * u, b + x * v, c + x * w
        d, e, f = d + y * u, e + y * v, f + y * w
        g, h, o = g + z * u, h + z * v, o + z * w
    return (a, b, c), (d, e, f), (g, h, o)


@helper
def factor_cholesky(A, n):
    """Replace the lower triangle of the leading n x n block of A with its Cholesky factor."""
    for j in range(n):
        for m in range(j):
            for i in range(j, n):
                A[i, j] -= A[i, m] * A[j, m]
        root = 1.0 / math.sqrt(A[j, j])
        for i in range(j, n):
            A[i, j] *= root


@helper
def solve_squared_norm(L, y, n):
    """Solve L x = y for a lower triangular matrix L, overwrite y with x, and return |x|²."""
    total = 0.0
    for i in range(n):
        for j in range(i):
            y[i] -= L[i, j] * y[j]
        y[i] /= L[i, i]
        total += y[i] * y[i]
    return total


@reorderable
def reduce_equations(A, R, workspace):
    """Add equations to a triangular least-squares system R in place, using Householder reflections.

    A contains the new equations, one equation per column and one unknown per row, so that the inner
    loops vectorize over the equations. All reflections are computed first and then applied to the
    remaining rows of A, which are read from memory once. A is overwritten by the residual
    equations; `workspace` holds two numbers per reflection.
    """
    q, columns, rows = len(R), len(A), A.shape[1]
    for j in range(q):
        tail = 0.0
        for i in range(rows):
            tail += A[j, i] * A[j, i]
        workspace[j, 1] = 0.0
        if tail < MIN_SQUARED_NORM:
            continue
        length = math.copysign(math.sqrt(R[j, j] * R[j, j] + tail), R[j, j])
        workspace[j, 0] = R[j, j] + length
        workspace[j, 1] = 1.0 / (length * workspace[j, 0])
        R[j, j] = -length
        for m in range(j + 1, q):
            apply_reflection(A, R, workspace, j, m)
    for m in range(q, columns):
        for j in range(q):
            if workspace[j, 1] != 0.0:
                apply_reflection(A, R, workspace, j, m)


@reorderable
def apply_reflection(A, R, workspace, j, m):
    rows, first = A.shape[1], workspace[j, 0]
    total = first * R[j, m]
    for i in range(rows):
        total += A[j, i] * A[m, i]
    f = workspace[j, 1] * total
    R[j, m] -= f * first
    for i in range(rows):
        A[m, i] -= f * A[j, i]


@reorderable
def accumulate_gram(A, q, gram):
    """Add the Gram matrix of all rows of A after the first q to the upper triangle of `gram`."""
    n, rows = len(A) - q, A.shape[1]
    n_blocked = n - n % 3
    for j in range(0, n_blocked, 3):
        for m in range(j, n_blocked, 3):
            sums = compute_dot_products(A, q + j, A, q + m, 0, rows)
            for a in range(3):
                for b in range(a if m == j else 0, 3):
                    gram[j + a, m + b] += sums[a][b]
    for m in range(n_blocked, n):
        for j in range(m + 1):
            total = 0.0
            for i in range(rows):
                total += A[q + j, i] * A[q + m, i]
            gram[j, m] += total
