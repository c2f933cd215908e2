"""What corrects an estimate: a part of every generated module, like `driver.py`."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit

from .algebra import cholesky, compose, copy, forward, transform, turn_back, turn_errors

if TYPE_CHECKING:  # defined above this text in the generated module, see codegen.py
    CACHE: bool
    N_STATES: int
    ROTATIONS: np.ndarray
    IS_ROTATION: np.ndarray
    N_LOCAL: np.ndarray
    LOCAL: np.ndarray
    N_CURVED: np.ndarray
    CURVED: np.ndarray

    def innovation(sensor: int, y: Any, v: Any, C: Any, x: Any, r: Any, H: Any, B: Any) -> None:
        """Innovation r with its derivatives."""


@njit(error_model="numpy", cache=CACHE)
def correct(C, x, e, work):
    """Take an error e out of an estimate, in place: attitude C and states x."""
    turn_back(C, e, 0, work)
    for i in range(3, N_STATES):
        if not IS_ROTATION[i]:
            x[i] += e[i]
    for block in range(1, len(ROTATIONS)):
        compose(1.0, x, e, ROTATIONS[block], x)


@njit(error_model="numpy", cache=CACHE)
def error_of(C, x, true_C, true_x, e):
    """Write to e the error that `correct` would have to take out."""
    for i in range(N_STATES):
        e[i] = true_x[i] - x[i]
    for block in range(1, len(ROTATIONS)):
        compose(-1.0, x, true_x, ROTATIONS[block], e)
    trace = 1.0
    for i in range(3):
        e[i] = 0.0
        for j in range(3):
            trace += C[i, j] * true_C[i, j]
    for j in range(3):  # Ĉ Cᵀ = R(θ)
        e[0] += C[2, j] * true_C[1, j] - C[1, j] * true_C[2, j]
        e[1] += C[0, j] * true_C[2, j] - C[2, j] * true_C[0, j]
        e[2] += C[1, j] * true_C[0, j] - C[0, j] * true_C[1, j]
    for i in range(3):
        e[i] *= 2.0 / trace


@njit(error_model="numpy", cache=CACHE)
def curvature(P, sensor, B, T, BT, shift, S):
    """Add what the innovation's second derivatives B cause to its mean and covariance S.

    For e ~ N(0, P) the term ½ eᵀ B e has the mean ½ tr(B P) and covariance ½ tr(B P B' P).
    """
    n = N_CURVED[sensor]
    for a in range(n):
        for b in range(n):
            T[a, b] = P[LOCAL[sensor, CURVED[sensor, a]], LOCAL[sensor, CURVED[sensor, b]]]
    for q in range(3):
        for a in range(n):
            for b in range(n):
                total = 0.0
                for c in range(n):
                    total += B[q, min(a, c), max(a, c)] * T[c, b]
                BT[q, a, b] = total
            shift[q] += 0.5 * BT[q, a, a]
        for p in range(q + 1):
            total = 0.0
            for a in range(n):
                for b in range(n):
                    total += BT[q, a, b] * BT[p, b, a]
            S[q, p] += 0.5 * total


@njit(error_model="numpy", cache=CACHE)
def update(C, x, P, sensor, y, noise, v, R, options, work):
    """Update an estimate with a sensor's readings y and feed the error back; returns the NIS.

    Parameters
    ----------
    C, x, P : estimate, in place
    noise : array, shape (3,)
        Measurement noise, in the innovation.
    v : array, shape (3,)
        Reference vector, GCRS.
    R : array, shape (3,)
        Variances of the noise.
    options : array of int
        See `estimator.Estimator`.
    work : arrays
        See `workspace`.
    """
    e, C_now, x_now, x_aligned, M, body, r, z, H, B, T, BT, PHt, G, S, L, w = work
    n, nis = N_LOCAL[sensor], 0.0
    for i in range(N_STATES):
        e[i] = 0.0
    for iteration in range(options[3]):
        copy(C, C_now)
        for i in range(N_STATES):
            x_now[i] = x[i]
        if iteration > 0:
            correct(C_now, x_now, e, M)
        transform(C_now, v, body)
        innovation(sensor, y, body, C_now, x_now, r, H, B)
        for q in range(3):
            z[q] = r[q] + noise[q]
        if options[0]:
            for i in range(N_STATES):
                x_aligned[i] = 0.0 if IS_ROTATION[i] else x_now[i]
            innovation(sensor, y, body, C_now, x_aligned, r, H, B)
        for i in range(N_STATES):
            for q in range(3):
                total = 0.0
                for c in range(n):
                    total += P[i, LOCAL[sensor, c]] * H[q, c]
                PHt[i, q] = total
        for q in range(3):
            for c in range(n):
                z[q] += H[q, c] * e[LOCAL[sensor, c]]
            for p in range(q + 1):
                total = R[q] if p == q else 0.0
                for c in range(n):
                    total += H[q, c] * PHt[LOCAL[sensor, c], p]
                S[q, p] = total
        if options[1]:
            curvature(P, sensor, B, T, BT, z, S)
        cholesky(S, L)
        forward(L, z, w)
        if iteration == 0:
            nis = w[0] ** 2 + w[1] ** 2 + w[2] ** 2
        for i in range(N_STATES):
            forward(L, PHt[i], G[i])
            e[i] = G[i, 0] * w[0] + G[i, 1] * w[1] + G[i, 2] * w[2]
    for i in range(N_STATES):
        for j in range(i + 1):
            P[i, j] -= G[i, 0] * G[j, 0] + G[i, 1] * G[j, 1] + G[i, 2] * G[j, 2]
            P[j, i] = P[i, j]
    correct(C, x, e, M)
    if options[2]:
        for block in range(len(ROTATIONS)):
            turn_errors(P, ROTATIONS[block], e)
    return nis


@njit(error_model="numpy", cache=CACHE)
def workspace():
    """Arrays that `update` works in."""
    n, m, c = N_STATES, LOCAL.shape[1], CURVED.shape[1]
    return (
        np.empty(n),  # e
        np.empty((3, 3)),  # C_now
        np.empty(n),  # x_now
        np.empty(n),  # x_aligned
        np.empty((3, 3)),  # M
        np.empty(3),  # body
        np.empty(3),  # r
        np.empty(3),  # z
        np.empty((3, m)),  # H
        np.empty((3, c, c)),  # B
        np.empty((c, c)),  # T
        np.empty((3, c, c)),  # BT
        np.empty((n, 3)),  # PHt
        np.empty((n, 3)),  # G
        np.empty((3, 3)),  # S
        np.empty((3, 3)),  # L
        np.empty(3),  # w
    )
