"""Exact discretization at constant rate, compiled; once per maneuver, not per step."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Norm of A dt up to which the series is summed directly; beyond, the step is halved first.
_SERIES_NORM = 0.5
#: Terms after this bound on their size, relative to the first, are left out.
_NEGLIGIBLE = 1e-18
#: Most terms the series can need: 1 / 20! is below 1e-18.
_TERMS = 20


@njit(cache=True, error_model="numpy")
def discretize(A: Floats, density: Floats, dt: float) -> tuple[Floats, Floats]:
    """F = exp(A dt) and Q = ∫ exp(A s) diag(density) exp(A s)ᵀ ds over one step.

    Taylor series of both (Q' = A Q + Q Aᵀ + diag(density)) on a step halved until the series
    converges fast, then doubled: F ← F F, Q ← Q + F Q Fᵀ. The same integral as Van Loan's (IEEE
    TAC 23, 1978, 395), without the 2n x 2n matrix exponential.

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
    norm = 0.0
    for i in range(n):
        norm = max(norm, np.sum(np.abs(A[i])) * dt)
    halvings = max(0, math.ceil(math.log2(norm / _SERIES_NORM))) if norm > 0.0 else 0
    h = dt / 2.0**halvings
    F, Q, term = np.eye(n), np.diag(density * h), np.empty((n, n))
    F_term, Q_term = np.eye(n), np.diag(density * h)
    bound = 1.0
    for m in range(1, _TERMS + 1):
        _multiply(A, F_term, h / m, term)
        F_term, term = term, F_term
        _multiply(A, Q_term, h / (m + 1), term)
        for i in range(n):
            for j in range(n):
                F[i, j] += F_term[i, j]
                Q_term[i, j] = term[i, j] + term[j, i]
                Q[i, j] += Q_term[i, j]
        bound *= 2.0 * norm / 2.0**halvings / m
        if bound < _NEGLIGIBLE:
            break
    FQ, FQFt = np.empty((n, n)), np.empty((n, n))
    for _ in range(halvings):
        _multiply(F, Q, 1.0, FQ)
        _multiply(FQ, F.T.copy(), 1.0, FQFt)
        Q += FQFt
        _multiply(F, F, 1.0, term)
        F, term = term, F
    return F, Q


@njit(cache=True, error_model="numpy")
def _multiply(A: Floats, B: Floats, factor: float, out: Floats) -> None:
    """out ← factor A B. At this size plain loops beat a BLAS call, and never change in order."""
    n = A.shape[0]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += A[i, k] * B[k, j]
            out[i, j] = factor * total


@njit(cache=True, error_model="numpy")
def turn(omega: Floats, dt: float) -> Floats:
    """exp(-[ω×] dt): how a step at body rate `omega` [rad/s] turns the GCRS-to-body matrix.

    Rodrigues' formula, with the series of its coefficients near zero.

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
    K = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    K2 = np.array(
        [
            [-(y * y + z * z), x * y, x * z],
            [x * y, -(x * x + z * z), y * z],
            [x * z, y * z, -(x * x + y * y)],
        ]
    )
    rotation: Floats = np.eye(3) + s * K + c * K2
    return rotation
