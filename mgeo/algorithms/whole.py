"""Steps of integers, bits and choices: whole ones, or to another option."""

import numpy as np

from mgeo._typing import BoolArray, FloatArray, IntArray


def whole_steps(
    x: FloatArray,
    moved: FloatArray,
    own: IntArray,
    donor: FloatArray,
    choice: BoolArray,
    xl: FloatArray,
    xu: FloatArray,
    uniform: FloatArray,
) -> FloatArray:
    """Where steps of variables that take whole numbers end.

    A step is rounded; a variable stays if nothing is left of it, unless it is the step's own, which
    then goes to a neighbor. The numbers of a choice are in no order: where one would move, it takes
    the donor's option or, without a donor, any other one.

    Parameters
    ----------
    x : (..., n) whole numbers where steps begin; they broadcast with the others.
    moved : (..., n) where real steps would end, within the bounds.
    own : (...) the variable of each step, which changes if it can.
    donor : (..., n) points that steps learn from; NaN for steps that do not.
    choice : (n,) mask of the choices.
    xl, xu : (n,) bounds, whole numbers.
    uniform : (..., n) draws in [0, 1).

    Returns
    -------
    (..., n) whole numbers within the bounds.
    """
    levels = xu - xl + 1.0
    end = np.rint(moved)
    others = np.floor(uniform * (levels - 1.0))  # how many options beyond the next
    other = xl + np.mod(x - xl + 1.0 + others, levels)
    learned = np.where(np.isnan(donor), other, donor)
    end = np.where(choice & (end != x), learned, end)
    up = np.where(x == xl, True, (x < xu) & (uniform < 0.5))
    neighbor = np.clip(np.where(up, x + 1.0, x - 1.0), xl, xu)
    must = np.zeros(end.shape, dtype=np.bool_)
    np.put_along_axis(must, own[..., None], True, axis=-1)
    return np.where(must & (end == x), np.where(choice, other, neighbor), end)
