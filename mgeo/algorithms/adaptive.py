"""A greediness that follows the search: A-GEO, where tau is no parameter.

Before it accepts, a walker asks which share of its candidates improve on a reference: the chance
of improvement (CoI). If none does, tau falls back to a small random value, so that the walker may
leave; if the chance has not grown since the last time, tau grows. In A-GEO1 the reference is the
best value that the walker has seen before, in A-GEO2 the one where it stands.

The rules are those of Barroca & de Sousa, "A new adaptive evolutionary algorithm for design
optimization" (2019), as coded in leobeckerdaluz/GEO_OptimizationAlgorithms (AGEO_Mechanism.cs).
There the best value of A-GEO1 already contains the candidates that are compared with it, so that
no chance is ever above zero; that its reference ends before this generation is our reading. So
is the step to several objectives, of which no publication was found: each objective has a tau
and a chance of its own, and those of the objective that was drawn are used and renewed.
"""

import math
from typing import Literal

import numpy as np

from mgeo._typing import BoolArray, FloatArray

Rule = Literal["a-geo1", "a-geo2"]
RULES: tuple[Rule, ...] = ("a-geo1", "a-geo2")

START = 0.5  # tau of a new walker, and the median of what it falls back to


def merits(F: FloatArray, violation: FloatArray) -> FloatArray:
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


def unknown(n_obj: int) -> FloatArray:
    """(1 + n_obj,) merit of a point not evaluated: as if its evaluation had failed."""
    return merits(np.full(n_obj, np.nan), np.array(0.0))


def better(a: FloatArray, b: FloatArray) -> BoolArray:
    """Where merit `a` is better than `b`, objective by objective.

    Parameters
    ----------
    a, b : (..., 1 + n_obj) merits; they broadcast.

    Returns
    -------
    (..., n_obj) mask: less violation, or as much of it and a smaller objective.
    """
    less = (a < b)[..., :1]
    equal = (a == b)[..., :1]
    found: BoolArray = less | (equal & (a < b)[..., 1:])
    return found


def best(merit: FloatArray) -> FloatArray:
    """(..., 1 + n_obj) the best merit along the second axis from last, for each objective."""
    least = merit[..., :1].min(axis=-2, keepdims=True)
    values = np.where(merit[..., :1] == least, merit[..., 1:], np.inf).min(axis=-2)
    return np.concatenate([least[..., 0, :], values], axis=-1)


def first_chance(n_var: int) -> float:
    """The chance that stands for the one before the first: 1/sqrt(n_var)."""
    return 1.0 / math.sqrt(n_var)


def next_tau(
    tau: FloatArray,
    chance: FloatArray,
    previous: FloatArray,
    normal: FloatArray,
    uniform: FloatArray,
    n: int,
) -> FloatArray:
    """The greediness with which to accept, from the one before.

    Parameters
    ----------
    tau : (n_walkers,) the last ones.
    chance, previous : (n_walkers,) chance of improvement, now and the time before.
    normal, uniform : (n_walkers,) a standard normal and a uniform draw each.
    n : length of the string that a walker is: variables, or bits.

    Returns
    -------
    (n_walkers,) 0.5 LogNormal(0, 1/sqrt(n)) where the chance is 0; tau + (0.5 + chance) U where it
    is not above the previous one; else tau.
    """
    reset = START * np.exp(normal / math.sqrt(n))
    raised = tau + (0.5 + chance) * uniform
    return np.where(chance == 0, reset, np.where(chance <= previous, raised, tau))
