"""The filter of what no attitude changes."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats


def recursion(start: Floats, decay: Floats, noise: Floats, information: Floats) -> Floats:
    """P⁻ = F P F + Q, then P = ((P⁻)⁻¹ + J)⁻¹, with diagonal F and Q: equation (22).

    Parameters
    ----------
    start : array, shape (k, k)
        P at the first sample.
    decay, noise : arrays, shape (k,)
        Diagonals of F and Q of a step.
    information : array, shape (n, k, k)
        J of each sample; that of the first is not used.

    Returns
    -------
    array, shape (n, k, k)
        P after each sample.
    """
    covariances = np.empty_like(information)
    factors, added, identity = np.outer(decay, decay), np.diag(noise), np.eye(len(start))
    told = np.any(information.reshape(len(information), -1), axis=1)
    covariances[0] = P = start
    for i in range(1, len(information)):
        P = P * factors + added
        if told[i]:
            P = np.linalg.solve(identity + P @ information[i], P)
            P = 0.5 * (P + P.T)
        covariances[i] = P
    return covariances
