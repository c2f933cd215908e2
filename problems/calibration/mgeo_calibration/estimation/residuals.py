"""Residuals and innovations of a smoother solution.

Used for outlier rejection, consistency tests and the history that a calibration reports.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats, Ints

from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.smoother import Solution, smoothed


@dataclass(frozen=True, eq=False)
class Innovations:
    """Whitened innovations of one sensor.

    Each of the m readings is predicted from all earlier readings.

    Attributes
    ----------
    samples : array of int, shape (m,)
        Sample index of each reading.
    whitened : array, shape (m, k)
        L⁻¹ r for the innovation r with covariance L Lᵀ. Independent and standard normal if the
        model is correct.
    """

    samples: Ints
    whitened: Floats

    @property
    def nis(self) -> Floats:
        """Normalized innovation squared, shape (m,)."""
        nis: Floats = (self.whitened**2).sum(axis=1)
        return nis


@dataclass(frozen=True, eq=False)
class Filtered:
    """Estimates of the Kalman filter linearized about a smoother solution.

    Attributes
    ----------
    errors : array, shape (N, n)
        Estimated errors of the first n stochastic states after the readings of each sample.
    covariances : array, shape (N, n, n)
        Covariance of these errors.
    innovations : tuple of Innovations
        Innovations of each sensor.
    """

    errors: Floats
    covariances: Floats
    innovations: tuple[Innovations, ...]


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of all readings and the 1-sigma of the smoothed attitude.

    Attributes
    ----------
    r : array, shape (s, N, 3)
        Reading minus its prediction from the smoothed estimate.
    squares : array, shape (s, N)
        Normalized residual squared, rᵀ V⁻¹ r; NaN where a sensor has no reading. V = R - H P Hᵀ for
        a reading that the solution uses, and V = R + H P Hᵀ for a rejected reading. Unlike the
        normalized innovation squared, it also detects an outlier among the first readings.
    sigma : array, shape (N, 3)
        1-sigma of the smoothed attitude about the body axes [rad].
    """

    r: Floats
    squares: Floats
    sigma: Floats


def residuals(solution: Solution) -> Residuals:
    """Compute the residuals of all readings, including the rejected readings."""
    s, N = solution.used.shape
    left = Residuals(np.zeros((s, N, 3)), np.full((s, N), np.nan), np.empty((N, 3)))
    for span, result in smoothed(solution):
        seen, first = span.sightings, span.first
        r, squares = np.zeros(seen.z.shape), np.full(seen.there.shape, np.nan)
        load("residuals").all_others(
            seen.there,
            span.used,
            seen.arrays,
            span.steps.growth,
            solution.e[span.low : span.high],
            solution.common,
            result.given,
            result.slope,
            solution.root,
            first,
            r,
            squares,
            left.sigma[span.low : span.high],
        )
        left.r[:, span.new], left.squares[:, span.new] = r[:, first:], squares[:, first:]
    return left


def filtered(solution: Solution, n: int = 3) -> Filtered:
    """Compute the filter estimates and innovations of a smoother solution.

    Parameters
    ----------
    solution : Solution
    n : int
        Number of leading stochastic states to return. The default returns the attitude errors.

    Returns
    -------
    Filtered
    """
    r, J = solution.prior
    s, N = solution.used.shape
    root = np.linalg.inv(J)
    common, white = root @ r, np.empty((s, N, 3))
    errors, until = np.empty((N, n)), np.empty((N, n, n))
    for span in solution.spans():
        own, first = slice(span.low, span.high), span.first
        each = np.empty(span.sightings.z.shape)
        load("residuals").those_before(
            span.used, span.readings, span.kept, root, common, first, each, errors[own], until[own]
        )
        white[:, span.new] = each[:, first:]
    numbers = [len(sensor.noise_sigmas()) for sensor in solution.batch.suite.sensors]
    seen = zip(map(np.flatnonzero, solution.used), white, numbers, strict=True)
    return Filtered(errors, until, tuple(Innovations(k, w[k, :m]) for k, w, m in seen))


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """Smoothed and filtered attitude at N samples, with the innovations.

    Attributes
    ----------
    times : array, shape (N,)
        Time of each sample [s].
    smoothed, filtered : arrays, shape (N, 3, 3)
        Rotation matrices from GCRS to body. The smoothed attitude uses all readings, the filtered
        attitude only the readings up to each sample.
    smoothed_sigma, filtered_sigma : arrays, shape (N, 3)
        1-sigma about the body axes [rad].
    innovations : tuple of Innovations
        Innovations of each sensor.
    """

    times: Floats
    smoothed: Floats
    smoothed_sigma: Floats
    filtered: Floats
    filtered_sigma: Floats
    innovations: tuple[Innovations, ...]
