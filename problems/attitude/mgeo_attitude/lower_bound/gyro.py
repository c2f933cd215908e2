"""Lower bounds of gyro errors, and the filter recursion for attitude-independent information."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.lower_bound.curves import apply_water_filling


class GyroErrorDynamics(NamedTuple):
    """Dynamics of a gyro error that causes attitude errors, such as the gyro bias.

    Attributes
    ----------
    gain : float
        Largest spectral norm of M in the attitude error dynamics θ' = -[ω×]θ + M e.
    decay : float
        Decay rate λ in e' = -λ e [1/s].
    noise_density : float
        Process-noise density of e.
    """

    gain: float
    decay: float
    noise_density: float


def rate_box_corners(max_rates: Floats) -> Floats:
    """Return the eight corners of the box of allowed body rates, shape (8, 3).

    The norm of a matrix that is linear in the rate is largest at a corner of the box.
    """
    return np.array(list(product((-1.0, 1.0), repeat=3))) * max_rates


def bound_through_attitude(
    times: Floats,
    dynamics: GyroErrorDynamics,
    initial_information: Floats,
    attitude_information: Floats,
    initial_attitude_information: float,
    angle_random_walk: float,
) -> Floats:
    """Bound the covariance eigenvalues of a gyro error that is measured only through the attitude.

    See equation (6) of docs/explanation/lower-bound.md.

    Parameters
    ----------
    times : array, shape (n,)
        Times [s].
    dynamics : GyroErrorDynamics
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
    zeroth, first, second = (np.cumsum(attitude_information * times**power) for power in range(3))
    mean = (
        first / (zeroth + initial_attitude_information)
        if np.isfinite(initial_attitude_information)
        else np.zeros(len(times))
    )
    spread = np.maximum(second - first * mean, 0.0)
    # This is the information if the attitude is always known.
    known = 3.0 * times / angle_random_walk
    total = spread + known
    gained = dynamics.gain**2 * spread * known / np.where(total > 0.0, total, 1.0)
    return np.exp(-2.0 * dynamics.decay * times)[:, None] * apply_water_filling(
        initial_information, gained
    )


def bound_with_known_attitude(
    times: Floats,
    dynamics: GyroErrorDynamics,
    initial_information: Floats,
    angle_random_walk: float,
) -> Floats:
    """Bound the covariance eigenvalues of a gyro bias, assuming that the attitude is always known.

    The variances solve the Riccati equation p' = -2 λ p + q - p² / r, equation (7), with the decay
    rate λ and noise density q of the error and the angle random walk r. The initial values p are
    the eigenvalues of the initial covariance.

    Parameters
    ----------
    times, dynamics, initial_information, angle_random_walk
        See `bound_through_attitude`.
    """
    start = 1.0 / np.linalg.eigvalsh(initial_information)
    rate = np.sqrt(dynamics.decay**2 + dynamics.noise_density / angle_random_walk)
    x = (np.tanh(rate * times) / rate if rate > 0.0 else times)[:, None]
    numerator = start * (1.0 - dynamics.decay * x) + dynamics.noise_density * x
    return numerator / (1.0 + (dynamics.decay + start / angle_random_walk) * x)


def run_covariance_recursion(
    initial_covariance: Floats, decay: Floats, noise: Floats, information: Floats
) -> Floats:
    """Run a covariance recursion with diagonal transition and process-noise matrices.

    Return the covariance after each sample. See equation (4) of docs/explanation/lower-bound.md.

    Each step computes P⁻ = F P F + Q and P = ((P⁻)⁻¹ + J)⁻¹ with the information J of a sample.

    Parameters
    ----------
    initial_covariance : array, shape (k, k)
        P at the first sample.
    decay, noise : arrays, shape (k,)
        Diagonals of F and Q of a step.
    information : array, shape (n, k, k)
        J of each sample. The value of the first sample is not used.

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
