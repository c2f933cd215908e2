"""States that are considered: no plan changes how well they are known."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats


def unobserved(start: Floats, decay: float, walk: float, times: Floats) -> Floats:
    """Covariance of an error e' = -λ e + noise of a density that nothing measures.

    Parameters
    ----------
    start : array, shape (3, 3)
    decay : float
        λ [1/s].
    times : array, shape (n,)
        [s]

    Returns
    -------
    array, shape (n, 3, 3)
    """
    twice = 2.0 * decay * times
    # (1 - exp(-2 λ t)) / 2 λ, which is t without decay
    grown = times if decay == 0.0 else -np.expm1(-twice) / (2.0 * decay)
    covariance: Floats = np.exp(-twice)[:, None, None] * start + walk * grown[
        :, None, None
    ] * np.eye(3)
    return covariance
