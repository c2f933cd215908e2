"""What a covariance says of a plan: correlations, and the directions it has learned least of."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.view.observability.states import States
from mgeo_attitude.view.observability.words import in_words


def correlations(model: FilterModel, covariance: ArrayLike) -> pd.DataFrame:
    """Correlation of every pair of states, rows and columns by name, in [-1, 1].

    Parameters
    ----------
    covariance : array_like, shape (n_states, n_states)

    Raises
    ------
    ValueError
        For another shape, or a matrix that is no covariance.
    """
    P = checked_covariance(model, covariance)
    sigma = np.sqrt(np.diag(P))
    correlation = np.clip(P / np.outer(sigma, sigma), -1.0, 1.0)
    np.fill_diagonal(correlation, 1.0)
    names = States.of(model.suite).names
    return pd.DataFrame(correlation, names, names)


def normalized(model: FilterModel, covariance: ArrayLike) -> Floats:
    """The covariance with every state in units of its initial 1-sigma, shape (n, n).

    Ham & Brown, "Observability, Eigenvalues, and Kalman Filtering", IEEE Transactions on Aerospace
    and Electronic Systems 19 (1983) 269-273. States in rad, rad/s and of no dimension can only be
    combined in some such unit. The initial one makes an eigenvalue the share of what was unknown
    that is still unknown: 1 is a direction of which nothing was learned. (In units of the *final*
    sigma it would be the correlation matrix, which no longer knows what was learned.)
    """
    sigma = model.initial_sigma
    scaled: Floats = checked_covariance(model, covariance) / np.outer(sigma, sigma)
    return scaled


def least_observable(model: FilterModel, covariance: ArrayLike, count: int = 3) -> pd.DataFrame:
    """The `count` directions of the error state of which least was learned, the worst first.

    They are eigenvectors of the `normalized` covariance, by falling eigenvalue; errors that vary,
    and those that are considered, are left out. Process noise may lift an eigenvalue above one.

    Returns
    -------
    DataFrame
        ``direction``, in words (see `in_words`); ``remaining [-]``, the 1-sigma along it over the
        initial one; and for each 3-vector of the state the length that an error of 1-sigma along
        the direction has in it.

    Raises
    ------
    ValueError
        For a matrix of another shape, or one that is no covariance.
    """
    of = model.suite.calibrated
    values, vectors = np.linalg.eigh(normalized(model, covariance)[of[:, None], of])
    worst = np.argsort(values)[::-1][:count]
    remaining = np.sqrt(np.maximum(values[worst], 0.0))  # rounding may leave -1e-17
    directions = np.zeros((len(worst), model.suite.n_states))
    directions[:, of] = vectors.T[worst]
    columns: dict[str, object] = {
        "direction": [in_words(model.suite, model.initial_sigma, v) for v in directions],
        "remaining [-]": remaining,
    }
    one_sigma = remaining[:, None] * directions * model.initial_sigma
    lengths = np.linalg.norm(one_sigma.reshape(len(worst), -1, 3), axis=2)
    for block, length in zip(block_units(model.suite), lengths.T, strict=True):
        columns[f"{block.label} [{block.unit}]"] = length * block.factor
    return pd.DataFrame(columns)


def checked_covariance(model: FilterModel, covariance: ArrayLike) -> Floats:
    """The covariance as an array, symmetric to the last bit, or a ValueError."""
    P = np.asarray(covariance, dtype=float)
    n = model.suite.n_states
    if P.shape != (n, n):
        raise ValueError(f"covariance of shape {P.shape}: expected {(n, n)}")
    if not np.isfinite(P).all() or not (np.diag(P) > 0.0).all():
        raise ValueError("covariance: expected finite numbers, and variances above zero")
    sigma = np.sqrt(np.diag(P))
    if np.abs((P - P.T) / np.outer(sigma, sigma)).max() > 1e-6:
        raise ValueError("covariance: expected a symmetric matrix")
    symmetric: Floats = 0.5 * (P + P.T)
    return symmetric
