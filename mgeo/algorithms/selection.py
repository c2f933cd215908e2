"""Which candidate a walker accepts: rank them, draw a rank from a power law, adapt its exponent.

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
START_TAU = 0.5  # of a new walker, and the median of what it falls back to


def rank(f: FloatArray, violation: FloatArray, ties: FloatArray) -> IntArray:
    """Candidates from best to worst along the last axis.

    Feasible ones come first, by the objective; then the infeasible ones, by their constraint
    violation; then those whose evaluation failed.

    Parameters
    ----------
    f : (..., n) the chosen objective, minimized; NaN or infinite where the evaluation failed.
    violation : (..., n) constraint violation, 0 where feasible; NaN counts as failed.
    ties : (..., n) distinct random numbers that put equal candidates in order.

    Returns
    -------
    (..., n) indices; the first is rank k = 1.
    """
    failed = ~(np.isfinite(f) & ~np.isnan(violation))
    level = np.where(failed, 2, violation > 0)
    value = np.where(failed, 0.0, np.where(violation > 0, violation, f))
    return np.lexsort((ties, value, level), axis=-1)


def pick(uniform: FloatArray, n: int | IntArray, tau: float | FloatArray) -> IntArray:
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


def fitness(F: FloatArray, violation: FloatArray) -> FloatArray:
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


def better(a: FloatArray, b: FloatArray) -> BoolArray:
    """(..., n_obj) where fitness `a` betters `b`: less violation, or equal and less objective."""
    less, equal = a < b, a == b
    found: BoolArray = less[..., :1] | (equal[..., :1] & less[..., 1:])
    return found


def best(values: FloatArray) -> FloatArray:
    """(..., 1 + n_obj) the best `fitness` along the second axis from last, for each objective."""
    least = values[..., :1].min(axis=-2, keepdims=True)
    objectives = np.where(values[..., :1] == least, values[..., 1:], np.inf).min(axis=-2)
    return np.concatenate([least[..., 0, :], objectives], axis=-1)


def next_tau(
    tau: FloatArray,
    chance: FloatArray,
    previous: FloatArray,
    normal: FloatArray,
    uniform: FloatArray,
    n: int,
) -> FloatArray:
    """The selection pressure with which to accept, from the one before.

    Parameters
    ----------
    tau : (n_walkers,) the last ones.
    chance, previous : (n_walkers,) chance of improvement, now and the time before.
    normal, uniform : (n_walkers,) a standard normal and a uniform draw each.
    n : length of the string that a walker is: variables, or bits.

    Returns
    -------
    (n_walkers,) 0.5 LogNormal(0, 1/sqrt(n)) where the chance is 0; tau + (0.5 + chance) U where
    it is not above the previous one; else tau.
    """
    reset = START_TAU * np.exp(normal / math.sqrt(n))
    raised = tau + (0.5 + chance) * uniform
    return np.where(chance == 0, reset, np.where(chance <= previous, raised, tau))
