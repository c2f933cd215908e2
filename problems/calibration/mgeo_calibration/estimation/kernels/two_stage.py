"""Forward filter of a batch, linearized about a trajectory.

The errors e_k of the stochastic states follow from process noise and from c, which contains the
errors at the first sample and the errors of the constant states. The filter estimates e_k for a
known c, together with the derivatives of the estimate and of the innovations by c (B. Friedland,
Treatment of bias in recursive filtering, IEEE Transactions on Automatic Control 14 (1969) 359-367).
The covariance starts at zero and stays well conditioned for any prior of c and any gyro accuracy.

Arrays are written in place. States come in blocks of three. The innermost loops run along rows in
blocks of three so that the compiler can vectorize them. Array slices are avoided because of the
cost of their reference counts.
"""

import math

import numpy as np
from mgeo_attitude._compiled import compile_cached

from mgeo_calibration.estimation.kernels.algebra import (
    BLOCK_LENGTH,
    factor_cholesky,
    helper,
    reduce_equations,
    solve_squared_norm,
)
from mgeo_calibration.estimation.kernels.signatures import (
    ESTIMATES,
    MEASUREMENTS,
    PROCESS,
    READINGS,
)

#: Ratio of predicted variance to noise variance above which the covariance update uses Joseph's
#: form, because a subtraction would lose digits.
JOSEPH_RATIO = 100.0


@helper
def predict(process, k, x, T, P, workspace):
    """Propagate the filter estimate from sample k - 1 to sample k, in place.

    The estimate consists of x, T and P. F is diagonal from the fourth row on.
    """
    F, G, Q, defect = process
    _, d, q = T.shape
    n = k - 1
    for i in range(3):
        x[k, i] = defect[n, i]
        for m in range(d):
            workspace[i, m] = 0.0
            T[k, i, m] = 0.0
        for m in range(d, q):
            T[k, i, m] = G[n, i, m - d]
        for j in range(0, d, 3):
            f0, f1, f2 = F[n, i, j], F[n, i, j + 1], F[n, i, j + 2]
            if f0 != 0.0 or f1 != 0.0 or f2 != 0.0:
                x[k, i] += f0 * x[n, j] + f1 * x[n, j + 1] + f2 * x[n, j + 2]
                for m in range(q):
                    T[k, i, m] += f0 * T[n, j, m] + f1 * T[n, j + 1, m] + f2 * T[n, j + 2, m]
                for m in range(d):
                    workspace[i, m] += f0 * P[n, j, m] + f1 * P[n, j + 1, m] + f2 * P[n, j + 2, m]
    for i in range(3, d):
        f = F[n, i, i]
        x[k, i] = defect[n, i] + f * x[n, i]
        for m in range(q):
            T[k, i, m] = f * T[n, i, m]
        for m in range(d):
            workspace[i, m] = f * P[n, i, m]
    for i in range(d):
        for j in range(min(i + 1, 3)):
            total = Q[n, i, j]
            for m in range(d):
                total += workspace[i, m] * F[n, j, m]
            P[k, i, j] = P[k, j, i] = total
        for j in range(3, i + 1):
            P[k, i, j] = P[k, j, i] = Q[n, i, j] + workspace[i, j] * F[n, j, j]


