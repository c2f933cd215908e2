"""What becomes of a step that would leave the box of the variables' bounds."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from mgeo._typing import FloatArray

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
