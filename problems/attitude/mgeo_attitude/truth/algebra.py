"""Small matrices and rotations, compiled, for the simulation's loop.

Plain loops over arrays made beforehand: array expressions would take most of the compilation, and
an allocation as long as a product of 3 x 3 matrices.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(error_model="numpy", cache=True)
def multiply(A: Floats, B: Floats, out: Floats) -> None:
    """out ← A B."""
    for i in range(A.shape[0]):
        for j in range(B.shape[1]):
            total = 0.0
            for k in range(A.shape[1]):
                total += A[i, k] * B[k, j]
            out[i, j] = total


@njit(error_model="numpy", cache=True)
def copy(A: Floats, out: Floats) -> None:
    """out ← A."""
    for i in range(A.shape[0]):
        for j in range(A.shape[1]):
            out[i, j] = A[i, j]


@njit(error_model="numpy", cache=True)
def transform(C: Floats, v: Floats, out: Floats) -> None:
    """out ← C v."""
    for i in range(3):
        out[i] = C[i, 0] * v[0] + C[i, 1] * v[1] + C[i, 2] * v[2]


@njit(error_model="numpy", cache=True)
def turn_back(C: Floats, g: Floats, first: int, work: Floats) -> None:
    """C ← R(-g) C for the vector g at `first` of an array; see `rotation.rotate`."""
    x, y, z = -g[first], -g[first + 1], -g[first + 2]
    k = 1.0 / (1.0 + 0.25 * (x * x + y * y + z * z))
    for j in range(3):
        a, b, c = C[0, j], C[1, j], C[2, j]
        p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
        work[0, j] = a + k * (p + 0.5 * (y * r - z * q))
        work[1, j] = b + k * (q + 0.5 * (z * p - x * r))
        work[2, j] = c + k * (r + 0.5 * (x * q - y * p))
    copy(work, C)


@njit(error_model="numpy", cache=True)
def compose(sign: float, a: Floats, b: Floats, first: int, out: Floats) -> None:
    """The vector of R(±a) R(b), at `first` of each array."""
    x, y, z = sign * a[first], sign * a[first + 1], sign * a[first + 2]
    u, v, w = b[first], b[first + 1], b[first + 2]
    k = 1.0 / (1.0 - 0.25 * (x * u + y * v + z * w))
    out[first] = k * (x + u + 0.5 * (y * w - z * v))
    out[first + 1] = k * (y + v + 0.5 * (z * u - x * w))
    out[first + 2] = k * (z + w + 0.5 * (x * v - y * u))


@njit(error_model="numpy", cache=True)
def cholesky(A: Floats, L: Floats) -> None:
    """Lower L of A = L Lᵀ; not positive definite gives NaN."""
    for j in range(A.shape[0]):
        for i in range(j, A.shape[0]):
            value = A[i, j]
            for k in range(j):
                value -= L[i, k] * L[j, k]
            L[i, j] = np.sqrt(value) if i == j else value / L[j, j]


@njit(error_model="numpy", cache=True)
def forward(L: Floats, b: Floats, w: Floats) -> None:
    """Solve L w = b."""
    for i in range(len(b)):
        value = b[i]
        for k in range(i):
            value -= L[i, k] * w[k]
        w[i] = value / L[i, i]


@njit(error_model="numpy", cache=True)
def predict(P: Floats, F: Floats, Q: Floats, FP: Floats) -> None:
    """P ← F P Fᵀ + Q, equation (3); F and Q of the first states, FP work space."""
    m, n = FP.shape
    multiply(F, P[:m], FP)
    for i in range(m):
        for j in range(m, n):
            P[i, j] = FP[i, j]
            P[j, i] = FP[i, j]
        for j in range(i + 1):
            total = Q[i, j]
            for k in range(m):
                total += FP[i, k] * F[j, k]
            P[i, j] = total
            P[j, i] = total


@njit(error_model="numpy", cache=True)
def turn_errors(P: Floats, first: int, e: Floats) -> None:
    """P for the errors of a rotation that remain once e is taken out.

    What remains of an error g is the vector of R(-e) R(g), whose derivative at g = e is
    (I - ½ [e×]) / (1 + |e|² / 4).
    """
    x, y, z = e[first], e[first + 1], e[first + 2]
    k = 1.0 / (1.0 + 0.25 * (x * x + y * y + z * z))
    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
    for j in range(P.shape[0]):
        a, b, c = P[first, j], P[first + 1, j], P[first + 2, j]
        P[first, j] = k * (a - (y * c - z * b))
        P[first + 1, j] = k * (b - (z * a - x * c))
        P[first + 2, j] = k * (c - (x * b - y * a))
    for i in range(P.shape[0]):
        a, b, c = P[i, first], P[i, first + 1], P[i, first + 2]
        P[i, first] = k * (a - (y * c - z * b))
        P[i, first + 1] = k * (b - (z * a - x * c))
        P[i, first + 2] = k * (c - (x * b - y * a))
