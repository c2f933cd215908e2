"""States that a batch considers and does not estimate."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.estimation.smoother import Solution
from mgeo_attitude.filter.suite import Suite


def as_believed(
    suite: Suite, solution: Solution, sigma: Floats, states: Floats, covariance: Floats
) -> tuple[Floats, Floats]:
    """States and covariance at the last sample with those considered left as they were believed.

    A smoother weighs all readings at once. What it says of other states is then the same whether
    those considered are estimated beside them or have no gain, and so are the correlations: errors
    of the best estimate depend on no reading. A filter that goes from sample to sample loses by it.

    Parameters
    ----------
    sigma : array, shape (n_states,)
        Initial 1-sigmas.
    states, covariance : arrays, shapes (n_states,) and (n_states, n_states)
        With all of them estimated.
    """
    c = suite.considered
    if not c.size:
        return states, covariance
    states, covariance = states.copy(), covariance.copy()
    states[c] = 0.0
    covariance[np.ix_(c, c)] = np.diag(_variances(solution, sigma)[c])
    return states, covariance


def _variances(solution: Solution, sigma: Floats) -> Floats:
    """Of gyro and sensor states at the last sample, if there were no readings."""
    parts, move = solution.parts, solution.steps
    found = sigma**2
    found[parts.constant] *= move.growth[-1] ** 2
    driven = parts.driven[3:]
    decay, new = (np.einsum("nii->ni", matrix)[:, 3:] for matrix in (move.F, move.Q))
    for k in range(len(decay)):
        found[driven] = decay[k] ** 2 * found[driven] + new[k]
    return found
