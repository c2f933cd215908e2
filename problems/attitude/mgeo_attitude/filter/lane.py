"""What is done to one lane: a part of every kernel module, like `driver.py`."""

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .discretization import discretize, turn

if TYPE_CHECKING:  # defined above this text in the generated module, see codegen.py
    LANES: int
    CACHE: bool
    N_STATES: int
    N_DYNAMIC: int
    F_ENTRIES: np.ndarray
    ATTITUDE: int
    ROTATION: int
    MONITORS: int
    N_MONITORS: int
    F_SLOT: int
    Q_SLOT: int
    TRACE: int
    PIVOT: int
    N_SLOTS: int


@njit(cache=CACHE)
def workspace():
    """Zeros that begin with a cache line: vectors across two lines load at half the speed."""
    line = 8
    buffer = np.zeros(N_SLOTS * LANES + line)
    skip = -(buffer.ctypes.data // buffer.itemsize) % line
    return buffer[skip : skip + N_SLOTS * LANES]


@njit(cache=CACHE)
def ring(window):
    """Room for the trace of all lanes over a window; a power of two, so that rows are found fast.

    The whole history would not stay in the second-level cache.
    """
    size = 1
    while size <= window:
        size *= 2
    return np.empty((size, LANES))


@njit(cache=CACHE)
def variance_slot(i):
    return i * (i + 1) // 2 + i


@njit(cache=CACHE, error_model="numpy")
def reset(W, lane, variances, monitors, C, recent, now):
    """Put a lane at time zero: initial covariance, body axes along GCRS."""
    for k in range(N_SLOTS):
        W[k * LANES + lane] = 0.0
    total = 0.0
    for i in range(N_STATES):
        W[variance_slot(i) * LANES + lane] = variances[i]
        total += C[len(C) - N_STATES + i] * variances[i]
    for i in range(3):
        W[(ATTITUDE + 4 * i) * LANES + lane] = 1.0
    for i in range(N_MONITORS):
        W[(MONITORS + i) * LANES + lane] = monitors[i]
    recent[now, lane] = total


@njit(cache=CACHE, error_model="numpy")
def load_maneuver(W, lane, omega, dynamics, density, dt):
    """Write the maneuver's exact transition, process noise and turn per step to a lane."""
    A = dynamics[0] + omega[0] * dynamics[1] + omega[1] * dynamics[2] + omega[2] * dynamics[3]
    F, Q = discretize(A, density, dt)
    rotation = turn(omega, dt)
    for k in range(len(F_ENTRIES)):
        W[(F_SLOT + k) * LANES + lane] = F[F_ENTRIES[k, 0], F_ENTRIES[k, 1]]
    for i in range(N_DYNAMIC):
        for j in range(i + 1):
            W[(Q_SLOT + i * (i + 1) // 2 + j) * LANES + lane] = Q[i, j]
    for i in range(3):
        for j in range(3):
            W[(ROTATION + 3 * i + j) * LANES + lane] = rotation[i, j]


@njit(cache=CACHE)
def save(W, lane, recent, now, n, snapshot):
    """Store a lane's covariance, attitude, monitors and the last n values of its trace."""
    for j in range(ROTATION):
        snapshot[j] = W[j * LANES + lane]
    for j in range(n):
        snapshot[ROTATION + j] = recent[(now - j) % len(recent), lane]


@njit(cache=CACHE)
def restore(W, lane, recent, now, n, snapshot):
    """Inverse of `save`."""
    for j in range(ROTATION):
        W[j * LANES + lane] = snapshot[j]
    for j in range(n):
        recent[(now - j) % len(recent), lane] = snapshot[ROTATION + j]


@njit(cache=CACHE)
def converged(recent, lane, now, window, decrease, allow_rise):
    """Whether the trace fell by less than the least decrease, and did not rise, equation (6).

    A rise may be allowed. A trace of NaN has nothing left to wait for.
    """
    before = recent[(now - window) & (len(recent) - 1), lane]
    fall = before - recent[now, lane]
    return not (fall >= decrease * before or (fall < 0.0 and not allow_rise))
