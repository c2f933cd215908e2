"""How well the attitude is known, as one number."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.fields.quantity import DEG


def attitude_sigma_deg(covariance: Floats) -> Floats:
    """1-sigma of the attitude about the worst of the three body axes [deg].

    It is what ``required_sigma.attitude_deg`` is compared with, and what answers, tables, figures
    and files tell.

    Parameters
    ----------
    covariance : array, shape (..., n_states, n_states)
        Of the error state, the attitude error [rad] first; NaN gives NaN.

    Returns
    -------
    array, shape (...)
    """
    variances = np.diagonal(covariance, axis1=-2, axis2=-1)[..., :3]
    sigma: Floats = DEG.factor * np.sqrt(variances.max(axis=-1))
    return sigma


def attitude_accuracy_deg(covariance: Floats) -> Floats:
    """1-sigma of the angle by which the attitude is off, about the worst of all axes [deg].

    The attitude error is a small rotation vector; of its covariance it is the root of the largest
    eigenvalue, which, unlike `attitude_sigma_deg`, does not depend on how the body's axes are
    drawn. It is never less than that, nor more than the root of the trace. Sensor suites are
    compared by it.

    Parameters
    ----------
    covariance : array, shape (..., n_states, n_states)
        Of the error state, the attitude error [rad] first; NaN gives NaN.

    Returns
    -------
    array, shape (...)
    """
    attitude = covariance[..., :3, :3]
    sound = np.asarray(np.isfinite(attitude).all(axis=(-1, -2)))
    largest = np.linalg.eigvalsh(np.where(sound[..., None, None], attitude, 0.0))[..., -1]
    accuracy: Floats = np.where(sound, DEG.factor * np.sqrt(np.maximum(largest, 0.0)), np.nan)
    return accuracy