@helper
def update(measurements, s, k, constant_factors, estimates, readings, workspace):
    """Update the filter estimate in place by one reading, and store the whitened reading for the
    smoother.

    With V = H P Hᵀ + R = L Lᵀ, Hw is L⁻¹ H, K is L⁻¹ H P, and w - W c is the whitened innovation.
    """
    z, H, noise, counts, columns = measurements
    x, T, P = estimates
    Hw, K, w, W = readings
    _, d, q = T.shape
    nd = counts[s, 0]
    for i in range(3):
        w[s, k, i] = z[s, k, i]
        for m in range(d):
            K[s, k, i, m] = 0.0
        for m in range(q):
            W[s, k, i, m] = 0.0
        for j in range(0, nd, 3):
            row = columns[s, j]
            h0, h1, h2 = H[s, k, i, j], H[s, k, i, j + 1], H[s, k, i, j + 2]
            w[s, k, i] -= h0 * x[k, row] + h1 * x[k, row + 1] + h2 * x[k, row + 2]
            for m in range(d):
                K[s, k, i, m] += h0 * P[k, row, m] + h1 * P[k, row + 1, m] + h2 * P[k, row + 2, m]
            for m in range(q):
                W[s, k, i, m] += h0 * T[k, row, m] + h1 * T[k, row + 1, m] + h2 * T[k, row + 2, m]
        for j in range(nd, nd + counts[s, 1]):
            column = columns[s, j]
            W[s, k, i, d + column] += H[s, k, i, j] * constant_factors[k, column]
    large, L = False, workspace[-3:]
    for i in range(3):
        for j in range(i + 1):
            total = 0.0
            for m in range(nd):
                total += K[s, k, i, columns[s, m]] * H[s, k, j, m]
            L[i, j] = total
        large |= L[i, i] > JOSEPH_RATIO * noise[s, i] * noise[s, i]
        L[i, i] += noise[s, i] * noise[s, i]
    # Cholesky factor of V, then Hw, K, W and w row by row.
    l0 = 1.0 / math.sqrt(L[0, 0])
    l10, l20 = L[1, 0] * l0, L[2, 0] * l0
    l1 = 1.0 / math.sqrt(L[1, 1] - l10 * l10)
    l21 = (L[2, 1] - l20 * l10) * l1
    l2 = 1.0 / math.sqrt(L[2, 2] - l20 * l20 - l21 * l21)
    for m in range(nd):
        a = H[s, k, 0, m] * l0
        b = (H[s, k, 1, m] - l10 * a) * l1
        Hw[s, k, 0, m], Hw[s, k, 1, m] = a, b
        Hw[s, k, 2, m] = (H[s, k, 2, m] - l20 * a - l21 * b) * l2
    for m in range(d):
        a = K[s, k, 0, m] * l0
        b = (K[s, k, 1, m] - l10 * a) * l1
        K[s, k, 0, m], K[s, k, 1, m] = a, b
        K[s, k, 2, m] = (K[s, k, 2, m] - l20 * a - l21 * b) * l2
    for m in range(q):
        a = W[s, k, 0, m] * l0
        b = (W[s, k, 1, m] - l10 * a) * l1
        W[s, k, 0, m], W[s, k, 1, m] = a, b
        W[s, k, 2, m] = (W[s, k, 2, m] - l20 * a - l21 * b) * l2
    w0 = w[s, k, 0] * l0
    w1 = (w[s, k, 1] - l10 * w0) * l1
    w2 = (w[s, k, 2] - l20 * w0 - l21 * w1) * l2
    w[s, k, 0], w[s, k, 1], w[s, k, 2] = w0, w1, w2
    if large:
        L[0, 0], L[1, 0], L[1, 1] = 1.0 / l0, l10, 1.0 / l1
        L[2, 0], L[2, 1], L[2, 2] = l20, l21, 1.0 / l2
        update_joseph(P[k], K[s, k], Hw[s, k], L, noise[s], nd, columns[s], workspace)
    for j in range(d):
        f0, f1, f2 = K[s, k, 0, j], K[s, k, 1, j], K[s, k, 2, j]
        x[k, j] += f0 * w0 + f1 * w1 + f2 * w2
        for m in range(q):
            T[k, j, m] -= f0 * W[s, k, 0, m] + f1 * W[s, k, 1, m] + f2 * W[s, k, 2, m]
        if not large:
            for m in range(d):
                P[k, j, m] -= f0 * K[s, k, 0, m] + f1 * K[s, k, 1, m] + f2 * K[s, k, 2, m]


@helper
def update_joseph(P, K, Hw, V, noise, nd, columns, workspace):
    """Update the covariance P in place by one reading, using Joseph's form.

    P becomes (I - Kᵀ Hw) P (I - Kᵀ Hw)ᵀ + Kᵀ L⁻¹ R L⁻ᵀ K.
    """
    d = len(P)
    A, AP = workspace[:d], workspace[d : 2 * d]
    for i in range(d):
        for j in range(d):
            A[i, j] = 1.0 if i == j else 0.0
        for m in range(3):
            for j in range(nd):
                A[i, columns[j]] -= K[m, i] * Hw[m, j]
    for i in range(d):
        for j in range(d):
            total = 0.0
            for k in range(d):
                total += A[i, k] * P[k, j]
            AP[i, j] = total
    # The gain Kᵀ L⁻¹ follows by back substitution.
    gain = np.empty((d, 3))
    for i in range(d):
        for m in range(2, -1, -1):
            total = K[m, i]
            for k in range(m + 1, 3):
                total -= V[k, m] * gain[i, k]
            gain[i, m] = total / V[m, m]
    for i in range(d):
        for j in range(i + 1):
            total = 0.0
            for k in range(d):
                total += AP[i, k] * A[j, k]
            for m in range(3):
                total += gain[i, m] * noise[m] * noise[m] * gain[j, m]
            P[i, j] = P[j, i] = total


