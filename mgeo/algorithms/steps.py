"""Random steps of variables: probability law, unit of sigma, and treatment of the bounds."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from mgeo._typing import BoolArray, FloatArray, IntArray

Uniform: TypeAlias = Callable[[], FloatArray]

#: Largest step in widths of the bounds. Longer steps are cut, so that reflections stay finite.
_MAX_STEP_WIDTHS = 1e9
#: Largest scale of a resampled step in widths of the bounds. With this scale, the law is uniform
#: between the bounds to 1e-6.
_MAX_SCALE_WIDTHS = 1e3


class StepLaw(ABC):
    """Base class for the probability distributions of random steps.

    The steps are scaled by sigma afterwards. To search with another law than the normal one, set
    the class attribute ``law`` in a subclass of `RealVectors`.
    """

    @abstractmethod
    def draw(self, stream: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
        """Draw an array of independent random steps with the given shape."""

    @abstractmethod
    def truncated_quantile(
        self, probability: FloatArray, low: FloatArray, high: FloatArray
    ) -> FloatArray:
        """Return quantiles of the distribution truncated to the interval from `low` to `high`.

        The function `resample` calls this method for steps that leave the bounds. All arrays have
        the same shape.
        """


class NormalLaw(StepLaw):
    """Standard normal distribution, as in GEO_real (Mainenti-Lopes, Souza & de Sousa 2012)."""

    def draw(self, stream: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
        return stream.standard_normal(shape)

    def truncated_quantile(
        self, probability: FloatArray, low: FloatArray, high: FloatArray
    ) -> FloatArray:
        from scipy.special import ndtr, ndtri  # Deferred: slow to import.

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
    """Return the end points of steps, clipped to the bounds.

    Steps that would leave the bounds end exactly on a bound.

    Parameters
    ----------
    x : array, shape (..., n)
        Start points within the bounds.
    step : array, shape (..., n)
        Steps.
    spread : array, shape (..., n)
        Scale of each step as a multiple of the unit law; 0 for a step whose length is uniform
        between 0 and a maximum. Used by `resample` only.
    xl, xu : array, shape (n,)
        Bounds.
    uniform : function
        Returns uniform random numbers in [0, 1), shape (..., n). Called by `resample` only.
    law : StepLaw
        Law of the steps. Used by `resample` only.

    Returns
    -------
    array, shape (..., n)
        End points within the bounds; x + step if it is within the bounds.
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
    """Return the end points of steps, with reflection at the bounds.

    Parameters and return value are as for `clip`.
    """
    width = xu - xl
    moved = x + np.clip(step, -_MAX_STEP_WIDTHS * width, _MAX_STEP_WIDTHS * width)
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
    """Return the end points of steps, after redrawing the steps that would leave the bounds.

    The result is distributed as if each step were drawn repeatedly until it ends inside, but needs
    only a single draw from the law truncated to the bounds. A step of uniform length becomes
    uniform between x and the bound. Parameters and return value are as for `clip`.
    """
    draw, moved = uniform(), x + step
    clipped = np.clip(moved, xl, xu)
    scale = np.minimum(np.abs(spread), _MAX_SCALE_WIDTHS * (xu - xl))
    follows_law = scale > 0
    unit = np.where(follows_law, scale, 1.0)
    with np.errstate(over="ignore"):  # The bound may be infinitely many scales away.
        quantile = law.truncated_quantile(draw, (xl - x) / unit, (xu - x) / unit)
    new_step = np.where(follows_law, unit * quantile, draw * (clipped - x))
    return np.where(moved == clipped, moved, np.clip(x + new_step, xl, xu))


#: Treatments of the bounds by value of the parameter ``bounds``. Other names in the literature are
#: saturation or projection, mirroring, and resampling (Arabas, Szczepankiewicz & Wroniak 2010).
BOUNDS: dict[str, Bounding] = {"clip": clip, "reflect": reflect, "resample": resample}
AUTO = "auto"


