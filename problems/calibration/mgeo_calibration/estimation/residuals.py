"""Residuals and innovations of a smoother solution.

They are used for outlier rejection, consistency tests and the history of a calibration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats, Ints

from mgeo_calibration.estimation.kernels import load_compiled_module
from mgeo_calibration.estimation.smoother import Solution, smooth_covariances


@dataclass(frozen=True, eq=False)
class Innovations:
    """Whitened Kalman filter innovations of one sensor.

    Each of the m readings is predicted from all earlier readings.

    Attributes
    ----------
    samples : array of int, shape (m,)
        Sample index of each reading.
    whitened_values : array, shape (m, k)
        L⁻¹ r for the innovation r with covariance L Lᵀ. Independent and standard normal if the
        model is correct.
    """

    samples: Ints
    whitened_values: Floats

    @property
    def nis(self) -> Floats:
        """Normalized innovation squared of each reading, shape (m,)."""
        nis: Floats = (self.whitened_values**2).sum(axis=1)
        return nis


@dataclass(frozen=True, eq=False)
class FilterEstimates:
    """Kalman filter estimates at N samples, each based on the readings up to that sample.

    The filter is linearized about a smoother solution.

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
    """Residuals of all readings after smoothing, and the 1-sigma of the smoothed attitude.

    Attributes
    ----------
    values : array, shape (s, N, 3)
        Reading minus its prediction from the smoothed estimate.
    normalized_squares : array, shape (s, N)
        Normalized residual squared, rᵀ V⁻¹ r; NaN where a sensor has no reading. V = R - H P Hᵀ for
        a reading that the solution uses, and V = R + H P Hᵀ for a rejected reading. Unlike the
        normalized innovation squared, it also detects an outlier among the first readings.
    sigma : array, shape (N, 3)
        1-sigma of the smoothed attitude about the body axes [rad].
    """

    values: Floats
    normalized_squares: Floats
    sigma: Floats


def compute_residuals(solution: Solution) -> Residuals:
    """Compute the residuals of all readings after smoothing.

    The residuals of rejected readings are included.

    Parameters
    ----------
    solution : Solution
        Solution with N samples and s sensors.

    Returns
    -------
    Residuals
    """
    s, N = solution.is_used.shape
    residuals = Residuals(np.zeros((s, N, 3)), np.full((s, N), np.nan), np.empty((N, 3)))
    for span, smoothed in smooth_covariances(solution):
        measurements, first = span.measurements, span.first_new
        r, squares = np.zeros(measurements.z.shape), np.full(measurements.has_reading.shape, np.nan)
        load_compiled_module("residuals").compute_residuals(
            measurements.has_reading,
            span.is_used,
            measurements.arrays,
            span.process.constant_factors,
            solution.stochastic_errors[span.low : span.high],
            solution.common_errors,
            smoothed.conditional_covariance,
            smoothed.derivative,
            solution.covariance_root,
            first,
            r,
            squares,
            residuals.sigma[span.low : span.high],
        )
        residuals.values[:, span.new_samples], residuals.normalized_squares[:, span.new_samples] = (
            r[:, first:],
            squares[:, first:],
        )
    return residuals


def compute_filter_estimates(solution: Solution, n_leading: int = 3) -> FilterEstimates:
    """Run a Kalman filter linearized about a smoother solution, and return its estimates and
    innovations.

    In contrast to the smoother, the filter uses only the readings up to each sample.

    Parameters
    ----------
    solution : Solution
    n_leading : int
        Number of leading stochastic states to return. The default returns the attitude errors.

    Returns
    -------
    FilterEstimates
    """
    r, J = solution.prior_equations
    s, N = solution.is_used.shape
    root = np.linalg.inv(J)
    common, whitened = root @ r, np.empty((s, N, 3))
    errors, covariances = np.empty((N, n_leading)), np.empty((N, n_leading, n_leading))
    for span in solution.iterate_spans():
        samples, first = slice(span.low, span.high), span.first_new
        span_innovations = np.empty(span.measurements.z.shape)
        load_compiled_module("residuals").compute_innovations(
            span.is_used,
            span.readings,
            span.estimates,
            root,
            common,
            first,
            span_innovations,
            errors[samples],
            covariances[samples],
        )
        whitened[:, span.new_samples] = span_innovations[:, first:]
    n_components = [len(sensor.noise_sigmas()) for sensor in solution.batch.suite.sensors]
    innovations = zip(map(np.flatnonzero, solution.is_used), whitened, n_components, strict=True)
    return FilterEstimates(
        errors, covariances, tuple(Innovations(k, w[k, :m]) for k, w, m in innovations)
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """Smoothed and filtered attitude history of a calibration, with 1-sigmas and innovations.

    Attributes
    ----------
    times : array, shape (N,)
        Time of each sample [s].
    smoothed_attitude, filtered_attitude : arrays, shape (N, 3, 3)
        Rotation matrices from GCRS to body. The smoothed attitude uses all readings, the filtered
        attitude only the readings up to each sample.
    smoothed_sigma, filtered_sigma : arrays, shape (N, 3)
        1-sigma about the body axes [rad].
    innovations : tuple of Innovations
        Innovations of each sensor.
    """

    times: Floats
    smoothed_attitude: Floats
    smoothed_sigma: Floats
    filtered_attitude: Floats
    filtered_sigma: Floats
    innovations: tuple[Innovations, ...]
