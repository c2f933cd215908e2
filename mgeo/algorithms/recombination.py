"""Recombination of two points variable by variable, and its share of the candidates."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from mgeo._typing import BoolArray, FloatArray

#: Distribution indices of the crossover and of the mutation. A larger index means smaller changes.
CROSSOVER_INDEX, MUTATION_INDEX = 15.0, 20.0

#: Factor by which the weight of earlier generations decreases in each generation.
_DECAY = 0.95
#: Ratio of the gains per candidate at which half of the candidates recombine two points.
_BREAK_EVEN_GAIN_RATIO = 2.0


def recombine(
    first: FloatArray,
    second: FloatArray,
    xl: FloatArray,
    xu: FloatArray,
    is_choice: BoolArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Create one child from each pair of parents by simulated binary crossover and mutation.

    Simulated binary crossover (Deb & Agrawal, "Simulated binary crossover for continuous search
    space", Complex Systems 9, 1995) changes each variable with probability 0.5 to a value near that
    of a random parent. All other variables are copied from the first parent. Polynomial mutation
    (Deb & Goyal, "A combined genetic adaptive search (GeneAS) for engineering design", Computer
    Science and Informatics 26, 1996) then changes each variable with probability 1 / n_var.

    Parameters
    ----------
    first, second : array, shape (n, n_var)
        Parents.
    xl, xu : array, shape (n_var,)
        Bounds.
    is_choice : array of bool, shape (n_var,)
        Mask of the choices, which have no order and take the value of a parent.
    rng : numpy.random.Generator

    Returns
    -------
    array, shape (n, n_var)
        Children, which may be outside the bounds.
    """
    case = rng.random(first.shape)
    crossed, near_second = case >= 0.5, case >= 0.75
    # The published spread factor b has the distribution function b^(index + 1) / 2 below 1, and
    # 1 / b has the same, so that the logarithm of b follows a Laplace law.
    spread = np.exp(rng.laplace(scale=1.0 / (CROSSOVER_INDEX + 1.0), size=first.shape))
    half = 0.5 * (first - second)
    points = np.where(crossed, first - half + np.where(near_second, -spread, spread) * half, first)
    points[:, is_choice] = np.where(near_second, second, first)[:, is_choice]
    rows, columns = np.nonzero((rng.random(first.shape) < 1.0 / len(xl)) & ~is_choice)
    drawn = rng.uniform(-1.0, 1.0, len(rows))
    size = 1.0 - (1.0 - np.abs(drawn)) ** (1.0 / (MUTATION_INDEX + 1.0))
    points[rows, columns] += np.sign(drawn) * size * (xu - xl)[columns]
    return points


@dataclass(kw_only=True, eq=False, slots=True)
class RecombinationCredit:
    """Running totals of the improvements by recombination and by all other moves.

    The gain of a candidate is the decrease of the distance for the walker's weight vector. The
    weight of earlier generations decreases exponentially.

    Attributes
    ----------
    gains : array, shape (2,)
        Weighted sums of the gains of all other candidates and of recombined candidates. The gains
        of each generation are scaled to a sum of 1.
    n_candidates : array, shape (2,)
        Weighted numbers of all other candidates and of recombined candidates.
    """

    gains: FloatArray
    n_candidates: FloatArray

    @classmethod
    def create(cls, n: int) -> Self:
        """Create initial totals in which recombination and all other moves are equally successful.

        The totals are those of one generation of n candidates, half of which are recombined.
        """
        return cls(gains=np.full(2, 0.5), n_candidates=np.full(2, n / 2))

    def compute_share(self, low: float, high: float) -> float:
        """Return the share of candidates to recombine in the next generation.

        The share is q^2 / (q^2 + 4), clipped to the interval from `low` to `high`, where q is the
        mean gain of a recombined candidate divided by the mean gain of another candidate. The share
        is 20 % for equal gains, and 50 % if recombined candidates gain twice as much.
        """
        other, recombined = (self.gains / self.n_candidates) ** 2
        share = recombined / (recombined + _BREAK_EVEN_GAIN_RATIO**2 * other)
        return float(min(max(share, low), high))

    def update(self, gains: FloatArray, is_recombined: BoolArray) -> None:
        """Add the improvements of a generation to the totals, and discount all earlier generations.

        A generation without gains, or with one kind of candidate only, is ignored.

        Parameters
        ----------
        gains : array, shape (...)
            Decrease of the distance for the walker's weight vector, 0 without improvement.
        is_recombined : array of bool, shape (...)
            Mask of the recombined candidates.
        """
        total, n_recombined = gains.sum(), np.count_nonzero(is_recombined)
        if not total or not 0 < n_recombined < gains.size:
            return
        share = gains[is_recombined].sum() / total
        self.gains = _DECAY * self.gains + (1.0 - share, share)
        self.n_candidates = _DECAY * self.n_candidates + (gains.size - n_recombined, n_recombined)