def get_bounding(name: str, n_eq_constr: int) -> Bounding:
    """Return the function that enforces the bounds: `clip`, `reflect` or `resample`.

    Parameters
    ----------
    name : str
        Key of `BOUNDS`, or "auto". "auto" reflects steps if the problem has equality constraints,
        and clips them otherwise. Clipped steps often end in a corner of the bounds, which may
        satisfy an equality exactly, and a search rarely leaves such an isolated feasible point.
    n_eq_constr : int
        Number of equality constraints.

    Returns
    -------
    function
        One of `clip`, `reflect` and `resample`.
    """
    if name == AUTO:
        return reflect if n_eq_constr else clip
    return BOUNDS[name]


Scale = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]

#: Unit of sigma as a function of variables, lower and upper bounds: the unit of the variable, its
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
    """Perturb each variable by a random step within the bounds.

    The perturbed value is x + sigma scale(x) z with z from the law (Mainenti-Lopes, Souza & de
    Sousa 2012). Each candidate uses one of the perturbed values.

    Parameters
    ----------
    x : array, shape (n_walkers, n_groups, group_size)
        Current values.
    noise : array, shape of x
        Random numbers z.
    sigma : float or array that broadcasts to x
        Standard deviation, or scale, of the steps.
    scale : function
        Unit of sigma, one of `SCALES`.
    xl, xu : array that broadcasts to x
        Bounds.
    bounding : function
        Treatment of the bounds, one of `BOUNDS`.
    uniform : function
        Returns uniform random numbers in [0, 1), shape of x.
    law : StepLaw
        Law of the steps.

    Returns
    -------
    array, shape of x
        Perturbed values.
    """
    spread = sigma * scale(x, xl, xu)
    return bounding(x, spread * noise, spread, xl, xu, uniform, law)


def round_steps(
    x: FloatArray,
    end_points: FloatArray,
    primary: IntArray,
    donor: FloatArray,
    is_choice: BoolArray,
    xl: FloatArray,
    xu: FloatArray,
    uniform: FloatArray,
) -> FloatArray:
    """Round the end points of steps to valid values of integer, binary and choice variables.

    If the rounded step of the primary variable is zero, the variable moves
    to a neighbor instead; other variables then stay. Options of a choice have no order: a choice
    that would move takes the option of the donor or, without a donor, a random other option.

    Parameters
    ----------
    x : array, shape (..., n)
        Integer values at the start of the steps; broadcasts with the other arrays.
    end_points : array, shape (..., n)
        End points of the real steps, within the bounds.
    primary : array of int, shape (...)
        Primary variable of each step, which changes unless its bounds coincide.
    donor : array, shape (..., n)
        Points whose options are copied; NaN for steps without a donor.
    is_choice : array of bool, shape (n,)
        Mask of the choices.
    xl, xu : array, shape (n,)
        Integer bounds.
    uniform : array, shape (..., n)
        Uniform random numbers in [0, 1).

    Returns
    -------
    array, shape (..., n)
        Integer values within the bounds.
    """
    levels = xu - xl + 1.0
    end = np.rint(end_points)
    offset = np.floor(uniform * (levels - 1.0))  # Number of options to skip after the next one.
    random_option = xl + np.mod(x - xl + 1.0 + offset, levels)
    option = np.where(np.isnan(donor), random_option, donor)
    end = np.where(is_choice & (end != x), option, end)
    is_up = np.where(x == xl, True, (x < xu) & (uniform < 0.5))
    neighbor = np.clip(np.where(is_up, x + 1.0, x - 1.0), xl, xu)
    is_primary = np.zeros(end.shape, dtype=np.bool_)
    np.put_along_axis(is_primary, primary[..., None], True, axis=-1)
    return np.where(is_primary & (end == x), np.where(is_choice, random_option, neighbor), end)
