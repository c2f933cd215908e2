"""Recombination of two points variable by variable, and its share of the candidates."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from mgeo._typing import BoolArray, FloatArray

#: Distribution indices of the crossover and of the mutation: the larger, the smaller the changes.
CROSSOVER_INDEX, MUTATION_INDEX = 15.0, 20.0

_DECAY = 0.95  # factor of earlier gains and candidates in each generation
_BREAK_EVEN_GAIN_RATIO = (
    2.0  # ratio of the gains per candidate at which half of the candidates recombine
)


def recombine(
    first: FloatArray,
    second: FloatArray,
    xl: FloatArray,
    xu: FloatArray,
    is_choice: BoolArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Cross pairs of points variable by variable, and mutate some variables.

    Simulated binary crossover (Deb & Agrawal, "Simulated binary crossover for continuous search
    space", Complex Systems 9, 1995) puts each variable with probability 0.5 near that of either
    parent; other variables are those of the first parent. Then polynomial mutation (Deb & Goyal,
    "A combined genetic adaptive search (GeneAS) for engineering design", Computer Science and
    Informatics 26, 1996) changes each variable with probability 1 / n_var.

    Parameters
    ----------
    first, second : (n, n_var) pairs of points.
    xl, xu : (n_var,) bounds.
    is_choice : (n_var,) mask of the variables without order, which take the value of either parent.
    rng : stream of random numbers.

    Returns
    -------
    (n, n_var) points, some of them outside the bounds.
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
class Credit:
    """Recent gains of the recombined candidates and of all other candidates.

    Attributes
    ----------
    gains : (2,) gains of the other candidates, and of the recombined ones. The gains of a
        generation are scaled to a sum of 1, and those of earlier generations fade.
    n_candidates : (2,) numbers of such candidates, which fade as the gains do.
    """

    gains: FloatArray
    n_candidates: FloatArray

    @classmethod
    def create(cls, n: int) -> Self:
        """Return the credit after a generation of n candidates, half of each kind, equally good."""
        return cls(gains=np.full(2, 0.5), n_candidates=np.full(2, n / 2))

    def compute_share(self, low: float, high: float) -> float:
        """Return the share of the candidates to recombine, between two limits.

        It is q^2 / (q^2 + 4), where q is the gain of a recombined candidate, divided by that of
        another candidate: 20 % if both gain as much, 50 % if a recombined one gains twice as much.
        """
        other, recombined = (self.gains / self.n_candidates) ** 2
        share = recombined / (recombined + _BREAK_EVEN_GAIN_RATIO**2 * other)
        return float(min(max(share, low), high))

    def update(self, gains: FloatArray, is_recombined: BoolArray) -> None:
        """Account for the candidates of a generation that has both kinds, and gains.

        Parameters
        ----------
        gains : (...) decrease of the distance along the walker's weights, 0 without progress.
        is_recombined : (...) mask of the recombined candidates.
        """
        total, number = gains.sum(), np.count_nonzero(is_recombined)
        if not total or not 0 < number < gains.size:
            return
        gained = gains[is_recombined].sum() / total
        self.gains = _DECAY * self.gains + (1.0 - gained, gained)
        self.n_candidates = _DECAY * self.n_candidates + (gains.size - number, number)
