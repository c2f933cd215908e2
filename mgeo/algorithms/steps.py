"""Where steps end: inside the box, and at whole numbers; and the normal steps of MGEO_real."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from mgeo._typing import BoolArray, FloatArray, IntArray

Uniform: TypeAlias = Callable[[], FloatArray]
Bounding: TypeAlias = Callable[
    [FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, Uniform], FloatArray
]

_FAR = 1e9  # widths of the box: what is beyond is folded from there, to compute with finite numbers
_FLAT = 1e3  # widths of the box: a normal law as wide is uniform in it to 1e-6


def clip(
    x: FloatArray,
    step: FloatArray,
    spread: FloatArray,
    xl: FloatArray,
    xu: FloatArray,
    uniform: Uniform,
) -> FloatArray:
    """The bound that a step would cross: of wide steps many end exactly there.

    Parameters
    ----------
    x : (..., n) where steps begin, within the bounds.
    step : (..., n) steps.
    spread : (..., n) standard deviation of each, if it is normal; 0 for a step whose length is
        uniform between 0 and some largest one.
    xl, xu : (n,) bounds.
    uniform : gives (..., n) draws in [0, 1).

    Returns
    -------
    (..., n) where steps end, within the bounds: at x + step, if that is.
    """
    return np.clip(x + step, xl, xu)


def reflect(
    x: FloatArray,
    step: FloatArray,
    spread: FloatArray,
    xl: FloatArray,
    xu: FloatArray,
    uniform: Uniform,
) -> FloatArray:
    """Reflected by the bound, and again by the other one until it ends inside; as `clip`."""
    width = xu - xl
    moved = x + np.clip(step, -_FAR * width, _FAR * width)
    period = np.where(width > 0, 2.0 * width, 1.0)
    over = np.mod(moved - xl, period)
    folded = np.clip(xl + np.minimum(over, period - over), xl, xu)
    return np.where((moved < xl) | (moved > xu), folded, moved)


def resample(
    x: FloatArray,
    step: FloatArray,
    spread: FloatArray,
    xl: FloatArray,
    xu: FloatArray,
    uniform: Uniform,
) -> FloatArray:
    """Drawn anew from its law until it ends inside; as `clip`.

    A normal step then has the law of a truncated normal one, here by its inverse distribution
    function at one draw; a step of uniform length is uniform between x and the bound.
    """
    from scipy.special import ndtr, ndtri  # a fifth of the time in which a command starts

    draw, moved = uniform(), x + step
    inside = np.clip(moved, xl, xu)
    deviation = np.minimum(np.abs(spread), _FLAT * (xu - xl))
    normal = deviation > 0
    unit = np.where(normal, deviation, 1.0)
    with np.errstate(over="ignore"):  # a bound infinitely many deviations away
        below, above = ndtr((xl - x) / unit), ndtr((xu - x) / unit)
    again = np.where(normal, unit * ndtri(below + draw * (above - below)), draw * (inside - x))
    return np.where(moved == inside, moved, np.clip(x + again, xl, xu))


#: By the name that a parameter ``bounds`` gives. The literature also says saturation or
#: projection, mirroring, and resampling (Arabas, Szczepankiewicz & Wroniak 2010).
BOUNDS: dict[str, Bounding] = {"clip": clip, "reflect": reflect, "resample": resample}


Scale = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]

#: What sigma is a multiple of, given the variables and their lower and upper bounds: their unit,
#: their value (a variable at zero stays there), or the width of their bounds.
SCALES: dict[str, Scale] = {
    "absolute": lambda x, xl, xu: np.ones_like(x),
    "relative": lambda x, xl, xu: x,
    "range": lambda x, xl, xu: np.broadcast_to(xu - xl, x.shape),
}


def perturb(
    x: FloatArray,
    noise: FloatArray,
    sigma: float | FloatArray,
    scale: Scale,
    xl: FloatArray,
    xu: FloatArray,
    bounding: Bounding,
    uniform: Uniform,
) -> FloatArray:
    """New value of every variable, within its bounds.

    x + sigma scale(x) N(0, 1) (Mainenti-Lopes, Souza & de Sousa 2012); equation (9) of
    docs/theory.md.

    Parameters
    ----------
    x : (n_walkers, n_var) the walkers.
    noise : (n_walkers, n_var) standard normal draws.
    sigma : standard deviation, one for all or (n_var,).
    scale : what sigma is a multiple of: one of `SCALES`.
    xl, xu : (n_var,) bounds.
    bounding, uniform : what becomes of a step that would leave them, see `BOUNDS`.

    Returns
    -------
    (n_walkers, n_var) values, of which a candidate takes one.
    """
    spread = sigma * scale(x, xl, xu)
    return bounding(x, spread * noise, spread, xl, xu, uniform)


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
