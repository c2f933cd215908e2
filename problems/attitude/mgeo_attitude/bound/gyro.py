"""How well errors of a gyro can be known at best: the filter of what no attitude changes."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from mgeo_attitude._compiled import entry
from mgeo_attitude._typing import Floats
from mgeo_attitude.bound.curves import filled


class Drift(NamedTuple):
    """How an error e of the gyro drives the attitude error, which sensors see.

    Attributes
    ----------
    gain : float
        Greatest spectral norm of M in θ' = -[ω×]θ + M e.
    decay : float
        λ in e' = -λ e [1/s].
    walk : float
        Density of the noise that drives e.
    """

    gain: float
    decay: float
    walk: float


def corners(greatest: Floats) -> Floats:
    """Corners of the box of rates up to `greatest` about each axis, shape (8, 3).

    A norm of what is linear in the rate is greatest at one of them.
    """
    return np.array(list(product((-1.0, 1.0), repeat=3))) * greatest


def through_attitude(
    times: Floats, drift: Drift, known: Floats, told: Floats, start: float, walk: float
) -> Floats:
    """Least variances of an error, seen through the attitude that it turns: equation (25).

    Parameters
    ----------
    times : array, shape (n,)
        [s]
    known : array, shape (3, 3)
        Information about the error at the start.
    told : array, shape (n,)
        Trace of what each sample tells of the attitude.
    start : float
        Trace of the information about the attitude at the start; infinite if it counts as known.
    walk : float
        Density of the angle random walk.

    Returns
    -------
    array, shape (n, 3)
    """
    none, once, twice = (np.cumsum(told * times**power) for power in range(3))
    mean = once / (none + start) if np.isfinite(start) else np.zeros(len(times))
    spread = np.maximum(twice - once * mean, 0.0)
    along = 3.0 * times / walk  # what the attitude would tell if it were known all the way
    both = spread + along
    gained = drift.gain**2 * spread * along / np.where(both > 0.0, both, 1.0)
    faded: Floats = np.exp(-2.0 * drift.decay * times)[:, None] * filled(known, gained)
    return faded


def along_attitude(times: Floats, drift: Drift, known: Floats, walk: float) -> Floats:
    """The same if the attitude is known all the way, of an error with M = -I: equation (26).

    It is the solution of p' = -2 λ p + q - p² / r from each eigenvalue p of the covariance.
    """
    start = 1.0 / np.linalg.eigvalsh(known)
    rate = np.sqrt(drift.decay**2 + drift.walk / walk)
    x = (np.tanh(rate * times) / rate if rate > 0.0 else times)[:, None]
    rising = start * (1.0 - drift.decay * x) + drift.walk * x
    variances: Floats = rising / (1.0 + (drift.decay + start / walk) * x)
    return variances


def recursion(start: Floats, decay: Floats, noise: Floats, information: Floats) -> Floats:
    """P⁻ = F P F + Q, then P = ((P⁻)⁻¹ + J)⁻¹, with diagonal F and Q: equation (22).

    Parameters
    ----------
    start : array, shape (k, k)
        P at the first sample.
    decay, noise : arrays, shape (k,)
        Diagonals of F and Q of a step.
    information : array, shape (n, k, k)
        J of each sample; that of the first is not used.

    Returns
    -------
    array, shape (n, k, k)
        P after each sample.
    """
    found = np.empty(information.shape)
    told = np.asarray(information, dtype=float)
    _covariances(np.array(start, dtype=float, order="C"), decay.copy(), noise.copy(), told, found)
    return found


@entry("void(float64[:,::1], float64[::1], float64[::1], float64[:,:,:], float64[:,:,::1])")
def _covariances(start: Floats, decay: Floats, noise: Floats, told: Floats, out: Floats) -> None:
    """`recursion`, compiled: a limit has one, a free start thousands. Written to `out`."""
    k = len(start)
    A = np.empty((k, 2 * k))
    for i in range(k):  # numba would take three seconds more for `out[0] = start`
        for j in range(k):
            out[0, i, j] = start[i, j]
    for step in range(1, len(told)):
        before, P = out[step - 1], out[step]
        some = False
        for i in range(k):
            for j in range(k):
                P[i, j] = before[i, j] * (decay[i] * decay[j])
                some |= told[step, i, j] != 0.0
            P[i, i] += noise[i]
        if some:  # P ← (1 + P J)⁻¹ P, by Gauss and Jordan with partial pivoting
            for i in range(k):
                for j in range(k):
                    total = 1.0 if i == j else 0.0
                    for m in range(k):
                        total += P[i, m] * told[step, m, j]
                    A[i, j], A[i, k + j] = total, P[i, j]
            for c in range(k):
                pivot = c
                for i in range(c + 1, k):
                    if abs(A[i, c]) > abs(A[pivot, c]):
                        pivot = i
                if pivot != c:
                    for j in range(2 * k):
                        A[c, j], A[pivot, j] = A[pivot, j], A[c, j]
                factor = 1.0 / A[c, c]
                for j in range(c, 2 * k):
                    A[c, j] *= factor
                for i in range(k):
                    if i != c and A[i, c] != 0.0:
                        factor = A[i, c]
                        for j in range(c, 2 * k):
                            A[i, j] -= factor * A[c, j]
            for i in range(k):
                for j in range(k):
                    P[i, j] = 0.5 * (A[i, k + j] + A[j, k + i])
