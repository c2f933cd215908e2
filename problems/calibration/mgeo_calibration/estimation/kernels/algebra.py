"""What several of the compiled loops need of linear algebra."""

import math

from numba import njit

#: Functions that are compiled into those that call them.
helper = njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
#: Its sums may be taken in another order.
reordered = njit(error_model="numpy", fastmath={"reassoc", "contract", "nsz"})

#: Rows that are reflected at once, a multiple of three.
TOGETHER = 96
#: Squares below this are what rounding leaves of rounding, and their reciprocals not finite.
NOTHING = 1e-200


@reordered
def tile(A, i, B, j, low, high):
    """Three rows of A times three of B, of columns low to high - 1: the nine sums, row by row."""
    a = b = c = d = e = f = g = h = o = 0.0
    for m in range(low, high):
        x, y, z, u, v, w = A[i, m], A[i + 1, m], A[i + 2, m], B[j, m], B[j + 1, m], B[j + 2, m]
        a, b, c = a + x * u, b + x * v, c + x * w
        d, e, f = d + y * u, e + y * v, f + y * w
        g, h, o = g + z * u, h + z * v, o + z * w
    return (a, b, c), (d, e, f), (g, h, o)


@helper
def cholesky(A, n):
    """L of the leading n rows and columns A = L Lᵀ, in the place of their lower triangle."""
    for j in range(n):
        for m in range(j):
            for i in range(j, n):
                A[i, j] -= A[i, m] * A[j, m]
        root = 1.0 / math.sqrt(A[j, j])
        for i in range(j, n):
            A[i, j] *= root


@helper
def square(L, y, n):
    """|L⁻¹ y|² of a triangle; y ← L⁻¹ y."""
    total = 0.0
    for i in range(n):
        for j in range(i):
            y[i] -= L[i, j] * y[j]
        y[i] /= L[i, i]
        total += y[i] * y[i]
    return total


@reordered
def reflect(A, R, room):
    """Rows of equations, columns of A, into the triangle R by Householder's reflections.

    The sums go along many rows, of which the processor takes several at once. First all reflections
    are found, then each goes over the other columns, which so are fetched once. A is what remains;
    room has two numbers of each reflection.
    """
    q, columns, rows = len(R), len(A), A.shape[1]
    for j in range(q):
        tail = 0.0
        for i in range(rows):
            tail += A[j, i] * A[j, i]
        room[j, 1] = 0.0
        if tail < NOTHING:
            continue
        length = math.copysign(math.sqrt(R[j, j] * R[j, j] + tail), R[j, j])
        room[j, 0] = R[j, j] + length
        room[j, 1] = 1.0 / (length * room[j, 0])
        R[j, j] = -length
        for m in range(j + 1, q):
            over(A, R, room, j, m)
    for m in range(q, columns):
        for j in range(q):
            if room[j, 1] != 0.0:
                over(A, R, room, j, m)


@reordered
def over(A, R, room, j, m):
    """A reflection over a column."""
    rows, first = A.shape[1], room[j, 0]
    total = first * R[j, m]
    for i in range(rows):
        total += A[j, i] * A[m, i]
    f = room[j, 1] * total
    R[j, m] -= f * first
    for i in range(rows):
        A[m, i] -= f * A[j, i]


@reordered
def square_up(A, q, gram):
    """Add products of all but the first q columns of equations, the rows of A, to a triangle."""
    n, rows = len(A) - q, A.shape[1]
    whole = n - n % 3
    for j in range(0, whole, 3):
        for m in range(j, whole, 3):
            sums = tile(A, q + j, A, q + m, 0, rows)
            for a in range(3):
                for b in range(a if m == j else 0, 3):
                    gram[j + a, m + b] += sums[a][b]
    for m in range(whole, n):
        for j in range(m + 1):
            total = 0.0
            for i in range(rows):
                total += A[q + j, i] * A[q + m, i]
            gram[j, m] += total
