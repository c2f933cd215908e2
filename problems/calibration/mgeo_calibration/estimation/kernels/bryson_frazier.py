"""The smoother of a batch, compiled: backward through what `two_stage.py` has kept.

Bryson and Frazier's, which inverts nothing (G. J. Bierman, Fixed interval smoothing with discrete
measurements, International Journal of Control 18 (1973) 65-75).
"""

import math

import numpy as np
from numba import njit

from mgeo_calibration.estimation.kernels.algebra import cholesky, helper

loop = njit(cache=True, error_model="numpy", nogil=True)


@loop
def backward(F, seen, counts, columns, readings, kept, c, first, adjoint, e):
    """Smoothed errors e, shape (N, d), for errors c, from the last sample to a first one.

    `adjoint`, shape (d,), is zero at the last of all samples, and what to go on with in the end.
    """
    Hw, K, w, W = readings
    x, T, P = kept
    N, d, q = T.shape
    before, u = np.zeros(d), np.empty(3)
    for k in range(N - 1, first - 1, -1):
        for i in range(d):
            s0, s1, s2 = x[k, i], 0.0, 0.0
            for j in range(0, q, 3):
                s0 += T[k, i, j] * c[j]
                s1 += T[k, i, j + 1] * c[j + 1]
                s2 += T[k, i, j + 2] * c[j + 2]
            for j in range(0, d, 3):
                s0 += P[k, i, j] * adjoint[j]
                s1 += P[k, i, j + 1] * adjoint[j + 1]
                s2 += P[k, i, j + 2] * adjoint[j + 2]
            e[k, i] = s0 + s1 + s2
        for s in range(len(seen) - 1, -1, -1):
            if not seen[s, k]:
                continue
            for i in range(3):
                s0, s1, s2 = w[s, k, i], 0.0, 0.0
                for j in range(0, q, 3):
                    s0 -= W[s, k, i, j] * c[j]
                    s1 -= W[s, k, i, j + 1] * c[j + 1]
                    s2 -= W[s, k, i, j + 2] * c[j + 2]
                for j in range(0, d, 3):
                    s0 -= K[s, k, i, j] * adjoint[j]
                    s1 -= K[s, k, i, j + 1] * adjoint[j + 1]
                    s2 -= K[s, k, i, j + 2] * adjoint[j + 2]
                u[i] = s0 + s1 + s2
            for i in range(3):
                for j in range(counts[s, 0]):
                    adjoint[columns[s, j]] += Hw[s, k, i, j] * u[i]
        if k:
            for j in range(d):
                before[j] = F[k - 1, j, j] * adjoint[j] if j >= 3 else 0.0
                for i in range(3):
                    before[j] += F[k - 1, i, j] * adjoint[i]
            for j in range(d):
                adjoint[j] = before[j]