@helper
def compute_step_cost(Q, defect, k, L, y):
    """Return the cost of step k: the squared residual of its process equations, normalized by the
    process noise covariance Q.

    L and y are work arrays.
    """
    d = len(y)
    for i in range(d):
        y[i] = defect[k, i]
        for j in range(i + 1):
            L[i, j] = Q[k, i, j]
    factor_cholesky(L, d)
    return solve_squared_norm(L, y, d)


@compile_cached(
    f"float64({PROCESS}, boolean[:,::1], {MEASUREMENTS}, float64[:,::1], {ESTIMATES}, {READINGS}, "
    "int64, float64)"
)
def run_filter(
    process, is_used, measurements, constant_factors, estimates, readings, first_new, cost
):
    """Run the forward filter over consecutive samples, and return the accumulated sum of squared
    normalized residuals.

    Parameters
    ----------
    process : F, G, Q, defect, shapes (n, d, d), (n, 3, c), (n, d, d), (n, d)
        See `kinematics.ProcessEquations`.
    is_used : array of bool, shape (s, N)
        Readings to use.
    measurements : z, H, noise, counts, columns
        See `linearization.MeasurementEquations`.
    constant_factors : array, shape (N, c)
        Factors of the constant states.
    estimates : x, T, P, shapes (N, d), (N, d, q), (N, d, d)
        Output: e = x + T c, with covariance P, after the readings of each sample. On input, the
        estimate of the first sample, before its readings if `first_new` is 0, otherwise after them.
    readings : Hw, K, w, W, shapes (s, N, 3, p), (s, N, 3, d), (s, N, 3), (s, N, 3, q)
        Output; see `update`.
    first_new : int
        0 at the start of the batch, or 1 to continue from the first sample of `estimates`.
    cost : float
        Sum of squares up to the first sample.
    """
    x, T, P = estimates
    z, noise = measurements[0], measurements[2]
    N, d, _ = T.shape
    workspace, y = np.zeros((2 * d + 3, d)), np.empty(d)
    for k in range(first_new, N):
        if k:
            predict(process, k, x, T, P, workspace)
            cost += compute_step_cost(process[2], process[3], k - 1, workspace, y)
        for s in range(len(is_used)):
            if is_used[s, k]:
                for i in range(3):
                    cost += (z[s, k, i] / noise[s, i]) ** 2
                update(measurements, s, k, constant_factors, estimates, readings, workspace)
    return cost


@compile_cached(f"void(boolean[:,::1], {READINGS}, int64, float64[:,::1])")
def reduce_readings(is_used, readings, first_new, R):
    """Add the whitened readings of consecutive samples to the triangular least-squares system R in
    place. The unknowns are the errors c that all samples share.

    `BLOCK_LENGTH` rows are reduced at a time.

    Parameters
    ----------
    is_used : array of bool, shape (s, N)
        Readings to use.
    readings : Hw, K, w, W
        Output of `run_filter`.
    first_new : int
        First sample to use.
    R : array, shape (q, q + 1)
        Triangle of the equations of c and their right side: prior on input, posterior on output.
    """
    w, W = readings[2], readings[3]
    q, n = len(R), 0
    A, workspace = np.zeros((q + 1, BLOCK_LENGTH)), np.empty((q, 2))
    for k in range(first_new, is_used.shape[1]):
        for s in range(len(is_used)):
            if not is_used[s, k]:
                continue
            for i in range(3):
                for m in range(q):
                    A[m, n + i] = W[s, k, i, m]
                A[q, n + i] = w[s, k, i]
            n += 3
            if n == BLOCK_LENGTH:
                reduce_equations(A, R, workspace)
                n = 0
    if n:
        for m in range(q + 1):
            for i in range(n, BLOCK_LENGTH):
                A[m, i] = 0.0
        reduce_equations(A, R, workspace)
