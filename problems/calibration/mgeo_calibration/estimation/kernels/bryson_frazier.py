"""Backward pass of the Bryson-Frazier smoother over the output of `two_stage.py`.

The smoother inverts no covariance (G. J. Bierman, Fixed interval smoothing with discrete
measurements, International Journal of Control 18 (1973) 65-75).
"""

import math

import numpy as np
from mgeo_attitude._compiled import compile_cached

from mgeo_calibration.estimation.kernels.algebra import compute_dot_products, helper
from mgeo_calibration.estimation.kernels.signatures import (
    ESTIMATES,
    MEASUREMENTS,
    PROCESS,
    READINGS,
)


@helper
def combine_information(A, B, out, U, X, n):
    """Write (A⁻¹ + B)⁻¹ to `out`, for positive semidefinite matrices A and B that may be singular.

    The result is L (I + Lᵀ B L)⁻¹ Lᵀ with A = L Lᵀ. Only the n leading rows and columns are
    computed, in blocks of three. U and X are work arrays.
    """
    d = len(U)
    factor_semidefinite(A, out, d)
    for i in range(d):
        for j in range(d):
            U[i, j] = out[j, i] if j >= i else 0.0
    for i in range(0, d, 3):
        for j in range(0, d, 3):
            write_block(compute_dot_products(U, i, B, j, i, d), X, i, j)
    for i in range(0, d, 3):
        for j in range(0, i + 1, 3):
            write_block(compute_dot_products(X, i, U, j, j, d), out, i, j)
        for j in range(i, i + 3):
            out[j, j] += 1.0
    # Factor I + Lᵀ B L, then multiply L by the transposed inverse factor.
    factor_semidefinite(out, out, d)
    for i in range(0, n, 3):
        for j in range(0, d, 3):
            sums = compute_dot_products(X, i, out, j, 0, j)
            for a in range(3):
                for b in range(3):
                    X[i + a, j + b] = U[j + b, i + a] - sums[a][b]
            divide_block(X, i, j, out)
    for i in range(0, n, 3):
        for j in range(0, i + 1, 3):
            sums = compute_dot_products(X, i, X, j, 0, d)
            write_block(sums, out, i, j)
    for i in range(n):
        for j in range(i):
            out[j, i] = out[i, j]


@helper
def write_block(sums, out, i, j):
    for a in range(3):
        for b in range(3):
            out[i + a, j + b] = sums[a][b]


@helper
def factor_semidefinite(A, L, d):
    """Write the Cholesky factor of a positive semidefinite matrix A to the lower triangle of L. A
    may be singular.
    """
    for i in range(0, d, 3):
        for j in range(0, i + 1, 3):
            sums = compute_dot_products(L, i, L, j, 0, j)
            for a in range(3):
                for b in range(3):
                    L[i + a, j + b] = A[i + a, j + b] - sums[a][b]
            if j < i:
                divide_block(L, i, j, L)
        for a in range(i, i + 3):
            for b in range(i, a + 1):
                total = L[a, b]
                for m in range(i, b):
                    total -= L[a, m] * L[b, m]
                if a == b:
                    L[a, a] = math.sqrt(total) if total > 0.0 else 0.0
                else:
                    L[a, b] = total / L[b, b] if L[b, b] > 0.0 else 0.0


@helper
def divide_block(X, i, j, L):
    """Multiply the 3 x 3 block of X at (i, j) by the inverse transpose of the diagonal block of L
    at j.
    """
    for b in range(3):
        f = 1.0 / L[j + b, j + b] if L[j + b, j + b] > 0.0 else 0.0
        for a in range(3):
            total = X[i + a, j + b]
            for m in range(b):
                total -= X[i + a, j + m] * L[j + b, j + m]
            X[i + a, j + b] = f * total


@helper
def multiply_transposed(F, k, A, out):
    """Write Fᵀ A to `out`, where F is the transition matrix of step k.

    F is diagonal from the fourth row on.
    """
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


