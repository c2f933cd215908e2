"""Selection: ranking of candidates, random draw of a rank, adaptive tau, and weight vectors.

Candidates are ranked by one objective, or by their distance from the front along a weight vector.

An adaptive tau (A-GEO) follows the progress of the search. In each generation, a walker computes
the share of its candidates that improve on a reference: the chance of improvement (CoI). If no
candidate improves, tau is reset to a small random value, so that the walker can leave a local
optimum. If the chance has not increased since the last generation, tau increases. The reference is
the best fitness so far of the walker in A-GEO1, and its current fitness in A-GEO2.

The rules follow Barroca & de Sousa, "A new adaptive evolutionary algorithm for design optimization"
(2019), as implemented in leobeckerdaluz/GEO_OptimizationAlgorithms (AGEO_Mechanism.cs).
docs/explanation/algorithms.md explains the interpretation of these sources and the extension to
several objectives.
"""

import math

import numpy as np

from mgeo._typing import BoolArray, FloatArray, IntArray

RULES = ("a-geo1", "a-geo2")
#: Adaptive tau of a new walker, and median of the random values to which it is reset.
INITIAL_TAU = 0.5


def rank(f: FloatArray, violation: FloatArray, tie_breakers: FloatArray) -> IntArray:
    """Return the indices that sort candidates from best to worst along the last axis.

    Feasible candidates come first, sorted by the objective. Infeasible candidates follow, sorted by
    constraint violation, and finally candidates whose evaluation failed.

    Parameters
    ----------
    f : array, shape (..., n)
        Values of one objective, which is minimized; NaN or infinite where the evaluation failed.
    violation : array, shape (..., n)
        Constraint violations, 0 where feasible; NaN where the evaluation failed.
    tie_breakers : array, shape (..., n)
        Distinct random numbers, by which equal candidates are sorted.

    Returns
    -------
    array of int, shape (..., n)
        Indices of the candidates; the first one has rank k = 1.
    """
    failed = ~(np.isfinite(f) & ~np.isnan(violation))
    level = np.where(failed, 2, violation > 0)
    value = np.where(failed, 0.0, np.where(violation > 0, violation, f))
    return np.lexsort((tie_breakers, value, level), axis=-1)


def draw_position(uniform: FloatArray, n: int | IntArray, tau: float | FloatArray) -> IntArray:
    """Draw positions in a ranking of n candidates with power-law probabilities.

    A candidate of rank k is drawn with a probability proportional to k^-tau. The rank k is the
    position plus 1. GEO is usually described by another procedure with the same distribution: draw
    a rank uniformly, accept the rank with probability k^-tau, and repeat until a rank is accepted
    (de Sousa et al. 2003). Here, the inverse of the cumulative distribution needs a single random
    number.

    Parameters
    ----------
    uniform : array, shape (...)
        Uniform random numbers in [0, 1), one per draw.
    n : int or array of int
        Number of candidates, the same for all draws or one per draw.
    tau : float or array
        Selection pressure, the same for all draws or one per draw. With 0 all ranks are equally
        likely; with large values the best rank is drawn.

    Returns
    -------
    array of int, shape (...)
        Positions in 0..n-1.
    """
    ranks = np.arange(1.0, np.max(n) + 1.0)
    weights = ranks ** -np.asarray(tau, dtype=float)[..., None]
    if np.ndim(n):
        weights = np.where(ranks <= np.asarray(n)[..., None], weights, 0.0)
    cumulative = np.cumsum(weights, axis=-1)
    is_exceeded = uniform[..., None] * cumulative[..., -1:] >= cumulative[..., :-1]
    position: IntArray = np.count_nonzero(is_exceeded, axis=-1)
    return position


def compute_fitness(F: FloatArray, violation: FloatArray) -> FloatArray:
    """Combine constraint violations and objectives into fitness values for `is_better`.

    Parameters
    ----------
    F : array, shape (..., n_obj)
        Objectives, which are minimized; not finite where the evaluation failed.
    violation : array, shape (...)
        Constraint violations, 0 where feasible; NaN where the evaluation failed.

    Returns
    -------
    array, shape (..., 1 + n_obj)
        Constraint violation, infinite where the evaluation failed, followed by the objectives,
        which are set to 0 unless the candidate is feasible.
    """
    failed = np.isnan(violation) | ~np.isfinite(F).all(axis=-1)
    first = np.where(failed, np.inf, violation)[..., None]
    return np.concatenate([first, np.where(first == 0, F, 0.0)], axis=-1)


