"""Residuals after smoothing and innovations of the filter, for all readings."""

import math

import numpy as np
from mgeo_attitude._compiled import compile_cached

from mgeo_calibration.estimation.kernels.algebra import factor_cholesky, helper, solve_squared_norm
from mgeo_calibration.estimation.kernels.signatures import ESTIMATES, MEASUREMENTS, READINGS


@helper
def multiply_by_triangle(A, root, out):
    q = len(root)
    for i in range(3):
        for j in range(q):
            out[i, j] = 0.0
    for m in range(q):
        f0, f1, f2 = A[0, m], A[1, m], A[2, m]
        for j in range(m, q):
            out[0, j] += f0 * root[m, j]
            out[1, j] += f1 * root[m, j]
            out[2, j] += f2 * root[m, j]


@helper
def update_potter(s, k, readings, root, common_errors, whitened_innovations, phi, workspace):
    """Update the estimated errors c, which all samples share, with one reading by Potter's
    algorithm. The estimate and the square root of its covariance are modified in place.

    A component with derivative w changes the root S to S (I - β φᵀ φ) with φ = w S. The vectors φ
    of all three components follow from the initial root, φ₂ (I - β φ₁ᵀ φ₁) after the first
    component, and so on: two passes through S are sufficient. `phi` and `workspace` are work
    arrays.
    """
    w, W = readings[2], readings[3]
    q = len(root)
    innovation, variance, beta, products = workspace[0], workspace[1], workspace[2], workspace[3]
    for i in range(3):
        innovation[i] = w[s, k, i]
        for j in range(q):
            phi[i, j] = 0.0
    for m in range(q):
        f0, f1, f2 = W[s, k, 0, m], W[s, k, 1, m], W[s, k, 2, m]
        innovation[0] -= f0 * common_errors[m]
        innovation[1] -= f1 * common_errors[m]
        innovation[2] -= f2 * common_errors[m]
        for j in range(q):
            phi[0, j] += f0 * root[m, j]
            phi[1, j] += f1 * root[m, j]
            phi[2, j] += f2 * root[m, j]
    for i in range(3):
        for n in range(i):
            total = dot_rows(phi, i, n)
            innovation[i] -= total * innovation[n] / variance[n]
            for j in range(q):
                phi[i, j] -= beta[n] * total * phi[n, j]
        variance[i] = 1.0 + dot_rows(phi, i, i)
        sigma = math.sqrt(variance[i])
        beta[i] = 1.0 / (variance[i] + sigma)
        whitened_innovations[s, k, i] = innovation[i] / sigma
    products[0] = beta[0] * dot_rows(phi, 0, 1)
    products[1] = beta[0] * dot_rows(phi, 0, 2)
    products[2] = beta[1] * dot_rows(phi, 1, 2)
    for i in range(3):
        innovation[i] /= variance[i]
    for m in range(q):
        s0 = s1 = s2 = t0 = t1 = t2 = u0 = u1 = u2 = 0.0
        for j in range(0, q, 3):
            a, b, c = root[m, j], root[m, j + 1], root[m, j + 2]
            s0 += a * phi[0, j]
            s1 += a * phi[1, j]
            s2 += a * phi[2, j]
            t0 += b * phi[0, j + 1]
            t1 += b * phi[1, j + 1]
            t2 += b * phi[2, j + 1]
            u0 += c * phi[0, j + 2]
            u1 += c * phi[1, j + 2]
            u2 += c * phi[2, j + 2]
        s0 += t0 + u0
        s1 += t1 + u1 - products[0] * s0
        s2 += t2 + u2 - products[1] * s0 - products[2] * s1
        common_errors[m] += s0 * innovation[0] + s1 * innovation[1] + s2 * innovation[2]
        s0, s1, s2 = beta[0] * s0, beta[1] * s1, beta[2] * s2
        for j in range(q):
            root[m, j] -= s0 * phi[0, j] + s1 * phi[1, j] + s2 * phi[2, j]


@helper
def write_estimates(k, estimates, root, common_errors, spread, errors, covariances):
    """Write the estimated errors of the first n stochastic states at sample k, and their
    covariance, to the output arrays.

    The errors are x + T c; `spread` is a work array.
    """
    x, T, P = estimates
    n, q = spread.shape
    for i in range(n):
        errors[k, i] = x[k, i]
        for j in range(q):
            spread[i, j] = 0.0
        for m in range(q):
            f = T[k, i, m]
            errors[k, i] += f * common_errors[m]
            for j in range(q):
                spread[i, j] += f * root[m, j]
        for j in range(i + 1):
            total = P[k, i, j]
            for m in range(q):
                total += spread[i, m] * spread[j, m]
            covariances[k, i, j] = covariances[k, j, i] = total


@helper
def dot_rows(A, i, n):
    """Return the dot product of rows i and n of A. The number of columns must be a multiple of
    three.
    """
    s0 = s1 = s2 = 0.0
    for j in range(0, A.shape[1], 3):
        s0 += A[i, j] * A[n, j]
        s1 += A[i, j + 1] * A[n, j + 1]
        s2 += A[i, j + 2] * A[n, j + 2]
    return s0 + s1 + s2


