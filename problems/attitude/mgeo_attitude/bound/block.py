"""What the covariance of a 3-vector is not below, over time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats


class Block(NamedTuple):
    """Lower bounds at n times, each for every plan.

    Attributes
    ----------
    total : array, shape (n,)
        Of the sum of the three variances.
    worst : array, shape (n,)
        Of the largest of them.
    log_det : array, shape (n,)
        Of the natural logarithm of the determinant, if all else were known.
    """

    total: Floats
    worst: Floats
    log_det: Floats

    def or_above(self, other: Block) -> Block:
        """Where two are proved, the higher one."""
        return Block(*map(np.maximum, self, other))


def in_any_axes(variances: Floats) -> Block:
    """From least eigenvalues, shape (n, 3), whose axes are not known."""
    total = variances.sum(axis=1)
    return Block(total, total / 3.0, np.log(variances).sum(axis=1))


def in_these_axes(covariances: Floats) -> Block:
    """From covariances that none is below, shape (n, 3, 3)."""
    diagonals = np.diagonal(covariances, axis1=1, axis2=2)
    log_det = np.linalg.slogdet(covariances)[1]
    return Block(diagonals.sum(axis=1), diagonals.max(axis=1), log_det)


def least(known: Floats, gained: Floats) -> Block:
    """Of P = (Y + K)⁻¹ with a K of which only the trace is bounded.

    The information fills up the eigenvalues of Y from the smallest: as far as it can they end
    equal. For a function of eigenvalues that is convex and falls, a K that has the axes of Y is
    the best, and of these the one that leaves them as equal as can be: equation (21).

    Parameters
    ----------
    known : array, shape (3, 3)
        Y, positive definite.
    gained : array, shape (n,)
        Greatest trace of K, which is positive semidefinite.
    """
    return in_any_axes(filled(known, gained))


def filled(known: Floats, gained: Floats) -> Floats:
    """Eigenvalues of that P, shape (n, 3)."""
    eigenvalues = np.linalg.eigvalsh(known)
    counts = np.arange(1, len(eigenvalues) + 1)
    level = ((gained[:, None] + np.cumsum(eigenvalues)) / counts).min(axis=1)
    variances: Floats = 1.0 / np.maximum(eigenvalues, level[:, None])
    return variances


def unobserved(start: Floats, decay: float, walk: Floats, times: Floats) -> Floats:
    """Covariance of an error e' = -λ e + noise of densities that nothing measures.

    Parameters
    ----------
    start : array, shape (3, 3)
    decay : float
        λ [1/s].
    walk : array, shape (3,)
        Densities per axis.
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
