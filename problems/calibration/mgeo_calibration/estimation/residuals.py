"""What a solution leaves of the readings: each against all others, and against those before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats, Ints

from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.smoother import Solution, smoothed


@dataclass(frozen=True, eq=False)
class Innovations:
    """Of m readings of a sensor, each predicted from those before it.

    Attributes
    ----------
    samples : array of int, shape (m,)
    whitened : array, shape (m, k)
        L⁻¹ r for the innovation r and its covariance L Lᵀ: standard normal, and independent.
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
    """The Kalman filter that is linear about a solution.

    Attributes
    ----------
    errors : array, shape (N, n)
        Estimates of the n leading driven errors after the readings of each sample.
    covariances : array, shape (N, n, n)
    innovations : tuple of Innovations
        One a sensor.
    """

    errors: Floats
    covariances: Floats
    innovations: tuple[Innovations, ...]


@dataclass(frozen=True, eq=False)
class Residuals:
    """What the estimate leaves of every reading, and how well the attitude is known.

    Attributes
    ----------
    r : array, shape (s, N, 3)
        To the smoothed estimate.
    squares : array, shape (s, N)
        rᵀ (R ∓ H P Hᵀ)⁻¹ r: minus where the reading is part of the estimate, plus where it is not,
        NaN where there is none. Unlike the square of an innovation it can tell an outlier among the
        first readings, too.
    sigma : array, shape (N, 3)
        1-sigma of the smoothed attitude about the body axes [rad].
    """

    r: Floats
    squares: Floats
    sigma: Floats


def residuals(solution: Solution) -> Residuals:
    """Of all readings, also of those that the solution is without."""
    s, N = solution.used.shape
    left = Residuals(np.zeros((s, N, 3)), np.full((s, N), np.nan), np.empty((N, 3)))
    for span, found in smoothed(solution):
        seen, first = span.sightings, span.first
        r, squares = np.zeros(seen.z.shape), np.full(seen.there.shape, np.nan)
        load("residuals").all_others(
            seen.there,
            span.used,
            seen.arrays,
            span.steps.growth,
            solution.e[span.low : span.high],
            solution.common,
            found.given,
            found.slope,
            solution.root,
            first,
            r,
            squares,
            left.sigma[span.low : span.high],
        )
        left.r[:, span.new], left.squares[:, span.new] = r[:, first:], squares[:, first:]
    return left


def filtered(solution: Solution, n: int = 3) -> Filtered:
    """One sample after the other; of the n leading errors, those of the attitude."""
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
    numbers = [len(sensor.noise()) for sensor in solution.batch.suite.sensors]
    seen = zip(map(np.flatnonzero, solution.used), white, numbers, strict=True)
    return Filtered(errors, until, tuple(Innovations(k, w[k, :m]) for k, w, m in seen))


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """Attitude at N samples, and innovations.

    Attributes
    ----------
    times : array, shape (N,)
        [s]
    smoothed, filtered : arrays, shape (N, 3, 3)
        GCRS to body: by all readings, and by those until the sample.
    smoothed_sigma, filtered_sigma : arrays, shape (N, 3)
        1-sigma about the body axes [rad].
    innovations : tuple of Innovations
        One a sensor.
    """

    times: Floats
    smoothed: Floats
    smoothed_sigma: Floats
    filtered: Floats
    filtered_sigma: Floats
    innovations: tuple[Innovations, ...]