@compile_cached(
    f"void(float64[:,:,::1], boolean[:,::1], int64[:,::1], int64[:,::1], {READINGS}, {ESTIMATES}, "
    "float64[::1], int64, float64[::1], float64[:,::1])"
)
def smooth_errors(F, is_used, n_columns, columns, readings, estimates, c, first_new, adjoint, e):
    """Run the smoother backward over consecutive samples, and write the estimated errors of the
    stochastic states to `e`.

    Parameters
    ----------
    F : array, shape (n, d, d)
        Transition matrices.
    is_used : array of bool, shape (s, N)
        Readings that the forward filter has used.
    n_columns, columns : arrays of int
        See `linearization.MeasurementEquations`.
    readings, estimates
        Output of `two_stage.run_filter`.
    c : array, shape (q,)
        Estimated errors at the first sample and of the constant states.
    first_new : int
        Index in the span of the last sample to smooth: 1 if the first sample belongs to the
        previous span, otherwise 0.
    adjoint : array, shape (d,)
        Adjoint variable: zero at the last sample of the batch; on output, the input for the
        previous span.
    e : array, shape (N, d)
        Output: smoothed errors.
    """
    Hw, K, w, W = readings
    x, T, P = estimates
    N, d, q = T.shape
    before, u = np.zeros(d), np.empty(3)
    for k in range(N - 1, first_new - 1, -1):
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
        for s in range(len(is_used) - 1, -1, -1):
            if not is_used[s, k]:
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
                for j in range(n_columns[s, 0]):
                    adjoint[columns[s, j]] += Hw[s, k, i, j] * u[i]
        if k:
            for j in range(d):
                before[j] = F[k - 1, j, j] * adjoint[j] if j >= 3 else 0.0
                for i in range(3):
                    before[j] += F[k - 1, i, j] * adjoint[i]
            for j in range(d):
                adjoint[j] = before[j]


@compile_cached(
    f"void({PROCESS}, boolean[:,::1], {MEASUREMENTS}, {READINGS}, {ESTIMATES}, int64, "
    "float64[:,::1], float64[:,::1], float64[:,:,::1], float64[:,:,::1])"
)
def smooth_covariances(
    process,
    is_used,
    measurements,
    readings,
    estimates,
    first_new,
    later_information,
    adjoint,
    conditional_covariance,
    derivative,
):
    """Compute the smoothed covariance of the stochastic states, given the errors c that all samples
    share. Also compute the derivative of the smoothed errors with respect to c.

    The vector c contains the errors at the first sample and of the constant states. The covariance
    combines the filter covariance with the information of all later readings, which is propagated
    backward in time (D. C. Fraser and J. E. Potter, The optimum linear smoother as a combination of
    two optimum linear filters, IEEE Transactions on Automatic Control 14 (1969) 387-390). No
    covariances are subtracted.

    Parameters
    ----------
    process : F, G, Q, defect
        See `kinematics.ProcessEquations`.
    is_used : array of bool, shape (s, N)
        Readings that the forward filter has used.
    measurements : z, H, noise, counts, columns
        See `linearization.MeasurementEquations`.
    readings, estimates
        Output of `two_stage.run_filter`.
    first_new : int
        Index in the span of the last sample to smooth: 1 if the first sample belongs to the
        previous span, otherwise 0.
    later_information, adjoint : arrays, shapes (d, d) and (d, q)
        Information of all later readings, and adjoint variable: zero at the last sample of the
        batch; on output, the input for the previous span.
    conditional_covariance, derivative : arrays, shapes (N, n, n) and (N, n, q)
        Output for the n leading errors.
    """
    F, Q = process[0], process[2]
    _, H, noise, counts, columns = measurements
    Hw, K, _, W = readings
    _, T, P = estimates
    (N, d, q), n_leading = T.shape, conditional_covariance.shape[1]
    combined, L, X, workspace = (
        np.empty((d, d)),
        np.empty((d, d)),
        np.empty((d, d)),
        np.empty((d, d)),
    )
    propagated, U = np.empty((d, q)), np.empty((3, q))
    for k in range(N - 1, first_new - 1, -1):
        for i in range(d):
            for j in range(d):
                workspace[i, j] = P[k, i, j]
        combine_information(workspace, later_information, combined, L, X, n_leading)
        for i in range(n_leading):
            for j in range(n_leading):
                conditional_covariance[k, i, j] = combined[i, j]
            for j in range(q):
                derivative[k, i, j] = T[k, i, j]
            for m in range(0, d, 3):
                f0, f1, f2 = P[k, i, m], P[k, i, m + 1], P[k, i, m + 2]
                for j in range(q):
                    derivative[k, i, j] += (
                        f0 * adjoint[m, j] + f1 * adjoint[m + 1, j] + f2 * adjoint[m + 2, j]
                    )
        for s in range(len(is_used) - 1, -1, -1):
            if not is_used[s, k]:
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
                    later_information[columns[s, a], columns[s, b]] += total
        if k:
            multiply_transposed(F, k - 1, adjoint, propagated)
            for i in range(d):
                for j in range(q):
                    adjoint[i, j] = propagated[i, j]
            # The information at sample k - 1 is Fᵀ (later_information⁻¹ + Q)⁻¹ F.
            for i in range(d):
                for j in range(d):
                    workspace[i, j] = Q[k - 1, i, j]
            combine_information(later_information, workspace, combined, L, X, d)
            multiply_transposed(F, k - 1, combined, workspace)
            for i in range(d):
                for j in range(d):
                    combined[i, j] = workspace[j, i]
            multiply_transposed(F, k - 1, combined, later_information)
