"""Normal steps, also of learned covariances, and where all steps end: inside the box."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self, TypeAlias

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


@dataclass(kw_only=True, eq=False, slots=True)
class Normals:
    """Normal distributions of k walkers, and the samples of them that are not judged yet.

    A step is sigma M z of the bounds' widths, z standard normal. When a sample is full, the means
    move to what was best in it, and sigma and M learn from that: the matrix adaptation evolution
    strategy (Beyer & Sendhoff, "Simplify your covariance matrix adaptation evolution strategy",
    IEEE Trans. Evol. Comput. 21, 2017, figure 3), with the weights, rates and damping of the CMA-ES
    (Hansen, "The CMA evolution strategy: a tutorial", 2016).

    Attributes
    ----------
    sigma : (k,) step sizes, as a share of the bounds' widths; 0 before a distribution begins.
    matrix : (k, n_var, n_var) M; the covariance is sigma^2 M M^T.
    path : (k, n_var) which way the means have gone of late.
    z, F, violation : (k, size, ...) the sample: steps, objectives, constraint violations.
    drawn : how many of each sample are evaluated.
    """

    sigma: FloatArray
    matrix: FloatArray
    path: FloatArray
    z: FloatArray
    F: FloatArray
    violation: FloatArray
    drawn: int

    @classmethod
    def of(cls, k: int, n_var: int, n_obj: int, together: int) -> Self:
        """None has begun; samples are of 4 + 3 ln n_var at least, `together` at a time."""
        size = together * int(np.ceil((4 + int(3 * np.log(n_var))) / together))
        return cls(
            sigma=np.zeros(k),
            matrix=np.zeros((k, n_var, n_var)),
            path=np.zeros((k, n_var)),
            z=np.zeros((k, size, n_var)),
            F=np.zeros((k, size, n_obj)),
            violation=np.zeros((k, size)),
            drawn=0,
        )

    def begin(self, which: IntArray, sigma: FloatArray) -> None:
        """Let some distributions begin anew, as wide in all directions."""
        self.sigma[which] = sigma
        self.matrix[which] = np.eye(self.path.shape[1])
        self.path[which] = 0.0

    @property
    def widest(self) -> FloatArray:
        """(k,) the largest standard deviation of a variable, of the bounds' width."""
        return np.asarray(self.sigma * np.sqrt((self.matrix**2).sum(axis=2).max(axis=1)))

    def steps(self, together: int, rng: np.random.Generator) -> FloatArray:
        """(k, together, n_var) the next steps of each sample, of the bounds' widths."""
        k, _, n_var = self.z.shape
        z = rng.standard_normal((k, together, n_var))
        self.z[:, self.drawn : self.drawn + together] = z
        return self.sigma[:, None, None] * (z @ self.matrix.transpose(0, 2, 1))

    def take(self, F: FloatArray, violation: FloatArray) -> bool:
        """What the last steps were worth, (k, together, ...); whether samples are full now."""
        now = slice(self.drawn, self.drawn + F.shape[1])
        self.F[:, now], self.violation[:, now] = F, violation
        self.drawn = now.stop
        return bool(self.drawn == self.z.shape[1])

    def learn(self, ranking: IntArray) -> FloatArray:
        """(k, n_var) steps of the means, of the bounds' widths, by (k, size) places, best first."""
        n = self.path.shape[1]
        half = self.z.shape[1] // 2
        weights = np.log(half + 0.5) - np.log(np.arange(1, half + 1))
        weights /= weights.sum()
        many = 1.0 / (weights**2).sum()
        rate = (many + 2) / (n + many + 5)
        damping = 1 + rate + 2 * max(0.0, ((many - 1) / (n + 1)) ** 0.5 - 1)
        of_path = 2 / ((n + 1.3) ** 2 + many)
        of_sample = min(1 - of_path, 2 * (many - 2 + 1 / many) / ((n + 2) ** 2 + many))
        length = n**0.5 * (1 - 1 / (4 * n) + 1 / (21 * n**2))  # mean of a normal vector's
        z = np.take_along_axis(self.z, ranking[:, :half, None], axis=1)
        mean = weights @ z
        step = np.asarray(self.sigma[:, None] * (self.matrix @ mean[:, :, None])[:, :, 0])
        self.path = (1 - rate) * self.path + (many * rate * (2 - rate)) ** 0.5 * mean
        turned = (
            (1 - (of_path + of_sample) / 2) * np.eye(n)
            + of_path / 2 * self.path[:, :, None] * self.path[:, None, :]
            + of_sample / 2 * (z * weights[:, None]).transpose(0, 2, 1) @ z
        )
        self.matrix = self.matrix @ turned
        ratio = np.linalg.norm(self.path, axis=1) / length
        self.sigma = self.sigma * np.exp(np.minimum(rate / damping * (ratio - 1), 1.0))
        self.drawn = 0
        return step
