"""Many steps, each at a rate of its own: turns one after the other, discretization; compiled."""

import numpy as np
from mgeo_attitude._compiled import kept
from mgeo_attitude.filter.polynomials import discretize_alike


@kept("void(float64[:,:,::1], float64[:,:,::1])")
def accumulated(turn, R):
    """R, shape (n + 1, 3, 3), from I on: each is the one before times a transposed turn."""
    for i in range(3):
        for j in range(3):
            R[0, i, j] = 1.0 if i == j else 0.0
    for k in range(len(turn)):
        for i in range(3):
            a, b, c = R[k, i, 0], R[k, i, 1], R[k, i, 2]
            for j in range(3):
                R[k + 1, i, j] = a * turn[k, j, 0] + b * turn[k, j, 1] + c * turn[k, j, 2]


@kept(
    "void(float64, UniTuple(float64, 2), float64[:,:,::1], float64[:,::1], float64[::1], "
    "float64[:,:,::1], float64[:,:,::1])"
)
def discretized(decay, densities, others, rates, durations, F, Q):
    """F and Q of n steps, equation (7), as `filter.discretization.discretize`.

    Parameters
    ----------
    decay : float
        Of the bias [1/s].
    densities : tuple of two floats
        Of the noise that drives attitude and bias.
    others : array, shape (3, 3, k)
        By what the gyro's k constant errors change the attitude's rate, of each component of ω.
    rates, durations : arrays, shapes (n, 3) and (n,)
    F, Q : arrays, shapes (n, m, m), m >= 6 + k, and (n, l, l), l >= 6
        Their rows and columns of these states are written; what is not is zero.
    """
    k = others.shape[2]
    W, J = np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(rates)):
        discretize_alike(decay, densities, rates[n], durations[n], F[n], Q[n], J, W)
        x, y, z = rates[n, 0], rates[n, 1], rates[n, 2]
        for m in range(k):
            for i in range(3):
                F[n, i, 6 + m] = 0.0
            for j in range(3):
                f = x * others[0, j, m] + y * others[1, j, m] + z * others[2, j, m]
                for i in range(3):
                    F[n, i, 6 + m] += J[i, j] * f
            F[n, 6 + m, 6 + m] = 1.0
