"""Steps of variables, real and whole: how far a candidate is from its walker, inside the box."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

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
Donors = Callable[[tuple[int, ...]], tuple[FloatArray, FloatArray]]

#: What sigma is a multiple of, given the variables and their lower and upper bounds: their unit,
#: their value (a variable at zero stays there), or the width of their bounds.
SCALES: dict[str, Scale] = {
    "absolute": lambda x, xl, xu: np.ones_like(x),
    "relative": lambda x, xl, xu: x,
    "range": lambda x, xl, xu: np.broadcast_to(xu - xl, x.shape),
}


class Attraction(NamedTuple):
    """A pull towards the best that is known: differential evolution's current-to-best move.

    As in Zhang & Sanderson, "JADE" (IEEE Trans. Evol. Comput. 13, 2009), equation 6, but a step
    goes a fraction of the way that is uniform in [0, 1).

    Attributes
    ----------
    share : of the steps that are differences, those that are pulled as well.
    coupling : mean probability that such a step changes another variable.
    x : (..., n_var) where steps begin.
    target : (..., n_var) what they are pulled to.
    """

    share: float
    coupling: float
    x: FloatArray
    target: FloatArray


#: Of steps with momentum: the largest fraction of the step before, and the largest step of a
#: variable as a fraction of the width of its bounds.
_INERTIA, _FASTEST = 1.2, 0.2


def momentum_steps(
    x: FloatArray,
    before: FloatArray,
    targets: FloatArray,
    extent: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Steps of all variables that go on as the step before, and towards a target: a swarm's move.

    r1 before + r2 (target - x), with r1 and r2 uniform and of each variable its own (Zhang et al.,
    "A competitive mechanism based multi-objective particle swarm optimizer with fast convergence",
    Information Sciences 427, 2018, equation 3). What is remembered here is a step that was good.

    Parameters
    ----------
    x : (..., n_var) where steps begin.
    before : (..., n_var) the steps before; they broadcast.
    targets : (..., n_var) what they are drawn to; they broadcast.
    extent : (n_var,) width of the bounds.
    rng : stream of random numbers.

    Returns
    -------
    (..., n_var) steps.
    """
    way = targets - x
    step = _INERTIA * rng.random(way.shape) * before + rng.random(way.shape) * way
    return np.clip(step, -_FASTEST * extent, _FASTEST * extent)


def within_a_step(x: FloatArray, targets: FloatArray, extent: FloatArray) -> BoolArray:
    """Which targets, (..., n_var), one step with momentum can reach in every variable."""
    return np.asarray((np.abs(targets - x) <= _FASTEST * extent).all(axis=-1))


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


def joint_steps(
    own: IntArray,
    extent: FloatArray,
    widths: Sequence[float],
    coupling: Sequence[float],
    difference: float | FloatArray,
    donors: Donors | None,
    rng: np.random.Generator,
    attraction: Attraction | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Steps that change each its own variable, and others with some probability.

    Parameters
    ----------
    own : (...) the variable of each step.
    extent : (n_var,) width of the bounds.
    widths : smallest and largest standard deviation of a normal step, as a fraction of `extent`;
        that of each step is log-uniform between them.
    coupling : mean probability that another variable changes: of normal steps, and of
        differences. Each step has its own, u^(1/mean - 1) with u uniform in [0, 1): some steps
        change hardly any other variable, some nearly all, whatever the problem may need.
    difference : share, or shares that broadcast with `own`, of the steps that are a fraction,
        uniform in [0, 1), of the difference between two points (differential evolution's move;
        Storn & Price 1997).
    donors : gives as many pairs of points, (..., n_var) each, as it is asked for; None for normal
        steps only.
    rng : stream of random numbers.
    attraction : moves some of the steps that are differences also towards points, if given.

    Returns
    -------
    (..., n_var) steps, zero where a variable stays; their standard deviations, zero where they are
    such a fraction; and the points towards which it is, if there are any: the first ones of the
    pairs, or those of the attraction.
    """
    shape = *own.shape, len(extent)
    least, largest = np.log(widths)
    width = np.exp(rng.uniform(least, largest, own.shape))[..., None]
    spread = width * extent
    step = spread * rng.standard_normal(shape)
    mean = np.full(own.shape, coupling[0])
    first = None
    if donors is not None:
        learns = rng.random(own.shape) < difference
        first, second = donors(own.shape)
        between = first - second
        step = np.where(learns[..., None], rng.random(own.shape)[..., None] * between, step)
        spread[learns] = 0.0
        mean[learns] = coupling[1]
        if attraction is not None:
            pulled = learns & (rng.random(own.shape) < attraction.share)
            part = rng.random(own.shape)[..., None] * (attraction.target - attraction.x)
            step = np.where(pulled[..., None], step + part, step)
            mean[pulled] = attraction.coupling
            first = np.where(pulled[..., None], attraction.target, first)
    with np.errstate(divide="ignore"):  # of a mean of zero, for which every probability is zero
        chance = rng.random(own.shape) ** (1.0 / mean - 1.0)
    changed = rng.random(shape) < chance[..., None]
    np.put_along_axis(changed, own[..., None], True, axis=-1)
    return np.where(changed, step, 0.0), spread, first


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
