"""Every reading against all others, and against those before it, compiled."""

import math

import numpy as np
from numba import njit

from mgeo_attitude.estimation.kernels.algebra import cholesky, square

loop = njit(cache=True, error_model="numpy", nogil=True)


@loop
def all_others(there, used, sights, growth, e, common, given, slope, root, residuals, found):
    """Square of every residual to what all other readings say, over its covariance.

    Parameters
    ----------
    there, used : arrays of bool, shape (s, N)
        Where there is a reading, and where the smoother has taken it.
    sights : z, H, noise, counts, columns
        See `linearization.Sightings`.
    e, common : arrays, shapes (N, d) and (q,)
        Smoothed errors.
    given, slope : arrays, shapes (N, d, d) and (N, d, q)
        See `smoother.Spread`.
    root : array, shape (q, q)
        S, an upper triangle, with S Sᵀ the covariance of c.
    residuals, found : arrays, shapes (s, N, 3) and (s, N)
        Written.
    """
    z, H, noise, counts, columns = sights
    N, d, q = slope.shape
    total, spread, V, r = np.empty((3, q)), np.empty((3, q)), np.empty((3, 3)), np.empty(3)
    for s in range(len(there)):
        nd, nc = counts[s]
        for k in range(N):
            if not there[s, k]:
                continue
            for i in range(3):
                r[i] = z[s, k, i]
                for j in range(q):
                    total[i, j] = spread[i, j] = 0.0
                for a in range(nd):
                    f, row = H[s, k, i, a], columns[s, a]
                    r[i] -= f * e[k, row]
                    for j in range(q):
                        total[i, j] += f * slope[k, row, j]
                for a in range(nc):
                    row = columns[s, nd + a]
                    f = H[s, k, i, nd + a] * growth[k, row]
                    r[i] -= f * common[d + row]
                    total[i, d + row] += f
            for m in range(q):
                f0, f1, f2 = total[0, m], total[1, m], total[2, m]
                for j in range(m, q):
                    spread[0, j] += f0 * root[m, j]
                    spread[1, j] += f1 * root[m, j]
                    spread[2, j] += f2 * root[m, j]
            sign = -1.0 if used[s, k] else 1.0
            for i in range(3):
                for j in range(i + 1):
                    value = 0.0
                    for m in range(q):
                        value += spread[i, m] * spread[j, m]
                    for a in range(nd):
                        partial, row = 0.0, columns[s, a]
                        for b in range(nd):
                            partial += given[k, row, columns[s, b]] * H[s, k, j, b]
                        value += H[s, k, i, a] * partial
                    V[i, j] = sign * value
                V[i, i] += noise[s, i] * noise[s, i]
                residuals[s, k, i] = r[i]
            cholesky(V, 3)
            found[s, k] = square(V, r, 3)


@loop
def those_before(seen, readings, kept, root, common, white, errors, until):
    """The filter of e and c together, from that of a known c.

    Potter's square root of the covariance of c, by one number of a whitened reading at a time
    (G. J. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, chapter II).

    Parameters
    ----------
    root, common : arrays, shapes (q, q) and (q,)
        Of what is believed of c; in the end of what all readings say.
    white : array, shape (s, N, 3)
        Written: innovations, whitened.
    errors, until : arrays, shapes (N, d) and (N, d, d)
        Written: estimated errors at every sample, and their covariance.
    """
    w, W = readings[2], readings[3]
    x, T, P = kept
    N, d, q = T.shape
    phi, spread = np.empty(q), np.empty((d, q))
    for k in range(N):
        for s in range(len(seen)):
            if not seen[s, k]:
                continue
            for i in range(3):
                for j in range(q):
                    phi[j] = 0.0
                off = w[s, k, i]
                for m in range(q):
                    f = W[s, k, i, m]
                    off -= f * common[m]
                    for j in range(q):
                        phi[j] += f * root[m, j]
                variance = 1.0
                for j in range(q):
                    variance += phi[j] * phi[j]
                white[s, k, i] = off / math.sqrt(variance)
                less = 1.0 / (1.0 + math.sqrt(1.0 / variance))
                for m in range(q):
                    total = 0.0
                    for j in range(q):
                        total += root[m, j] * phi[j]
                    total /= variance
                    common[m] += total * off
                    f = total * less
                    for j in range(q):
                        root[m, j] -= f * phi[j]
        for i in range(d):
            errors[k, i] = x[k, i]
            for j in range(q):
                spread[i, j] = 0.0
            for m in range(q):
                f = T[k, i, m]
                errors[k, i] += f * common[m]
                for j in range(q):
                    spread[i, j] += f * root[m, j]
            for j in range(i + 1):
                total = P[k, i, j]
                for m in range(q):
                    total += spread[i, m] * spread[j, m]
                until[k, i, j] = until[k, j, i] = total
