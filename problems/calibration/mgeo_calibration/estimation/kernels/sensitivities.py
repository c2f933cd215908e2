"""Sensitivities of the filter of a batch to the coefficients of score tests.

The output of `two_stage.py` determines how a coefficient changes the stochastic states and the
whitened innovations. The changed innovations are reduced at once into the triangular equations of
c.
"""

import math

import numpy as np
from mgeo_attitude._compiled import compile_cached

from mgeo_calibration.estimation.kernels.algebra import (
    BLOCK_LENGTH,
    accumulate_gram,
    helper,
    reduce_equations,
)
from mgeo_calibration.estimation.kernels.signatures import READINGS


@helper
def predict(F, k, attitude_changes, attitude_coefficients, T, workspace):
    """Propagate T, the sensitivities of the stochastic states to the model error coefficients, over
    step k in place.

    F is diagonal from the fourth row on.
    """
    d, m = T.shape
    for i in range(3):
        for j in range(m):
            workspace[i, j] = 0.0
        for a in range(0, d, 3):
            f0, f1, f2 = F[k, i, a], F[k, i, a + 1], F[k, i, a + 2]
            if f0 != 0.0 or f1 != 0.0 or f2 != 0.0:
                for j in range(m):
                    workspace[i, j] += f0 * T[a, j] + f1 * T[a + 1, j] + f2 * T[a + 2, j]
        for a in range(len(attitude_coefficients)):
            workspace[i, attitude_coefficients[a]] += attitude_changes[k, i, a]
    for i in range(d):
        f = F[k, i, i]
        for j in range(m):
            T[i, j] = workspace[i, j] if i < 3 else f * T[i, j]


@helper
def factor_innovation_covariance(K, H, noise, nd, columns, L):
    """Write the Cholesky factor of the innovation covariance V = H P Hᵀ + R to L.

    L follows from K = L⁻¹ H P, where K Hᵀ = Lᵀ - L⁻¹ R.
    """
    for i in range(3):
        for j in range(i, 3):
            total = 0.0
            for a in range(nd):
                total += K[i, columns[a]] * H[j, a]
            L[j, i] = total
        L[i, i] = 0.5 * (L[i, i] + math.sqrt(L[i, i] * L[i, i] + 4.0 * noise[i] * noise[i]))


@compile_cached(
    "void(float64[:,:,::1], float64[:,:,::1], int64[::1], boolean[:,::1], "
    "Tuple((float64[:,:,:,::1], float64[:,::1], int64[:,::1], int64[:,::1])), "
    f"float64[:,:,:,::1], int64[::1], int64[:,::1], {READINGS}, int64, float64[:,::1], "
    "float64[:,::1], float64[:,::1])"
)
def compute_sensitivities(
    F,
    attitude_changes,
    attitude_coefficients,
    is_used,
    measurements,
    reading_changes,
    n_coefficients,
    reading_coefficients,
    readings,
    first_new,
    T,
    R,
    gram,
):
    """Propagate the sensitivities of states and innovations to m model error coefficients over
    consecutive samples. T, R and `gram` are updated in place.

    Parameters
    ----------
    F : array, shape (n, d, d)
        Transition matrices.
    attitude_changes, attitude_coefficients : arrays, shapes (n, 3, a) and (a,)
        Change of the attitude error in each step, and the index of the coefficient of each column.
    is_used : array of bool, shape (s, N)
        Readings that the smoother has used.
    measurements : H, noise, counts, columns
        See `linearization.MeasurementEquations`.
    reading_changes, n_coefficients, reading_coefficients : arrays
        Change of the readings of each sensor, shape (s, N, 3, b), number of columns of each sensor,
        shape (s,), and index of the coefficient of each column, shape (s, b).
    readings : Hw, K, w, W
        Output of `two_stage.run_filter`.
    first_new : int
        0, or 1 to continue from the first sample.
    T : array, shape (d, m)
        Derivative of the stochastic states by the coefficients at the first sample; on output at
        the last sample.
    R : array, shape (q, q + 1 + m)
        Triangle of the equations of c, their right side, and the columns of the coefficients;
        updated.
    gram : array, shape (m + 1, m + 1)
        Upper triangle of the products of the residual columns; updated.
    """
    H, noise, counts, columns = measurements
    Hw, K, w, W = readings
    d, m = T.shape
    N, q, n = is_used.shape[1], len(R), 0
    A, reflections = np.zeros((R.shape[1], BLOCK_LENGTH)), np.empty((q, 2))
    workspace, U, L, g = np.empty((3, m)), np.empty((3, m)), np.empty((3, 3)), np.empty(3)
    for k in range(first_new, N):
        if k:
            predict(F, k - 1, attitude_changes, attitude_coefficients, T, workspace)
        for s in range(len(is_used)):
            if not is_used[s, k]:
                continue
            nd = counts[s, 0]
            factor_innovation_covariance(K[s, k], H[s, k], noise[s], nd, columns[s], L)
            for i in range(3):
                for j in range(m):
                    U[i, j] = 0.0
                for a in range(0, nd, 3):
                    row = columns[s, a]
                    h0, h1, h2 = Hw[s, k, i, a], Hw[s, k, i, a + 1], Hw[s, k, i, a + 2]
                    for j in range(m):
                        U[i, j] += h0 * T[row, j] + h1 * T[row + 1, j] + h2 * T[row + 2, j]
            for b in range(n_coefficients[s]):
                for i in range(3):
                    g[i] = reading_changes[s, k, i, b]
                    for j in range(i):
                        g[i] -= L[i, j] * g[j]
                    g[i] /= L[i, i]
                    U[i, reading_coefficients[s, b]] += g[i]
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
            if n == BLOCK_LENGTH:
                reduce_equations(A, R, reflections)
                accumulate_gram(A, q, gram)
                n = 0
    if n:
        for j in range(len(A)):
            for i in range(n, BLOCK_LENGTH):
                A[j, i] = 0.0
        reduce_equations(A, R, reflections)
        accumulate_gram(A, q, gram)
