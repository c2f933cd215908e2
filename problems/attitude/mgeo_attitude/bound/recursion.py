"""The filter of what no attitude changes, compiled: a limit has one, a free start thousands."""

from __future__ import annotations

import numpy as np
from numba import njit

from mgeo_attitude._typing import Floats


@njit(
    "void(float64[:,::1], float64[::1], float64[::1], float64[:,:,:], float64[:,:,::1])",
    cache=True,
    error_model="numpy",
    nogil=True,
)
def covariances(start: Floats, decay: Floats, noise: Floats, told: Floats, out: Floats) -> None:
    """See `gyro.recursion`, whose result is written to `out`."""
    k = len(start)
    A = np.empty((k, 2 * k))
    for i in range(k):  # numba would take three seconds more for `out[0] = start`
        for j in range(k):
            out[0, i, j] = start[i, j]
    for step in range(1, len(told)):
        before, P = out[step - 1], out[step]
        some = False
        for i in range(k):
            for j in range(k):
                P[i, j] = before[i, j] * (decay[i] * decay[j])
                some |= told[step, i, j] != 0.0
            P[i, i] += noise[i]
        if some:  # P ← (1 + P J)⁻¹ P, by Gauss and Jordan with partial pivoting
            for i in range(k):
                for j in range(k):
                    total = 1.0 if i == j else 0.0
                    for m in range(k):
                        total += P[i, m] * told[step, m, j]
                    A[i, j], A[i, k + j] = total, P[i, j]
            for c in range(k):
                pivot = c
                for i in range(c + 1, k):
                    if abs(A[i, c]) > abs(A[pivot, c]):
                        pivot = i
                if pivot != c:
                    for j in range(2 * k):
                        A[c, j], A[pivot, j] = A[pivot, j], A[c, j]
                factor = 1.0 / A[c, c]
                for j in range(c, 2 * k):
                    A[c, j] *= factor
                for i in range(k):
                    if i != c and A[i, c] != 0.0:
                        factor = A[i, c]
                        for j in range(c, 2 * k):
                            A[i, j] -= factor * A[c, j]
            for i in range(k):
                for j in range(k):
                    P[i, j] = 0.5 * (A[i, k + j] + A[j, k + i])
