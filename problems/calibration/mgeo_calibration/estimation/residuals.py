"""What a solution leaves of the readings: each against all others, and against those before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats, Ints

from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.smoother import Solution, Spread


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
    errors : array, shape (N, d)
        Estimated driven errors after the readings of each sample.
    covariances : array, shape (N, d, d)
    innovations : tuple of Innovations
        One a sensor.
    """

    errors: Floats
    covariances: Floats
    innovations: tuple[Innovations, ...]


def residuals(solution: Solution, found: Spread) -> tuple[Floats, Floats]:
    """What the estimate leaves of every reading, and its square over what all others allow.

    That is rᵀ (R ∓ H P Hᵀ)⁻¹ r for the residual r to the smoothed estimate: minus where the reading
    is part of the estimate, plus where it is not. Unlike an innovation it can tell an outlier among
    the first readings, too.

    Returns
    -------
    r : array, shape (s, N, 3)
    squares : array, shape (s, N), NaN where there is no reading
    """
    seen = solution.sightings
    r, squares = np.zeros(seen.z.shape), np.full(seen.there.shape, np.nan)
    load("residuals").all_others(
        seen.there,
        solution.used,
        seen.arrays,
        solution.steps.growth,
        solution.e,
        solution.common,
        found.given,
        found.slope,
        solution.root,
        r,
        squares,
    )
    return r, squares


def filtered(solution: Solution) -> Filtered:
    """One sample after the other."""
    N, d = solution.e.shape
    errors, until = np.empty((N, d)), np.empty((N, d, d))
    return Filtered(errors, until, _innovations(solution, errors, until))


def innovations(solution: Solution) -> tuple[Innovations, ...]:
    """Those of `filtered` alone, in two thirds of the time."""
    return _innovations(solution, np.empty((0, 0)), np.empty((0, 0, 0)))


def _innovations(solution: Solution, errors: Floats, until: Floats) -> tuple[Innovations, ...]:
    """Of each sensor; errors and covariances are written, unless they are empty."""
    r, J = solution.prior
    root, white = np.linalg.inv(J), np.empty_like(solution.sightings.z)
    load("residuals").those_before(
        solution.used, solution.readings, solution.kept, root, root @ r, white, errors, until
    )
    found = (np.flatnonzero(used) for used in solution.used)
    numbers = solution.sightings.numbers
    return tuple(
        Innovations(k, white[index, k, :m])
        for index, (k, m) in enumerate(zip(found, numbers, strict=True))
    )
