"""How well errors of a gyro can be known at best: the filter of what no attitude changes."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Bools, Floats
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
    return np.exp(-2.0 * drift.decay * times)[:, None] * filled(known, gained)


def along_attitude(times: Floats, drift: Drift, known: Floats, walk: float) -> Floats:
    """The same if the attitude is known all the way, of an error with M = -I: equation (26).

    It is the solution of p' = -2 λ p + q - p² / r from each eigenvalue p of the covariance.
    """
    start = 1.0 / np.linalg.eigvalsh(known)
    rate = np.sqrt(drift.decay**2 + drift.walk / walk)
    x = (np.tanh(rate * times) / rate if rate > 0.0 else times)[:, None]
    rising = start * (1.0 - drift.decay * x) + drift.walk * x
    return rising / (1.0 + (drift.decay + start / walk) * x)


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
    found[0] = P = start
    faded, added, unit = np.outer(decay, decay), np.diag(noise), np.eye(len(start))
    measured: Bools = np.asarray(information.any(axis=(1, 2)))
    for k in range(1, len(information)):
        P = faded * P + added
        if measured[k]:
            P = np.linalg.solve(unit + P @ information[k], P)
            P = 0.5 * (P + P.T)
        found[k] = P
    return found