@compile_cached(
    f"void(boolean[:,::1], boolean[:,::1], {MEASUREMENTS}, float64[:,::1], float64[:,::1], "
    "float64[::1], float64[:,:,::1], float64[:,:,::1], float64[:,::1], int64, "
    "float64[:,:,::1], float64[:,::1], float64[:,::1])"
)
def compute_residuals(
    has_reading,
    is_used,
    measurements,
    constant_factors,
    e,
    common_errors,
    conditional_covariance,
    derivative,
    root,
    first_new,
    residuals,
    normalized_squares,
    sigma,
):
    """Compute the residuals after smoothing, their normalized squares and the 1-sigma of the
    smoothed attitude.

    A reading that the smoother has not used is compared with an independent prediction.

    Parameters
    ----------
    has_reading, is_used : arrays of bool, shape (s, N)
        Samples with a reading, and samples with a reading that the smoother has used.
    measurements : z, H, noise, counts, columns
        See `linearization.MeasurementEquations`.
    constant_factors : array, shape (N, c)
        Factors of the constant states.
    e, common_errors : arrays, shapes (N, d) and (q,)
        Smoothed errors e and estimate of c.
    conditional_covariance, derivative : arrays, shapes (N, n, n) and (N, n, q)
        See `smoother.SmoothedCovariance`. The n states include all stochastic states that the
        readings depend on.
    root : array, shape (q, q)
        Upper triangular S, where S Sᵀ is the covariance of c.
    first_new : int
        First sample to compute.
    residuals, normalized_squares : arrays, shapes (s, N, 3) and (s, N)
        Output: residuals and their normalized squares.
    sigma : array, shape (N, 3)
        Output: 1-sigma of the attitude errors.
    """
    z, H, noise, counts, columns = measurements
    (N, d), q = e.shape, derivative.shape[2]
    total, spread, V, r = np.empty((3, q)), np.empty((3, q)), np.empty((3, 3)), np.empty(3)
    for k in range(first_new, N):
        for i in range(3):
            for j in range(q):
                total[i, j] = derivative[k, i, j]
        multiply_by_triangle(total, root, spread)
        for i in range(3):
            value = conditional_covariance[k, i, i]
            for j in range(q):
                value += spread[i, j] * spread[i, j]
            sigma[k, i] = math.sqrt(value)
    for s in range(len(has_reading)):
        nd, nc = counts[s]
        for k in range(first_new, N):
            if not has_reading[s, k]:
                continue
            for i in range(3):
                r[i] = z[s, k, i]
                for j in range(q):
                    total[i, j] = 0.0
                for a in range(nd):
                    f, row = H[s, k, i, a], columns[s, a]
                    r[i] -= f * e[k, row]
                    for j in range(q):
                        total[i, j] += f * derivative[k, row, j]
                for a in range(nc):
                    row = columns[s, nd + a]
                    f = H[s, k, i, nd + a] * constant_factors[k, row]
                    r[i] -= f * common_errors[d + row]
                    total[i, d + row] += f
            multiply_by_triangle(total, root, spread)
            sign = -1.0 if is_used[s, k] else 1.0
            for i in range(3):
                for j in range(i + 1):
                    value = 0.0
                    for m in range(q):
                        value += spread[i, m] * spread[j, m]
                    for a in range(nd):
                        partial, row = 0.0, columns[s, a]
                        for b in range(nd):
                            partial += conditional_covariance[k, row, columns[s, b]] * H[s, k, j, b]
                        value += H[s, k, i, a] * partial
                    V[i, j] = sign * value
                V[i, i] += noise[s, i] * noise[s, i]
                residuals[s, k, i] = r[i]
            factor_cholesky(V, 3)
            normalized_squares[s, k] = solve_squared_norm(V, r, 3)


@compile_cached(
    f"void(boolean[:,::1], {READINGS}, {ESTIMATES}, float64[:,::1], float64[::1], int64, "
    "float64[:,:,::1], float64[:,::1], float64[:,:,::1])"
)
def compute_innovations(
    is_used,
    readings,
    estimates,
    root,
    common_errors,
    first_new,
    whitened_innovations,
    errors,
    covariances,
):
    """Run the Kalman filter over consecutive samples, and compute whitened innovations, estimates
    and covariances.

    The filter for a given c is extended to the joint estimate of e and c. The update of the
    covariance of c is Potter's square root, one component of a whitened reading at a time (G. J.
    Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, chapter II).

    Parameters
    ----------
    is_used : array of bool, shape (s, N)
        Readings that the smoother has used.
    readings, estimates
        Output of `two_stage.run_filter`.
    root, common_errors : arrays, shapes (q, q) and (q,)
        Covariance root and estimate of c: prior on input, posterior of all readings on output.
    first_new : int
        First sample to compute.
    whitened_innovations : array, shape (s, N, 3)
        Output: whitened innovations.
    errors, covariances : arrays, shapes (N, n) and (N, n, n)
        Output: estimates of the n leading errors at every sample, and their covariance.
    """
    N, _, q = estimates[1].shape
    phi, workspace, spread = np.empty((3, q)), np.empty((4, 3)), np.empty((errors.shape[1], q))
    for k in range(first_new, N):
        for s in range(len(is_used)):
            if is_used[s, k]:
                update_potter(
                    s, k, readings, root, common_errors, whitened_innovations, phi, workspace
                )
        write_estimates(k, estimates, root, common_errors, spread, errors, covariances)