def is_better(a: FloatArray, b: FloatArray) -> BoolArray:
    """Return True for each objective in which fitness `a` is better than fitness `b`.

    A fitness is better if its constraint violation is smaller, or if the violations are equal and
    the objective is smaller.

    Parameters
    ----------
    a, b : array, shape (..., 1 + n_obj)
        Return values of `compute_fitness`.

    Returns
    -------
    array of bool, shape (..., n_obj)
    """
    less, equal = a < b, a == b
    better: BoolArray = less[..., :1] | (equal[..., :1] & less[..., 1:])
    return better


def find_best_fitness(values: FloatArray) -> FloatArray:
    """Return the best fitness in each objective among several candidates.

    The result consists of the smallest constraint violation, and of the smallest value of each
    objective among the candidates with this violation. The result may combine objectives of
    different candidates.

    Parameters
    ----------
    values : array, shape (..., n, 1 + n_obj)
        Return value of `compute_fitness` for n candidates.

    Returns
    -------
    array, shape (..., 1 + n_obj)
    """
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
    """Update the selection pressure tau of each walker in generalized extremal optimization.

    The rules are those of adaptive GEO (A-GEO).

    If the chance of improvement is 0, tau is reset to 0.5 exp(z / sqrt(n)), with z from a standard
    normal distribution. If the chance is not larger than before, tau increases by (0.5 + chance) u,
    with u uniform in [0, 1). Otherwise tau does not change.

    Parameters
    ----------
    tau : array, shape (n_walkers,)
        Current values.
    chance, previous_chance : array, shape (n_walkers,)
        Chance of improvement in this generation, and the last time that it was computed.
    normal, uniform : array, shape (n_walkers,)
        Random numbers z and u.
    n : int
        Number of coordinates of a walker: variables or bits.

    Returns
    -------
    array, shape (n_walkers,)
    """
    reset = INITIAL_TAU * np.exp(normal / math.sqrt(n))
    raised = tau + (0.5 + chance) * uniform
    return np.where(chance == 0, reset, np.where(chance <= previous_chance, raised, tau))


#: Width of an objective below which the objective counts as constant, so that no ratio overflows.
_MIN_EXTENT = 1e-200
#: Weight of the sum of the scaled objectives in a distance. Of two points with the same largest
#: weighted objective, a point that dominates the other one is therefore nearer.
_SUM_WEIGHT = 1e-3


def build_weight_vectors(n: int, n_obj: int, extreme_share: float) -> FloatArray:
    """Build n weight vectors: some for a single objective, the others evenly spread.

    An extreme weight vector has a single positive weight.

    Parameters
    ----------
    n : int
        Number of walkers.
    n_obj : int
        Number of objectives.
    extreme_share : float
        Share of the walkers with extreme weights: 1 for one objective and 0 for all others. The
        objectives take turns.

    Returns
    -------
    array, shape (n, n_obj)
        Weights that sum to 1, extreme ones first. All other weights are positive. With two
        objectives they are a regular grid, with more objectives a low-discrepancy sequence.
    """
    n_extreme = round(extreme_share * n)
    weights = np.zeros((n, n_obj))
    weights[np.arange(n_extreme), np.arange(n_extreme) % n_obj] = 1.0
    # Each even point is transformed to the distribution of a sorted uniform point: the largest of
    # k uniform numbers is distributed as u^(1/k), the next one as a share of the largest, and so
    # on. Sorting the points would fold the cube k! times and bring distant points together.
    shares: FloatArray = _build_even_points(n - n_extreme, n_obj - 1) ** (
        1.0 / np.arange(n_obj - 1, 0, -1)
    )
    weights[n_extreme:] = _compute_spacings(np.asarray(np.cumprod(shares, axis=1)[:, ::-1]))
    return weights


def draw_weights(n: int, n_obj: int, rng: np.random.Generator) -> FloatArray:
    """Draw n random weight vectors, uniformly from all nonnegative vectors that sum to 1.

    Returns
    -------
    array, shape (n, n_obj)
    """
    return _compute_spacings(np.sort(rng.random((n, n_obj - 1)), axis=1))


def _compute_spacings(cuts: FloatArray) -> FloatArray:
    """Return the lengths of the segments into which sorted cuts divide the interval [0, 1]."""
    return np.diff(cuts, axis=1, prepend=0.0, append=1.0)


