"""Weight vectors of a walker's objectives, and how near a point is to the front along them."""

import numpy as np

from mgeo._typing import FloatArray, IntArray

_SUM = 1e-3  # share of the sum in a distance: of points equal otherwise, the nondominated is nearer


def weight_vectors(n: int, n_obj: int, extreme: float) -> FloatArray:
    """(n, n_obj) weights of n walkers, >= 0, that sum to 1.

    A share of them is `extreme`, of a single objective, each objective in turn. The others are all
    above 0, and at even distances: with two objectives a grid, with more a low-discrepancy
    sequence (`_even`).
    """
    single = round(extreme * n)
    weights = np.zeros((n, n_obj))
    weights[np.arange(single), np.arange(single) % n_obj] = 1.0
    # Uniform points become what uniform points are when each is sorted (the largest of k numbers
    # is distributed as u^(1/k), the next one as a share of it, and so on). Sorting itself would
    # fold the cube k! times, and what is far apart in it would come together.
    shares: FloatArray = _even(n - single, n_obj - 1) ** (1.0 / np.arange(n_obj - 1, 0, -1))
    weights[single:] = _spacings(np.asarray(np.cumprod(shares, axis=1)[:, ::-1]))
    return weights


def random_weights(n: int, n_obj: int, rng: np.random.Generator) -> FloatArray:
    """(n, n_obj) weights drawn uniformly among those >= 0 that sum to 1."""
    return _spacings(np.sort(rng.random((n, n_obj - 1)), axis=1))


def _spacings(cuts: FloatArray) -> FloatArray:
    """(n, k + 1) lengths of the pieces into which (n, k) ascending points cut [0, 1]."""
    return np.diff(cuts, axis=1, prepend=0.0, append=1.0)


def _even(n: int, k: int) -> FloatArray:
    """(n, k) points in the unit cube: a grid along the first axis, a sequence along the others.

    The sequence is Kronecker's with the powers of the generalized golden ratio, the root of
    x^k = x + 1 (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
    """
    place = np.arange(n)
    ratio = 1.0
    for _ in range(64):  # to the last digit; a single axis needs none
        ratio = (1.0 + ratio) ** (1.0 / max(k, 2))
    points = (0.5 + np.outer(place + 1, ratio ** -np.arange(k))) % 1.0
    points[:, :1] = (1.0 / max(n, 1) * (place + 0.5))[:, None]
    return points


def distance(
    F: FloatArray, weights: FloatArray, ideal: FloatArray, nadir: FloatArray
) -> FloatArray:
    """How far points are along weight vectors: weighted Tchebycheff, scaled to what is known.

    Parameters
    ----------
    F : (..., n_obj) objectives, minimized.
    weights : (..., n_obj) weight vectors; they broadcast.
    ideal, nadir : (n_obj,) least and largest objectives of the front known so far: 0 and 1.

    Returns
    -------
    (...) the largest weighted objective, and a little of the sum of all; NaN where not finite.
    """
    finite = np.isfinite(F)
    known = bool(finite.all())
    given = F if known else np.where(finite, F, ideal)
    largest = total = np.float64(0.0)
    for k, (low, width) in enumerate(zip(ideal.tolist(), (nadir - ideal).tolist(), strict=True)):
        # column by column: numpy is slow at all that runs along a short last axis
        scaled = (given[..., k] - low) / (width if width > 0 else 1.0)
        weighted = weights[..., k] * scaled
        largest, total = np.maximum(largest, weighted) if k else weighted, total + scaled
    result = largest + _SUM * total
    return np.asarray(result if known else np.where(finite.all(axis=-1), result, np.nan))


def nearest(F: FloatArray, weights: FloatArray, ideal: FloatArray, nadir: FloatArray) -> IntArray:
    """Which points are nearest along weight vectors, by `distance`.

    One weight vector after the other: what is computed for a long front stays in the cache.

    Parameters
    ----------
    F : (n, n_obj) finite objectives of a front, n >= 1.
    weights : (n_weights, n_obj) weight vectors.
    ideal, nadir : their least and largest objectives, as of `distance`.

    Returns
    -------
    (n_weights,) rows of F; of points equally near the first.
    """
    widths = np.where(nadir > ideal, nadir - ideal, 1.0)
    scaled = [(F[:, k] - ideal[k]) / widths[k] for k in range(F.shape[1])]
    little = _SUM * np.add.reduce(scaled)
    far, weighted = np.empty_like(little), np.empty_like(little)
    found = np.empty(len(weights), dtype=np.intp)
    for row, weight in enumerate(weights):
        first, *others = np.flatnonzero(weight)  # nothing is below the ideal, 0
        np.multiply(scaled[first], weight[first], out=far)
        for k in others:
            np.maximum(far, np.multiply(scaled[k], weight[k], out=weighted), out=far)
        found[row] = np.add(far, little, out=far).argmin()
    return found


def nearest_drawn(
    drawn: IntArray, F: FloatArray, weights: FloatArray, ideal: FloatArray, nadir: FloatArray
) -> IntArray:
    """Which of a few points are nearest along weight vectors, each of its own few.

    Parameters
    ----------
    drawn : (n_weights, k) rows of F for each weight vector, k >= 1.
    F, weights, ideal, nadir : as of `nearest`.

    Returns
    -------
    (n_weights,) rows of F, one of each row of `drawn`.
    """
    if drawn.shape[1] == 1:
        return drawn[:, 0]
    far = distance(F[drawn], weights[:, None], ideal, nadir)
    return np.asarray(drawn[np.arange(len(drawn)), far.argmin(axis=1)])
