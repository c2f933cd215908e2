"""Bounds for gyro errors, and the filter recursion of errors that no attitude changes."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.lower_bound.curves import apply_water_filling


class GyroErrorDynamics(NamedTuple):
    """Dynamics of a gyro error e that drives the attitude error θ.

    Attributes
    ----------
    gain : float
        Largest spectral norm of M in θ' = -[ω×]θ + M e.
    decay : float
        λ in e' = -λ e [1/s].
    noise_density : float
        Noise density of e.
    """

    gain: float
    decay: float
    noise_density: float


def rate_box_corners(max_rates: Floats) -> Floats:
    """Return the corners of the box of rates up to `max_rates` about each axis, shape (8, 3).

    The norm of a matrix that is linear in the rate is largest at a corner.
    """
    return np.array(list(product((-1.0, 1.0), repeat=3))) * max_rates


def bound_through_attitude(
    times: Floats,
    drift: GyroErrorDynamics,
    initial_information: Floats,
    attitude_information: Floats,
    initial_attitude_information: float,
    angle_random_walk: float,
) -> Floats:
    """Return least variances of a gyro error observed through the attitude, equation (25).

    Parameters
    ----------
    times : array, shape (n,)
        Times [s].
    drift : Drift
    initial_information : array, shape (3, 3)
        Initial information about the error.
    attitude_information : array, shape (n,)
        Trace of the attitude information in each sample.
    initial_attitude_information : float
        Trace of the initial attitude information; infinite to assume a known attitude.
    angle_random_walk : float
        Density of the angle random walk.

    Returns
    -------
    array, shape (n, 3)
    """
    none, once, twice = (np.cumsum(attitude_information * times**power) for power in range(3))
    mean = (
        once / (none + initial_attitude_information)
        if np.isfinite(initial_attitude_information)
        else np.zeros(len(times))
    )
    spread = np.maximum(twice - once * mean, 0.0)
    along = (
        3.0 * times / angle_random_walk
    )  # This is the information with an always known attitude.
    both = spread + along
    gained = drift.gain**2 * spread * along / np.where(both > 0.0, both, 1.0)
    return np.exp(-2.0 * drift.decay * times)[:, None] * apply_water_filling(
        initial_information, gained
    )


def bound_with_known_attitude(
    times: Floats, drift: GyroErrorDynamics, initial_information: Floats, angle_random_walk: float
) -> Floats:
    """Return least variances of a gyro error with M = -I if the attitude is always known.

    The variances solve p' = -2 λ p + q - p² / r from each eigenvalue p of the initial covariance,
    equation (26).

    Parameters
    ----------
    times, drift, initial_information, angle_random_walk
        See `bound_through_attitude`.
    """
    start = 1.0 / np.linalg.eigvalsh(initial_information)
    rate = np.sqrt(drift.decay**2 + drift.noise_density / angle_random_walk)
    x = (np.tanh(rate * times) / rate if rate > 0.0 else times)[:, None]
    rising = start * (1.0 - drift.decay * x) + drift.noise_density * x
    return rising / (1.0 + (drift.decay + start / angle_random_walk) * x)


def run_covariance_recursion(
    initial_covariance: Floats, decay: Floats, noise: Floats, information: Floats
) -> Floats:
    """Return the covariance of a filter with diagonal F and Q after each sample, equation (22).

    Each step computes P⁻ = F P F + Q and P = ((P⁻)⁻¹ + J)⁻¹.

    Parameters
    ----------
    initial_covariance : array, shape (k, k)
        P at the first sample.
    decay, noise : arrays, shape (k,)
        Diagonals of F and Q of a step.
    information : array, shape (n, k, k)
        J of each sample; that of the first sample is not used.

    Returns
    -------
    array, shape (n, k, k)
    """
    covariances = np.empty(information.shape)
    covariances[0] = P = initial_covariance
    decay_product, process_noise, unit = (
        np.outer(decay, decay),
        np.diag(noise),
        np.eye(len(initial_covariance)),
    )
    measured: Bools = np.asarray(information.any(axis=(1, 2)))
    for k in range(1, len(information)):
        P = decay_product * P + process_noise
        if measured[k]:
            P = np.linalg.solve(unit + P @ information[k], P)
            P = 0.5 * (P + P.T)
        covariances[k] = P
    return covariances
