"""States that a batch considers and does not estimate."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Floats

from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.kinematics import discretized
from mgeo_calibration.estimation.smoother import Solution
from mgeo_calibration.estimation.trajectory import spans


def as_believed(
    belief: Belief, solution: Solution, states: Floats, covariance: Floats
) -> tuple[Floats, Floats]:
    """States and covariance at the last sample with those considered left as they were believed.

    A smoother weighs all readings at once. What it says of other states is then the same whether
    those considered are estimated beside them or have no gain, and so are the correlations: errors
    of the best estimate depend on no reading. A filter that goes from sample to sample loses by it.

    Parameters
    ----------
    belief : Belief
        At the first sample.
    states, covariance : arrays, shapes (n_states,) and (n_states, n_states)
        With all of them estimated.
    """
    c = belief.suite.considered
    if not c.size:
        return states, covariance
    left, added = _without_readings(belief, solution)
    states, covariance = states.copy(), covariance.copy()
    states[c] = left[c] * belief.states[c]
    sigma = left[c] * belief.sigma[c]
    covariance[np.ix_(c, c)] = sigma[:, None] * belief.correlation[np.ix_(c, c)] * sigma
    covariance[c, c] += added[c]
    return states, covariance


def _without_readings(belief: Belief, solution: Solution) -> tuple[Floats, Floats]:
    """By what gyro and sensor states decay until the last sample, and the variance that is new."""
    parts, batch = solution.parts, solution.batch
    left, added = np.ones_like(belief.sigma), np.zeros_like(belief.sigma)
    left[parts.constant] = solution.growth[-1]
    driven = parts.driven[3:]
    for low, high, _ in spans(len(batch.times)):
        own = batch.part(low, high)
        durations, follows = own.durations, own.follows(own.suite.gyro, slice(1, None))
        F, Q = discretized(own.suite, np.zeros((len(durations), 3)), durations, follows)
        decay, new = (np.einsum("nii->ni", matrix)[:, driven] for matrix in (F, Q))
        later = np.cumprod(decay[::-1], axis=0)[::-1]  # from the begin of each step to the end
        after = np.vstack([later[1:], np.ones_like(later[:1])])
        left[driven] *= later[0]
        added[driven] = later[0] ** 2 * added[driven] + (after**2 * new).sum(axis=0)
    return left, added
