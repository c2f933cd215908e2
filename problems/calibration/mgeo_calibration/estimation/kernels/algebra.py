"""What several of the compiled loops need of linear algebra."""

import math

from numba import njit

#: Functions that are compiled into those that call them.
helper = njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)


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
