"""Which candidate a walker accepts: rank them, draw a rank from a power law, adapt its exponent.

They are ranked by one objective, or by their distance from the front along a weight vector.

An adaptive tau (A-GEO) follows the search. Before it accepts, a walker asks which share of its
candidates improve on a reference: the chance of improvement (CoI). If none does, tau falls back to
a small random value, so that the walker may leave; if the chance has not grown since the last
time, tau grows. In A-GEO1 the reference is the best value that the walker has seen before, in
A-GEO2 its current one.

The rules are those of Barroca & de Sousa, "A new adaptive evolutionary algorithm for design
optimization" (2019), as coded in leobeckerdaluz/GEO_OptimizationAlgorithms (AGEO_Mechanism.cs).
Our reading of them, and of several objectives, is in docs/algorithms.md.
"""

import math

import numpy as np

from mgeo._typing import BoolArray, FloatArray, IntArray

RULES = ("a-geo1", "a-geo2")
INITIAL_TAU = 0.5  # of a new walker, and the median of what it falls back to


def rank(f: FloatArray, violation: FloatArray, tie_breakers: FloatArray) -> IntArray:
    """Candidates from best to worst along the last axis.

    Feasible ones come first, by the objective; then the infeasible ones, by their constraint
    violation; then those whose evaluation failed.

    Parameters
    ----------
    f : (..., n) the chosen objective, minimized; NaN or infinite where the evaluation failed.
    violation : (..., n) constraint violation, 0 where feasible; NaN counts as failed.
    tie_breakers : (..., n) distinct random numbers that put equal candidates in order.

    Returns
    -------
    (..., n) indices; the first is rank k = 1.
    """
    failed = ~(np.isfinite(f) & ~np.isnan(violation))
    level = np.where(failed, 2, violation > 0)
    value = np.where(failed, 0.0, np.where(violation > 0, violation, f))
    return np.lexsort((tie_breakers, value, level), axis=-1)


