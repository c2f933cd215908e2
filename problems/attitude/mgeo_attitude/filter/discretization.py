"""Compiled exact discretization of the error dynamics at a constant body rate.

The functions run once per maneuver, not in every filter step.
"""

from __future__ import annotations

import math

import numpy as np

from mgeo_attitude._compiled import helper
from mgeo_attitude._typing import Floats

#: Largest square root of the norm of (A dt)² for which the series is summed directly. A longer step
#: is halved first. The test uses A² because the effect of the bias on the attitude dominates the
#: norm of A but vanishes in the powers of A.
_MAX_SERIES_NORM = 0.5
#: Relative size of a term at which the series ends; later terms are smaller.
_TERM_TOLERANCE = 1e-18
#: Upper bound on the number of terms of the series.
_MAX_TERMS = 30


@helper
def multiply(A: Floats, B: Floats, factor: float, out: Floats) -> None:
    """Write `factor` times the matrix product A B to the array `out`.

    Loops that skip zeros are faster than BLAS, since the matrices are small and mostly zero.
    """
    n = A.shape[0]
    for i in range(n):
        for j in range(n):
            out[i, j] = 0.0
        for k in range(n):
            entry = factor * A[i, k]
            if entry != 0.0:
                for j in range(n):
                    out[i, j] += entry * B[k, j]


@helper
def infinity_norm(A: Floats) -> float:
    n, largest = A.shape[0], 0.0
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += abs(A[i, j])
        largest = max(largest, total)
    return largest


@helper
def discretize(A: Floats, density: Floats, dt: float) -> tuple[Floats, Floats]:
    """Compute the transition matrix F and the process-noise covariance Q of one filter step.

    F = exp(A dt) and Q is the integral of exp(A s) diag(density) exp(A s)ᵀ over the step, equation
    (8) of docs/explanation/models-and-filter.md.

    The step is halved until the Taylor series of F and Q converge fast, then doubled by F ← F F and
    Q ← Q + F Q Fᵀ. The result equals that of Van Loan (IEEE Transactions on Automatic Control 23
    (1978) 395-404) without the matrix exponential of twice the size.

    Parameters
    ----------
    A : array, shape (n, n)
        Dynamics matrix [1/s].
    density : array, shape (n,)
        Diagonal of the process-noise density.
    dt : float
        Step [s].

    Returns
    -------
    F, Q : arrays, shape (n, n)
    """
    n = A.shape[0]
    scratch = np.zeros((6, n, n))
    term, Q_half_term, F, Q, F_term, Q_term = (
        scratch[0],
        scratch[1],
        scratch[2],
        scratch[3],
        scratch[4],
        scratch[5],
    )
    multiply(A, A, dt * dt, term)
    norm = math.sqrt(infinity_norm(term))
    halvings = max(0, math.ceil(math.log2(norm / _MAX_SERIES_NORM))) if norm > 0.0 else 0
    h = dt / 2.0**halvings
    for i in range(n):
        F[i, i] = F_term[i, i] = 1.0
        Q[i, i] = Q_term[i, i] = density[i] * h
    for order in range(1, _MAX_TERMS + 1):
        multiply(A, F_term, h / order, term)
        multiply(A, Q_term, h / (order + 1), Q_half_term)
        for i in range(n):
            for j in range(n):
                F_term[i, j] = term[i, j]
                F[i, j] += term[i, j]
                Q_term[i, j] = Q_half_term[i, j] + Q_half_term[j, i]
                Q[i, j] += Q_term[i, j]
        if infinity_norm(F_term) < _TERM_TOLERANCE and infinity_norm(
            Q_term
        ) <= _TERM_TOLERANCE * infinity_norm(Q):
            break
    for _ in range(halvings):
        multiply(F, Q, 1.0, term)
        multiply(term, F.T.copy(), 1.0, Q_term)
        for i in range(n):
            for j in range(n):
                Q[i, j] += Q_term[i, j]
        multiply(F, F, 1.0, term)
        for i in range(n):
            for j in range(n):
                F[i, j] = term[i, j]
    return F, Q


@helper
def compute_step_rotation(omega: Floats, dt: float) -> Floats:
    """Return the rotation matrix between the body axes at the start and at the end of a step.

    The matrix converts coordinates from the axes at the start to the axes at the end. The body rate
    is constant. The matrix is exp(-[ω×] dt) by Rodrigues' formula, with series for small angles.

    Parameters
    ----------
    omega : array, shape (3,)
        Body rate [rad/s].
    dt : float
        Step [s].

    Returns
    -------
    array, shape (3, 3)
    """
    x, y, z = omega[0] * dt, omega[1] * dt, omega[2] * dt
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    if angle < 1e-4:
        s, c = 1.0 - square / 6.0, 0.5 - square / 24.0
    else:
        s, c = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
    rotation = np.empty((3, 3))
    rotation[0, 0] = 1.0 - c * (y * y + z * z)
    rotation[1, 1] = 1.0 - c * (x * x + z * z)
    rotation[2, 2] = 1.0 - c * (x * x + y * y)
    rotation[0, 1], rotation[1, 0] = c * x * y + s * z, c * x * y - s * z
    rotation[0, 2], rotation[2, 0] = c * x * z - s * y, c * x * z + s * y
    rotation[1, 2], rotation[2, 1] = c * y * z + s * x, c * y * z - s * x
    return rotation
