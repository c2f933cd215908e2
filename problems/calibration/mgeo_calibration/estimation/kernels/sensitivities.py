"""What coefficients beside all errors add to the filter of a batch, compiled.

The filter of `two_stage.py` stays as it is: what it has kept says what a coefficient changes the
driven errors and the whitened innovations by. Nothing is kept of that: innovations go into the
triangle of c at once.
"""

import math

import numpy as np
from mgeo_attitude._compiled import kept

from mgeo_calibration.estimation.kernels.algebra import (
    TOGETHER,
    helper,
    reflect,
    square_up,
)
from mgeo_calibration.estimation.kernels.signatures import READINGS


@helper
def predict(F, k, moves, moved, T, turned):
    """T after a step; rows of F from the fourth on are of a diagonal."""
    d, m = T.shape
    for i in range(3):
        for j in range(m):
            turned[i, j] = 0.0
        for a in range(0, d, 3):
            f0, f1, f2 = F[k, i, a], F[k, i, a + 1], F[k, i, a + 2]
            if f0 != 0.0 or f1 != 0.0 or f2 != 0.0:
                for j in range(m):
                    turned[i, j] += f0 * T[a, j] + f1 * T[a + 1, j] + f2 * T[a + 2, j]
        for a in range(len(moved)):
            turned[i, moved[a]] += moves[k, i, a]
    for i in range(d):
        f = F[k, i, i]
        for j in range(m):
            T[i, j] = turned[i, j] if i < 3 else f * T[i, j]


@helper
def factor(K, H, noise, nd, columns, L):
    """L of V = H P Hᵀ + R = L Lᵀ, of K = L⁻¹ H P: that times Hᵀ is Lᵀ - L⁻¹ R."""
    for i in range(3):
        for j in range(i, 3):
            total = 0.0
            for a in range(nd):
                total += K[i, columns[a]] * H[j, a]
            L[j, i] = total
        L[i, i] = 0.5 * (L[i, i] + math.sqrt(L[i, i] * L[i, i] + 4.0 * noise[i] * noise[i]))


@kept(
    "void(float64[:,:,::1], float64[:,:,::1], int64[::1], boolean[:,::1], "
    "Tuple((float64[:,:,:,::1], float64[:,::1], int64[:,::1], int64[:,::1])), "
    f"float64[:,:,:,::1], int64[::1], int64[:,::1], {READINGS}, int64, float64[:,::1], "
    "float64[:,::1], float64[:,::1])"
)
def sensitivities(F, moves, moved, seen, sights, reads, widths, read, readings, first, T, R, gram):
    """Some samples, with m coefficients.

    Parameters
    ----------
    F : array, shape (n, d, d)
    moves, moved : arrays, shapes (n, 3, a) and (a,)
        What is added to the attitude's error in each step, and by which coefficients.
    seen : array of bool, shape (s, N)
    sights : H, noise, counts, columns
        See `sightings.Sightings`.
    reads, widths, read : arrays, shapes (s, N, 3, b), (s,) and (s, b)
        What is added to the readings of each sensor, by how many coefficients, and by which.
    readings : Hw, K, w, W
        As `two_stage.forward` has written them.
    first : int
        As there.
    T : array, shape (d, m)
        Change of the driven errors, by the readings until the first sample; in the end until the
        last one.
    R, gram : arrays
        As of `two_stage.learn`.
    """
    H, noise, counts, columns = sights
    Hw, K, w, W = readings
    d, m = T.shape
    N, q, n = seen.shape[1], len(R), 0
    A, room = np.zeros((R.shape[1], TOGETHER)), np.empty((q, 2))
    turned, U, L, g = np.empty((3, m)), np.empty((3, m)), np.empty((3, 3)), np.empty(3)
    for k in range(first, N):
        if k:
            predict(F, k - 1, moves, moved, T, turned)
        for s in range(len(seen)):
            if not seen[s, k]:
                continue
            nd = counts[s, 0]
            factor(K[s, k], H[s, k], noise[s], nd, columns[s], L)
            for i in range(3):
                for j in range(m):
                    U[i, j] = 0.0
                for a in range(0, nd, 3):
                    row = columns[s, a]
                    h0, h1, h2 = Hw[s, k, i, a], Hw[s, k, i, a + 1], Hw[s, k, i, a + 2]
                    for j in range(m):
                        U[i, j] += h0 * T[row, j] + h1 * T[row + 1, j] + h2 * T[row + 2, j]
            for b in range(widths[s]):
                for i in range(3):
                    g[i] = reads[s, k, i, b]
                    for j in range(i):
                        g[i] -= L[i, j] * g[j]
                    g[i] /= L[i, i]
                    U[i, read[s, b]] += g[i]
            for i in range(d):
                f0, f1, f2 = K[s, k, 0, i], K[s, k, 1, i], K[s, k, 2, i]
                for j in range(m):
                    T[i, j] -= f0 * U[0, j] + f1 * U[1, j] + f2 * U[2, j]
            for i in range(3):
                for j in range(q):
                    A[j, n + i] = W[s, k, i, j]
                A[q, n + i] = w[s, k, i]
                for j in range(m):
                    A[q + 1 + j, n + i] = U[i, j]
            n += 3
            if n == TOGETHER:
                reflect(A, R, room)
                square_up(A, q, gram)
                n = 0
    if n:
        for j in range(len(A)):
            for i in range(n, TOGETHER):
                A[j, i] = 0.0
        reflect(A, R, room)
        square_up(A, q, gram)