def draw_position(uniform: FloatArray, n: int | IntArray, tau: float | FloatArray) -> IntArray:
    """Position in a ranking of `n`, drawn with probability proportional to k^-tau.

    Equation (10) of docs/theory.md. The inverse of the cumulative distribution at one uniform
    draw. It is the law of drawing a rank uniformly and accepting it with probability k^-tau until
    one is accepted, which is how GEO is usually written (de Sousa et al. 2003).

    Parameters
    ----------
    uniform : (...) draws in [0, 1).
    n : number of ranks, one for all or for each draw.
    tau : selection pressure, likewise: 0 is a random walk, large values take the best.

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


def compute_fitness(F: FloatArray, violation: FloatArray) -> FloatArray:
    """What candidates are compared by, one objective at a time.

    Parameters
    ----------
    F : (..., n_obj) objectives, minimized; not finite where the evaluation failed.
    violation : (...) constraint violation, 0 where feasible; NaN counts as failed.

    Returns
    -------
    (..., 1 + n_obj) the violation, infinite where failed, then the objectives, 0 unless feasible.
    """
    failed = np.isnan(violation) | ~np.isfinite(F).all(axis=-1)
    first = np.where(failed, np.inf, violation)[..., None]
    return np.concatenate([first, np.where(first == 0, F, 0.0)], axis=-1)


def is_better(a: FloatArray, b: FloatArray) -> BoolArray:
    """(..., n_obj) where fitness `a` betters `b`: less violation, or equal and less objective."""
    less, equal = a < b, a == b
    found: BoolArray = less[..., :1] | (equal[..., :1] & less[..., 1:])
    return found


def find_best_fitness(values: FloatArray) -> FloatArray:
    """(..., 1 + n_obj) the best `compute_fitness` along the second axis from last, for each objective."""
    least = values[..., :1].min(axis=-2, keepdims=True)
    objectives = np.where(values[..., :1] == least, values[..., 1:], np.inf).min(axis=-2)
    return np.concatenate([least[..., 0, :], objectives], axis=-1)


def compute_next_tau(
    tau: FloatArray,
    chance: FloatArray,
    previous_chance: FloatArray,
    normal: FloatArray,
    uniform: FloatArray,
    n: int,
) -> FloatArray:
    """The selection pressure with which to accept, from the one before.

    Parameters
    ----------
    tau : (n_walkers,) the last ones.
    chance, previous_chance : (n_walkers,) chance of improvement, now and the time before.
    normal, uniform : (n_walkers,) a standard normal and a uniform draw each.
    n : length of the string that a walker is: variables, or bits.

    Returns
    -------
    (n_walkers,) 0.5 LogNormal(0, 1/sqrt(n)) where the chance is 0; tau + (0.5 + chance) U where
    it is not above the previous one; else tau.
    """
    reset = INITIAL_TAU * np.exp(normal / math.sqrt(n))
    raised = tau + (0.5 + chance) * uniform
    return np.where(chance == 0, reset, np.where(chance <= previous_chance, raised, tau))


_MIN_EXTENT = (
    1e-200  # extent below which an objective counts as constant, so that no ratio overflows
)
_SUM_WEIGHT = (
    1e-3  # share of the sum in a distance: of points equal otherwise, the nondominated is nearer
)


def build_weight_vectors(n: int, n_obj: int, extreme_share: float) -> FloatArray:
    """(n, n_obj) weights of n walkers, >= 0, that sum to 1.

    A share of them is `extreme_share`, of a single objective, each objective in turn. The others are all
    above 0, and at even distances: with two objectives a grid, with more a low-discrepancy
    sequence (`_even`).
    """
    single = round(extreme_share * n)
    weights = np.zeros((n, n_obj))
    weights[np.arange(single), np.arange(single) % n_obj] = 1.0
    # Uniform points become what uniform points are when each is sorted (the largest of k numbers
    # is distributed as u^(1/k), the next one as a share of it, and so on). Sorting itself would
    # fold the cube k! times, and what is far apart in it would come together.
    shares: FloatArray = _build_even_points(n - single, n_obj - 1) ** (
        1.0 / np.arange(n_obj - 1, 0, -1)
    )
    weights[single:] = _compute_spacings(np.asarray(np.cumprod(shares, axis=1)[:, ::-1]))
    return weights


def draw_weights(n: int, n_obj: int, rng: np.random.Generator) -> FloatArray:
    """(n, n_obj) weights drawn uniformly among those >= 0 that sum to 1."""
    return _compute_spacings(np.sort(rng.random((n, n_obj - 1)), axis=1))


def _compute_spacings(cuts: FloatArray) -> FloatArray:
    """(n, k + 1) lengths of the pieces into which (n, k) ascending points cut [0, 1]."""
    return np.diff(cuts, axis=1, prepend=0.0, append=1.0)


def _build_even_points(n: int, k: int) -> FloatArray:
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


def tchebycheff_distance(
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
        scaled = (given[..., k] - low) / (width if width > _MIN_EXTENT else 1.0)
        weighted = weights[..., k] * scaled
        largest, total = np.maximum(largest, weighted) if k else weighted, total + scaled
    result = largest + _SUM_WEIGHT * total
    return np.asarray(result if known else np.where(finite.all(axis=-1), result, np.nan))


def find_nearest(
    F: FloatArray, weights: FloatArray, ideal: FloatArray, nadir: FloatArray
) -> IntArray:
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
    widths = np.where(nadir - ideal > _MIN_EXTENT, nadir - ideal, 1.0)
    scaled = [(F[:, k] - ideal[k]) / widths[k] for k in range(F.shape[1])]
    little = _SUM_WEIGHT * np.add.reduce(scaled)
    far, weighted = np.empty_like(little), np.empty_like(little)
    found = np.empty(len(weights), dtype=np.intp)
    for row, weight in enumerate(weights):
        first, *others = np.flatnonzero(weight)  # nothing is below the ideal, 0
        np.multiply(scaled[first], weight[first], out=far)
        for k in others:
            np.maximum(far, np.multiply(scaled[k], weight[k], out=weighted), out=far)
        found[row] = np.add(far, little, out=far).argmin()
    return found


def find_nearest_in_sample(
    sample: IntArray, F: FloatArray, weights: FloatArray, ideal: FloatArray, nadir: FloatArray
) -> IntArray:
    """Which of a few points are nearest along weight vectors, each of its own few.

    Parameters
    ----------
    sample : (n_weights, k) rows of F for each weight vector, k >= 1.
    F, weights, ideal, nadir : as of `nearest`.

    Returns
    -------
    (n_weights,) rows of F, one of each row of `sample`.
    """
    if sample.shape[1] == 1:
        return sample[:, 0]
    far = tchebycheff_distance(F[sample], weights[:, None], ideal, nadir)
    return np.asarray(sample[np.arange(len(sample)), far.argmin(axis=1)])