@loop
def smoothed(moves, seen, sights, readings, kept, first, later, adjoint, given, slope):
    """Covariance of the smoothed e for a known c, and its change with c, from a first sample on.

    The covariance is that of the filter with the information of all later readings, which goes
    backward in time by itself (D. C. Fraser and J. E. Potter, The optimum linear smoother as a
    combination of two optimum linear filters, IEEE Transactions on Automatic Control 14 (1969)
    387-390): nothing is subtracted.

    `later`, shape (d, d), and `adjoint`, shape (d, q), are zero at the last of all samples, and
    what to go on with in the end. Written: `given`, shape (N, n, n), and `slope`, shape (N, n, q),
    of the n leading errors.
    """
    F, Q = moves[0], moves[2]
    _, H, noise, counts, columns = sights
    Hw, K, _, W = readings
    _, T, P = kept
    (N, d, q), n_leading = T.shape, given.shape[1]
    now, L, X, room = np.empty((d, d)), np.empty((d, d)), np.empty((d, d)), np.empty((d, d))
    turned, U = np.empty((d, q)), np.empty((3, q))
    for k in range(N - 1, first - 1, -1):
        for i in range(d):
            for j in range(d):
                room[i, j] = P[k, i, j]
        combine(room, later, now, L, X, n_leading)
        for i in range(n_leading):
            for j in range(n_leading):
                given[k, i, j] = now[i, j]
            for j in range(q):
                slope[k, i, j] = T[k, i, j]
            for m in range(0, d, 3):
                f0, f1, f2 = P[k, i, m], P[k, i, m + 1], P[k, i, m + 2]
                for j in range(q):
                    slope[k, i, j] += (
                        f0 * adjoint[m, j] + f1 * adjoint[m + 1, j] + f2 * adjoint[m + 2, j]
                    )
        for s in range(len(seen) - 1, -1, -1):
            if not seen[s, k]:
                continue
            n = counts[s, 0]
            for i in range(3):
                for j in range(q):
                    U[i, j] = -W[s, k, i, j]
                for m in range(0, d, 3):
                    f0, f1, f2 = K[s, k, i, m], K[s, k, i, m + 1], K[s, k, i, m + 2]
                    for j in range(q):
                        U[i, j] -= (
                            f0 * adjoint[m, j] + f1 * adjoint[m + 1, j] + f2 * adjoint[m + 2, j]
                        )
            for a in range(n):
                row = columns[s, a]
                f0, f1, f2 = Hw[s, k, 0, a], Hw[s, k, 1, a], Hw[s, k, 2, a]
                for j in range(q):
                    adjoint[row, j] += f0 * U[0, j] + f1 * U[1, j] + f2 * U[2, j]
            for a in range(n):
                for b in range(n):
                    total = 0.0
                    for i in range(3):
                        total += H[s, k, i, a] * H[s, k, i, b] / (noise[s, i] * noise[s, i])
                    later[columns[s, a], columns[s, b]] += total
        if k:
            backed(F, k - 1, adjoint, turned)
            for i in range(d):
                for j in range(q):
                    adjoint[i, j] = turned[i, j]
            # Fᵀ (later⁻¹ + Q)⁻¹ F
            for i in range(d):
                for j in range(d):
                    room[i, j] = Q[k - 1, i, j]
            combine(later, room, now, L, X, d)
            backed(F, k - 1, now, room)
            for i in range(d):
                for j in range(d):
                    now[i, j] = room[j, i]
            backed(F, k - 1, now, later)


@helper
def combine(A, B, out, L, X, n):
    """out ← (A⁻¹ + B)⁻¹, as L (I + Lᵀ B L)⁻¹ Lᵀ for A = L Lᵀ; both may be singular.

    Its n leading rows and columns. L and X are room.
    """
    d = len(L)
    for j in range(d):
        pivot = 0.0
        for i in range(j, d):
            total = A[i, j]
            for m in range(j):
                total -= L[i, m] * L[j, m]
            if i == j:
                pivot = math.sqrt(total) if total > 0.0 else 0.0
                L[j, j] = pivot
            else:
                L[i, j] = total / pivot if pivot > 0.0 else 0.0
                L[j, i] = 0.0
    for i in range(d):
        for j in range(d):
            total = 0.0
            for m in range(j, d):
                total += B[i, m] * L[m, j]
            X[i, j] = total
    for i in range(d):
        for j in range(i + 1):
            total = 1.0 if i == j else 0.0
            for m in range(i, d):
                total += L[m, i] * X[m, j]
            out[i, j] = total
    # the factor of what is in brackets, then L times its inverse, transposed
    cholesky(out, d)
    for i in range(n):
        for j in range(d):
            total = L[i, j]
            for m in range(j):
                total -= X[i, m] * out[j, m]
            X[i, j] = total / out[j, j]
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for m in range(d):
                total += X[i, m] * X[j, m]
            out[i, j] = out[j, i] = total


@helper
def backed(F, k, A, out):
    """out ← Fᵀ A of a step; rows of F from the fourth on are of a diagonal."""
    d, q = A.shape
    for j in range(d):
        f = F[k, j, j] if j >= 3 else 0.0
        f0, f1, f2 = F[k, 0, j], F[k, 1, j], F[k, 2, j]
        if f0 != 0.0 or f1 != 0.0 or f2 != 0.0:
            for m in range(q):
                out[j, m] = f * A[j, m] + f0 * A[0, m] + f1 * A[1, m] + f2 * A[2, m]
        else:
            for m in range(q):
                out[j, m] = f * A[j, m]