def _build_even_points(n: int, k: int) -> FloatArray:
    """Return n evenly distributed points in the k-dimensional unit cube.

    The first axis is a regular grid. The other axes are a Kronecker sequence with the powers of the
    generalized golden ratio, the root of x^k = x + 1 (M. Roberts, "The unreasonable effectiveness
    of quasirandom sequences", 2018).
    """
    index = np.arange(n)
    ratio = 1.0
    for _ in range(64):  # The iteration converges to machine precision.
        ratio = (1.0 + ratio) ** (1.0 / max(k, 2))
    points = (0.5 + np.outer(index + 1, ratio ** -np.arange(k))) % 1.0
    points[:, :1] = (1.0 / max(n, 1) * (index + 0.5))[:, None]
    return points


def tchebycheff_distance(
    F: FloatArray, weights: FloatArray, ideal: FloatArray, nadir: FloatArray
) -> FloatArray:
    """Return the weighted Tchebycheff distance of objective vectors from the ideal point.

    The objectives are scaled so that the ideal point is 0 and the nadir point is 1. The distance is
    the largest weighted objective, plus a small multiple of the sum of all scaled objectives.

    Parameters
    ----------
    F : array, shape (..., n_obj)
        Objectives, which are minimized.
    weights : array, shape (..., n_obj)
        Weight vectors, which broadcast with `F`.
    ideal, nadir : array, shape (n_obj,)
        Smallest and largest value of each objective on the current front.

    Returns
    -------
    array, shape (...)
        Distances; NaN where an objective is not finite.
    """
    finite = np.isfinite(F)
    all_finite = bool(finite.all())
    values = F if all_finite else np.where(finite, F, ideal)
    largest = total = np.float64(0.0)
    # The loop runs over objectives, because NumPy is slow along a short last axis.
    for k, (low, width) in enumerate(zip(ideal.tolist(), (nadir - ideal).tolist(), strict=True)):
        scaled = (values[..., k] - low) / (width if width > _MIN_EXTENT else 1.0)
        weighted = weights[..., k] * scaled
        largest, total = np.maximum(largest, weighted) if k else weighted, total + scaled
    result = largest + _SUM_WEIGHT * total
    return np.asarray(result if all_finite else np.where(finite.all(axis=-1), result, np.nan))


def find_nearest(
    F: FloatArray, weights: FloatArray, ideal: FloatArray, nadir: FloatArray
) -> IntArray:
    """Find the point with the smallest Tchebycheff distance for each weight vector.

    See `tchebycheff_distance`.

    Parameters
    ----------
    F : array, shape (n, n_obj)
        Finite objectives of the points of a front, n >= 1.
    weights : array, shape (n_weights, n_obj)
        Weight vectors.
    ideal, nadir : array, shape (n_obj,)
        Smallest and largest value of each column of `F`.

    Returns
    -------
    array of int, shape (n_weights,)
        Rows of `F`; the first one of several equally near points.
    """
    widths = np.where(nadir - ideal > _MIN_EXTENT, nadir - ideal, 1.0)
    scaled = [(F[:, k] - ideal[k]) / widths[k] for k in range(F.shape[1])]
    sum_term = _SUM_WEIGHT * np.add.reduce(scaled)
    distances, weighted = np.empty_like(sum_term), np.empty_like(sum_term)
    nearest = np.empty(len(weights), dtype=np.intp)
    # One weight vector at a time, so that the arrays of a long front stay in the cache.
    for row, weight in enumerate(weights):
        # Objectives with zero weight cannot be the largest, because scaled objectives are >= 0.
        first, *others = np.flatnonzero(weight)
        np.multiply(scaled[first], weight[first], out=distances)
        for k in others:
            np.maximum(distances, np.multiply(scaled[k], weight[k], out=weighted), out=distances)
        nearest[row] = np.add(distances, sum_term, out=distances).argmin()
    return nearest


def find_nearest_in_sample(
    sample: IntArray, F: FloatArray, weights: FloatArray, ideal: FloatArray, nadir: FloatArray
) -> IntArray:
    """Find the nearest point for each weight vector among a few sampled points.

    Each weight vector has its own sample. The distance is the `tchebycheff_distance`.

    Parameters
    ----------
    sample : array of int, shape (n_weights, k)
        Rows of `F` to compare for each weight vector, k >= 1.
    F, weights, ideal, nadir : array
        As for `find_nearest`.

    Returns
    -------
    array of int, shape (n_weights,)
        Rows of `F`, one from each row of `sample`.
    """
    if sample.shape[1] == 1:
        return sample[:, 0]
    distances = tchebycheff_distance(F[sample], weights[:, None], ideal, nadir)
    return np.asarray(sample[np.arange(len(sample)), distances.argmin(axis=1)])
