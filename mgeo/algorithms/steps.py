"""Steps of real variables: their law, their scale, and the treatment of the bounds."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from mgeo._typing import BoolArray, FloatArray, IntArray

Uniform: TypeAlias = Callable[[], FloatArray]

_FAR = 1e9  # Steps of more bound widths are shortened, so that reflections stay finite.
_FLAT = 1e3  # A law of this many bound widths is uniform between the bounds to 1e-6.


class StepLaw(ABC):
    """Probability law of a step of unit scale.

    A subclass draws steps and supplies the quantile of the law truncated to an interval, which the
    treatment of bounds by resampling needs. `MGEOReal` holds one as its attribute ``law``.
    """

    @abstractmethod
    def draw(self, stream: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
        """Draw steps of the given shape from a random stream."""

    @abstractmethod
    def truncated_quantile(
        self, probability: FloatArray, low: FloatArray, high: FloatArray
    ) -> FloatArray:
        """Return quantiles of the law truncated to [low, high]."""


class NormalLaw(StepLaw):
    """Standard normal law, that of GEO_real (Mainenti-Lopes, Souza & de Sousa 2012)."""

    def draw(self, stream: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
        return stream.standard_normal(shape)

    def truncated_quantile(
        self, probability: FloatArray, low: FloatArray, high: FloatArray
    ) -> FloatArray:
        from scipy.special import ndtr, ndtri  # scipy.special is slow to import

        below, above = ndtr(low), ndtr(high)
        quantile: FloatArray = ndtri(below + probability * (above - below))
        return quantile


NORMAL = NormalLaw()

Bounding: TypeAlias = Callable[
    [FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, Uniform, StepLaw], FloatArray
]


def clip(
    x: FloatArray,
    step: FloatArray,
    spread: FloatArray,
    xl: FloatArray,
    xu: FloatArray,
    uniform: Uniform,
    law: StepLaw = NORMAL,
) -> FloatArray:
    """End a step at the bound that it would cross. Of wide steps many end exactly there.

    Parameters
    ----------
    x : (..., n) start points, within the bounds.
    step : (..., n) steps.
    spread : (..., n) scale of each step in units of `law`; 0 for a step whose length is uniform
        between 0 and a maximum.
    xl, xu : (n,) bounds.
    uniform : returns (..., n) draws in [0, 1).
    law : law of the steps.

    Returns
    -------
    (..., n) end points within the bounds: x + step where that is inside.
    """
    return np.clip(x + step, xl, xu)


def reflect(
    x: FloatArray,
    step: FloatArray,
    spread: FloatArray,
    xl: FloatArray,
    xu: FloatArray,
    uniform: Uniform,
    law: StepLaw = NORMAL,
) -> FloatArray:
    """Reflect a step at the bounds until it ends inside. Parameters as for `clip`."""
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
    law: StepLaw = NORMAL,
) -> FloatArray:
    """Draw a step that leaves the bounds again until it ends inside. Parameters as for `clip`.

    One draw suffices: the end point follows the law truncated to the bounds, by its quantile
    function. A step of uniform length becomes uniform between x and the bound.
    """
    draw, moved = uniform(), x + step
    inside = np.clip(moved, xl, xu)
    scale = np.minimum(np.abs(spread), _FLAT * (xu - xl))
    follows_law = scale > 0
    unit = np.where(follows_law, scale, 1.0)
    with np.errstate(over="ignore"):  # The bound may be infinitely many scales away.
        quantile = law.truncated_quantile(draw, (xl - x) / unit, (xu - x) / unit)
    again = np.where(follows_law, unit * quantile, draw * (inside - x))
    return np.where(moved == inside, moved, np.clip(x + again, xl, xu))


#: Treatments of the bounds, by the value of the parameter ``bounds``. The literature also calls
#: them saturation or projection, mirroring, and resampling (Arabas, Szczepankiewicz & Wroniak
#: 2010).
BOUNDS: dict[str, Bounding] = {"clip": clip, "reflect": reflect, "resample": resample}
AUTO = "auto"


def bounding_of(name: str, n_eq_constr: int) -> Bounding:
    """Return the treatment of the bounds of a name in `BOUNDS`, or that of "auto".

    "auto" reflects steps where a problem has equality constraints, and clips them elsewhere. A
    corner of the bounds often satisfies an equality exactly. Clipped steps end in corners, and a
    search that has found one of these rare feasible points hardly leaves it.
    """
    if name == AUTO:
        return reflect if n_eq_constr else clip
    return BOUNDS[name]


Scale = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]

#: Units of sigma as functions of the variables and their bounds: the variable's own unit, its
#: value (a variable at zero stays there), or the width of its bounds.
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
    law: StepLaw = NORMAL,
) -> FloatArray:
    """Perturb every variable by a step of its own, within the bounds.

    x + sigma scale(x) z with z from the law (Mainenti-Lopes, Souza & de Sousa 2012); equation (9)
    of docs/theory.md.

    Parameters
    ----------
    x : (n_walkers, n_var) walkers.
    noise : (n_walkers, n_var) draws of the law.
    sigma : scale of the step, one for all variables or (n_var,).
    scale : unit of sigma, one of `SCALES`.
    xl, xu : (n_var,) bounds.
    bounding, uniform, law : treatment of the bounds, as for `clip`.

    Returns
    -------
    (n_walkers, n_var) perturbed values, of which a candidate takes one.
    """
    spread = sigma * scale(x, xl, xu)
    return bounding(x, spread * noise, spread, xl, xu, uniform, law)


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
