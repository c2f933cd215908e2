"""Exact discretization at a constant rate, compiled; runs once per maneuver, not per step."""

from __future__ import annotations

import math

import numpy as np

from mgeo_attitude._compiled import helper
from mgeo_attitude._typing import Floats

#: Largest |(A dt)²|^½ for which the series is summed directly; a longer step is halved first. The
#: test uses A² because the effect of bias on attitude dominates A but vanishes in its powers.
_MAX_SERIES_NORM = 0.5
#: Relative size of a term at which the series ends; later terms are smaller.
_TERM_TOLERANCE = 1e-18
#: Upper bound on the number of terms of the series.
_MAX_TERMS = 30


@helper
def multiply(A: Floats, B: Floats, factor: float, out: Floats) -> None:
    """Compute out ← factor A B.

    Plain loops that skip zeros are faster here than BLAS: the matrices are small and mostly zero.
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
    """Return the infinity norm of A (largest absolute row sum), without temporary arrays."""
    n, largest = A.shape[0], 0.0
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += abs(A[i, j])
        largest = max(largest, total)
    return largest


@helper
def discretize(A: Floats, density: Floats, dt: float) -> tuple[Floats, Floats]:
    """Return transition F and process noise Q of one step, equation (7).

    F = exp(A dt) and Q = ∫ exp(A s) diag(density) exp(A s)ᵀ ds.

    The step is halved until the Taylor series of F and of Q' = A Q + Q Aᵀ + diag(density) converge
    fast, then doubled: F ← F F, Q ← Q + F Q Fᵀ. The result equals Van Loan's (IEEE TAC 23, 1978,
    395) without the 2n x 2n matrix exponential.

    Parameters
    ----------
    A : array, shape (n, n)
        Dynamics [1/s].
    density : array, shape (n,)
        Diagonal of the process-noise density.
    dt : float
        Step [s].

    Returns
    -------
    F, Q : arrays, shape (n, n)
    """
    n = A.shape[0]
    room = np.zeros((6, n, n))
    term, other, F, Q, F_term, Q_term = room[0], room[1], room[2], room[3], room[4], room[5]
    multiply(A, A, dt * dt, term)
    size = math.sqrt(infinity_norm(term))
    halvings = max(0, math.ceil(math.log2(size / _MAX_SERIES_NORM))) if size > 0.0 else 0
    h = dt / 2.0**halvings
    for i in range(n):
        F[i, i] = F_term[i, i] = 1.0
        Q[i, i] = Q_term[i, i] = density[i] * h
    for m in range(1, _MAX_TERMS + 1):
        multiply(A, F_term, h / m, term)
        multiply(A, Q_term, h / (m + 1), other)
        for i in range(n):
            for j in range(n):
                F_term[i, j] = term[i, j]
                F[i, j] += term[i, j]
                Q_term[i, j] = other[i, j] + other[j, i]
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
    """Return exp(-[ω×] dt), the change of the GCRS-to-body matrix in a step at body rate `omega`.

    Rodrigues' formula; for small angles the coefficients are series.

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
