"""Which candidate a walker accepts: rank them, then draw a rank from a power law."""

import numpy as np

from mgeo._typing import FloatArray, IntArray


def rank(f: FloatArray, violation: FloatArray, ties: FloatArray) -> IntArray:
    """Candidates from best to worst along the last axis.

    Feasible ones come first, by the objective; then the infeasible ones, by their constraint
    violation; then those whose evaluation failed.

    Parameters
    ----------
    f : (..., n) the chosen objective, minimized; NaN or infinite where the evaluation failed.
    violation : (..., n) constraint violation, 0 where feasible; NaN counts as failed.
    ties : (..., n) distinct random numbers that put candidates of equal merit in order.

    Returns
    -------
    (..., n) indices; the first is rank k = 1.
    """
    failed = ~(np.isfinite(f) & ~np.isnan(violation))
    level = np.where(failed, 2, violation > 0)
    merit = np.where(failed, 0.0, np.where(violation > 0, violation, f))
    return np.lexsort((ties, merit, level), axis=-1)


def pick(uniform: FloatArray, n: int | IntArray, tau: float | FloatArray) -> IntArray:
    """Position in a ranking of `n`, drawn with probability proportional to k^-tau.

    Equation (10) of docs/theory.md. The inverse of the cumulative distribution at one uniform
    draw. It is the law of drawing a rank uniformly and accepting it with probability k^-tau until
    one is accepted, which is how GEO is usually written (de Sousa et al. 2003).

    Parameters
    ----------
    uniform : (...) draws in [0, 1).
    n : number of ranks, one for all or for each draw.
    tau : greediness, likewise: 0 is a random walk, large values take the best.

    Returns
    -------
    (...) positions k - 1 in 0..n-1.
    """
    ranks = np.arange(1.0, np.max(n) + 1.0)
    weights = ranks ** -np.asarray(tau, dtype=float)[..., None]
    if np.ndim(n):
        weights = np.where(ranks <= np.asarray(n)[..., None], weights, 0.0)
    below = np.cumsum(weights, axis=-1)
    reached = uniform[..., None] * below[..., -1:] >= below[..., :-1]
    position: IntArray = np.count_nonzero(reached, axis=-1)
    return position
