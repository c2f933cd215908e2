"""Attitude-independent magnetometer calibration from the strength of the field.

TWOSTEP (R. Alonso and M. D. Shuster, Complete Linear Attitude-Independent Magnetometer Calibration,
Journal of the Astronautical Sciences 50 (2002) 477-490): a linear estimate from centered
differences, in which squares of the unknowns cancel, followed by Gauss-Newton on the full model.
The field strength does not depend on the misalignment of the magnetometer, which is not estimated.

A magnetometer reports m = (I + diag k + N) B + b, with the elements yz, zx and xy of the symmetric
N. With u = (I + diag k + N)⁻¹ (m - b), |u|² - |B|² is zero apart from noise. The nine unknowns are
b, k and N, in this order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.vector_sensors import Magnetometer

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.vector_lengths import find_outlying_lengths

#: Smallest number of readings for nine unknowns.
MIN_READINGS = 20
#: State blocks of a magnetometer that the field strength depends on, in the order of the unknowns.
BLOCKS = ("bias", "scale_factor", "nonorthogonality")
_LARGE_BIAS = 0.1  # smallest bias, relative to the field strength, that corrupts field directions
_MAX_READINGS = 3000  # number of readings for an initial estimate
_MAX_ITERATIONS = 30
_TOLERANCE = 1e-6  # convergence tolerance of a step, in 1-sigmas
_PAIRS = ((1, 2), (2, 0), (0, 1))  # row and column of each element of N


@dataclass(frozen=True, eq=False)
class FieldStrengthFit:
    """Bias, scale factors and non-orthogonality of a magnetometer, estimated from the field
    strength.

    Attributes
    ----------
    parameters : array, shape (9,)
        b in the unit of the field, then k and N [-].
    covariance : array, shape (9, 9)
        Covariance of the parameters; zero for parameters that are not estimated.
    residuals : array, shape (n,)
        Normalized residual of each reading; standard normal if the declared noise is correct.
    """

    parameters: Floats
    covariance: Floats
    residuals: Floats


def fit_field_strength(
    measured: Floats, strength: Floats, sigma: Floats, prior_mean: Floats, prior_sigma: Floats
) -> FieldStrengthFit:
    """Estimate a magnetometer's bias, scale factors and non-orthogonality from the field strength.

    The estimate is the maximum a posteriori of the nine unknowns b, k and N.

    Parameters
    ----------
    measured : array, shape (n, 3)
        Measured field.
    strength : array, shape (n,)
        Strength of the field model at each reading, in the same unit.
    sigma : array, shape (3,)
        1-sigma of the noise of each axis.
    prior_mean, prior_sigma : arrays, shape (9,)
        Prior mean and 1-sigma of the unknowns. An unknown with a 1-sigma of zero is not estimated.

    Returns
    -------
    FieldStrengthFit

    Raises
    ------
    ValueError
        If there are fewer than `MIN_READINGS` readings, or the estimate does not converge.
    """
    if len(measured) < MIN_READINGS:
        raise ValueError(f"{len(measured)} readings: expected {MIN_READINGS} or more")
    free = prior_sigma > 0.0
    weight = np.where(free, 1.0 / np.where(free, prior_sigma, 1.0), 0.0)
    initial_guesses = [
        prior_mean,
        np.where(free, _estimate_linear(measured, strength, sigma, free), prior_mean),
    ]

    def linearize(values: Floats, spread: Floats) -> tuple[Floats, Floats]:
        z, slopes = _compute_residuals(values, measured, strength, sigma)
        r = np.concatenate([z / spread, weight * (values - prior_mean)])
        return r, np.vstack([slopes / spread[:, None], np.diag(weight)])[:, free]

    def compute_cost(values: Floats, spread: Floats) -> float:
        r, _ = linearize(values, spread)
        total = float(r @ r)
        return total if np.isfinite(total) else np.inf

    values = min(
        initial_guesses,
        key=lambda start: compute_cost(start, _compute_sigma(start, measured, sigma)),
    )
    for _ in range(_MAX_ITERATIONS):
        spread = _compute_sigma(values, measured, sigma)  # The weights are constant within a step.
        r, J = linearize(values, spread)
        result, *_ = np.linalg.lstsq(J, -r, rcond=None)
        step = np.zeros(9)
        step[free] = result
        while compute_cost(values + step, spread) > (1.0 + 1e-9) * float(r @ r):
            step *= 0.5
        values = values + step
        if np.linalg.norm(J @ step[free]) < _TOLERANCE:
            break
    else:
        raise ValueError(
            "the estimate of bias and scale factors from the field strength does not converge in "
            f"{_MAX_ITERATIONS} iterations"
        )
    r, J = linearize(values, _compute_sigma(values, measured, sigma))
    covariance = np.zeros((9, 9))
    covariance[np.ix_(free, free)] = np.linalg.inv(J.T @ J)
    return FieldStrengthFit(values, covariance, r[: len(measured)])


def fit_magnetometer(
    batch: Batch, index: int, state_prior: PriorEstimate, max_readings: int | None = None
) -> FieldStrengthFit:
    """Estimate the bias, scale factors and non-orthogonality of a magnetometer in a batch from the
    field strength.

    Field model errors are added to the noise. Readings with outlying lengths are excluded.

    Parameters
    ----------
    batch : Batch
    index : int
        Index of the magnetometer in the suite.
    state_prior : PriorEstimate
        Prior of the magnetometer's states.
    max_readings : int, optional
        Approximate number of readings to use: every k-th reading is used, so that between
        `max_readings` and twice as many remain. Default: all.

    Returns
    -------
    FieldStrengthFit
        Parameters in the filter's units.

    Raises
    ------
    ValueError
        Under the same conditions as in `fit_field_strength`.
    """
    suite, sensor = batch.suite, batch.suite.sensors[index]
    first_indices = suite.get_first_indices(sensor)
    mean, sigma = np.zeros(9), np.zeros(9)
    for number, block in enumerate(BLOCKS):
        if block in first_indices:
            states = slice(first_indices[block], first_indices[block] + 3)
            mean[3 * number : 3 * number + 3] = state_prior.states[states]
            sigma[3 * number : 3 * number + 3] = state_prior.sigma[states]
    field_error_index = first_indices.get("field_error")
    field_sigma = (
        0.0
        if field_error_index is None
        else state_prior.sigma[field_error_index : field_error_index + 3]
    )
    samples = np.flatnonzero(
        np.isfinite(batch.readings[index][:, 0, 0]) & ~find_outlying_lengths(batch)[index]
    )
    samples = samples[:: max(1, len(samples) // max_readings) if max_readings else 1]
    return fit_field_strength(
        batch.readings[index][samples, 0],
        np.linalg.norm(batch.vectors[samples, index], axis=1),
        np.hypot(batch.noise[index], field_sigma),
        mean,
        sigma,
    )


def compute_initial_states(batch: Batch, prior: PriorEstimate) -> Floats:
    """Return the initial states of a fit, as an array of shape (n_states,). Magnetometers that may
    have a large bias are calibrated from the field strength; all other states are the prior states.

    Without this calibration, a large bias would corrupt the measured field directions.

    Parameters
    ----------
    batch : Batch
    prior : PriorEstimate
        Prior estimate at the first sample.
    """
    states = prior.states.copy()
    for index, sensor in enumerate(batch.suite.sensors):
        if not isinstance(sensor, Magnetometer):
            continue
        first_indices = batch.suite.get_first_indices(sensor)
        strength = float(np.median(np.linalg.norm(batch.vectors[:, index], axis=1)))
        if prior.sigma[first_indices["bias"]] < _LARGE_BIAS * strength:
            continue
        try:
            result = fit_magnetometer(batch, index, prior, _MAX_READINGS)
        except ValueError:
            continue  # Keep the prior states.
        for number, block in enumerate(BLOCKS):
            if block in first_indices:
                first = first_indices[block]
                states[first : first + 3] = result.parameters[3 * number : 3 * number + 3]
    return states


def compute_response_matrix(values: Floats) -> Floats:
    """Return the 3 x 3 response matrix of a magnetometer for its scale factors and
    non-orthogonality.

    Parameters
    ----------
    values : array, shape (9,)
        Unknowns b, k and N. The matrix is I + diag k + N.
    """
    K = np.diag(1.0 + values[3:6])
    for value, (i, j) in zip(values[6:], _PAIRS, strict=True):
        K[i, j] = K[j, i] = value
    return K


def _compute_residuals(
    values: Floats, measured: Floats, strength: Floats, sigma: Floats
) -> tuple[Floats, Floats]:
    """Return the residuals of the squared field strength, shape (n,), and their Jacobian with
    respect to the nine unknowns, shape (n, 9).

    A residual is |u|² - |B|² minus its mean due to noise.
    """
    W = np.linalg.inv(compute_response_matrix(values))
    u = (measured - values[:3]) @ W
    Wu = u @ W
    z = (u * u).sum(axis=1) - strength**2 - np.trace((W * sigma**2) @ W)
    shear = [Wu[:, i] * u[:, j] + Wu[:, j] * u[:, i] for i, j in _PAIRS]
    return z, -2.0 * np.column_stack([Wu, Wu * u, *shear])


def _compute_sigma(values: Floats, measured: Floats, sigma: Floats) -> Floats:
    """Propagate the magnetometer noise to the 1-sigma of each residual, as an array of shape (n,).

    Noise w adds 2 uᵀ W w + |W w|² to a residual, with W = (I + diag k + N)⁻¹.
    """
    W = np.linalg.inv(compute_response_matrix(values))
    Wu = (measured - values[:3]) @ W @ W
    noise = (W * sigma**2) @ W
    spread: Floats = np.sqrt(4.0 * ((Wu * sigma) ** 2).sum(axis=1) + 2.0 * (noise**2).sum())
    return spread


def _estimate_linear(measured: Floats, strength: Floats, sigma: Floats, is_free: Bools) -> Floats:
    """Return an initial linear least-squares estimate of the nine unknowns, as an array of
    shape (9,).

    If one element of k or N is free, all six are estimated; the caller resets the fixed ones.

    Centered differences of |m|² - |B|² = 2 mᵀ d - mᵀ E m + constant give d and E, with I + E = (I +
    diag k + N)⁻² and d = (I + E) b.
    """
    scale = float(np.median(strength))
    m = measured / scale
    z = (m * m).sum(axis=1) - (strength / scale) ** 2
    shear_columns = [-2.0 * m[:, i] * m[:, j] for i, j in _PAIRS]
    A = np.column_stack([2.0 * m, -m * m, *shear_columns])
    is_estimated = is_free.copy()
    is_estimated[3:] = is_free[3:].any()
    A, z = A - A.mean(axis=0), z - z.mean()
    result = np.zeros(9)
    result[is_estimated], *_ = np.linalg.lstsq(A[:, is_estimated], z, rcond=None)
    square = compute_response_matrix(result)
    sizes, axes = np.linalg.eigh(square)
    if sizes.min() <= 0.0:  # The quadric is not an ellipsoid: estimate the bias alone.
        result[3:], square = 0.0, np.eye(3)
        sizes, axes = np.linalg.eigh(square)
    K = (axes / np.sqrt(sizes)) @ axes.T
    bias = scale * np.linalg.solve(square, result[:3])
    return np.concatenate([bias, np.diag(K) - 1.0, [K[i, j] for i, j in _PAIRS]])
