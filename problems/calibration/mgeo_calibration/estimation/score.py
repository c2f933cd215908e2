"""What telemetry says of coefficients that a model is without, by score tests.

C. R. Rao, Large sample tests of statistical hypotheses concerning several parameters, Mathematical
Proceedings of the Cambridge Philosophical Society 44 (1948) 50-57. All that is estimated is
estimated beside them, in one pass of the filter.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TypeVar

import numpy as np
from mgeo_attitude._typing import Floats
from scipy.linalg import solve_triangular
from scipy.stats import chi2

from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.kinematics import Steps
from mgeo_calibration.estimation.linearization import Equations
from mgeo_calibration.estimation.sightings import Sightings
from mgeo_calibration.estimation.smoother import Solution
from mgeo_calibration.estimation.trajectory import spans

K = TypeVar("K")
#: Chi-squares beyond which a series is taken.
_FAR = 500.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Departure:
    """What a model is without, linear in k coefficients.

    A coefficient of one is a large one: of combinations that are not known better than that,
    telemetry says nothing.

    Attributes
    ----------
    width : int
        k.
    moves : function of Equations, optional
        What they add to the attitude's error in each step of these [rad], shape (n - 1, 3, k).
    reads : mapping of int to function of Equations
        What they add to the readings of sensors, by number, in the filter's units, shape (n, 3, k).
    bias : array, shape (3, k), optional
        What they add to the gyro's bias at the last sample beside its own error [rad/s].
    """

    width: int
    moves: Callable[[Equations], Floats] | None = None
    reads: Mapping[int, Callable[[Equations], Floats]] = field(default_factory=dict)
    bias: Floats | None = None


@dataclass(frozen=True, eq=False)
class Combined:
    """A model that is without some combinations of a departure's coefficients.

    Attributes
    ----------
    departure : Departure
    columns : array, shape (departure.width, k)
        Its coefficients with each of the k.
    """

    departure: Departure
    columns: Floats

    @property
    def width(self) -> int:
        """k."""
        return int(self.columns.shape[1])


@dataclass(frozen=True, eq=False)
class Score:
    """Of the coefficients of a departure, of which nothing is believed.

    Attributes
    ----------
    estimate, sigma : arrays, shape (k,)
        Of combinations of which telemetry says nothing the estimate is none, the 1-sigma infinite.
    chi_square : float
        So distributed if the model is right.
    freedom : int
        Its degrees of freedom.
    option, options : int
        Number of the departure among so many, of which it says most.
    """

    estimate: Floats
    sigma: Floats
    chi_square: float
    freedom: int
    option: int = 0
    options: int = 1

    def p(self, scatter: float = 1.0) -> float:
        """Probability that chance exceeds it, of noise with so many times its variance."""
        return float(np.exp(-0.5 * self.evidence(scatter)))

    def evidence(self, scatter: float = 1.0) -> float:
        """-2 ln `p`, also where that is none: a chi-square of two degrees of freedom."""
        if not self.freedom:
            return 0.0
        tail = log_tail(self.chi_square / scatter, self.freedom)
        return max(0.0, -2.0 * (tail + math.log(self.options)))


@dataclass(frozen=True, eq=False)
class Scores:
    """Of the m coefficients of all departures.

    Attributes
    ----------
    information : array, shape (m, m)
    score : array, shape (m,)
        At none of them.
    change : array, shape (n_states, m)
        Of the errors at the last sample, driven ones first, with each coefficient.
    places : mapping of str to slice
        Which are of a departure, by its name.
    """

    information: Floats
    score: Floats
    change: Floats
    places: Mapping[str, slice]

    def of(self, name: str, beside: Sequence[str] = ()) -> Score:
        """Of a departure, with others estimated beside it."""
        numbers = np.arange(len(self.score))
        own = numbers[self.places[name]]
        others = np.concatenate([numbers[:0], *(numbers[self.places[each]] for each in beside)])
        # what the others say is taken out
        lost = self.information[np.ix_(own, others)] @ _inverse(
            self.information[np.ix_(others, others)]
        )
        information = (
            self.information[np.ix_(own, own)] - lost @ self.information[np.ix_(others, own)]
        )
        score = self.score[own] - lost @ self.score[others]
        values, axes = np.linalg.eigh(information)
        known = values > 1.0
        covariance = _inverse(information)
        sigma = np.sqrt(np.diag(covariance))
        sigma[(np.abs(axes[:, ~known]) > _PART).any(axis=1)] = np.inf
        return Score(
            estimate=covariance @ score,
            sigma=sigma,
            chi_square=float(score @ covariance @ score),
            freedom=int(known.sum()),
        )


#: Of a unit vector along coefficients, from which on one belongs to it.
_PART = 0.1


def scores(solution: Solution, departures: Mapping[str, Departure | Combined]) -> Scores:
    """Of a settled solution; what several are combined of is looked at once."""
    of = [each.departure if isinstance(each, Combined) else each for each in departures.values()]
    bases = dict.fromkeys(of)  # by identity, in order
    within = _places({base: base.width for base in bases})
    places = _places({name: each.width for name, each in departures.items()})
    columns = np.zeros(
        (sum(base.width for base in bases), sum(e.width for e in departures.values()))
    )
    for base, (name, each) in zip(of, departures.items(), strict=True):
        own = each.columns if isinstance(each, Combined) else np.eye(base.width)
        columns[within[base], places[name]] = own
    r, J = solution.prior
    q, d, m = len(r), solution.e.shape[1], len(columns)
    R, gram = np.zeros((q, q + m + 1)), np.zeros((m + 1, m + 1))
    top = np.linalg.qr(np.column_stack([J, r]))[1]
    R[:, :q], R[:, -1] = top[:q, :q], top[:q, q]
    last = _forward(solution, within, R, gram)
    gram += np.triu(gram, 1).T
    slopes = -solve_triangular(R[:, :q], R[:, q:-1])
    driven = last[:, q:] + last[:, :q] @ slopes
    change = np.vstack([driven, solution.growth[-1, : q - d, None] * slopes[d:]])
    order = np.concatenate([solution.parts.driven, solution.parts.constant])
    for base, place in within.items():
        if base.bias is not None:
            change[np.isin(order, [3, 4, 5]), place] += base.bias
    return Scores(
        information=columns.T @ gram[:-1, :-1] @ columns,
        score=columns.T @ gram[:-1, -1],
        change=change @ columns,
        places=places,
    )


def log_tail(x: float, freedom: int) -> float:
    """Logarithm of what chance leaves beyond a chi-square, also where that is no number above zero.

    There it is the series of the incomplete gamma function for large arguments (NIST Digital
    Library of Mathematical Functions, 8.11.2).
    """
    if x < max(_FAR, 10.0 * freedom):
        return float(chi2.logsf(x, freedom))
    a, y = 0.5 * freedom, 0.5 * x
    series = np.cumprod([1.0, *((a - k) / y for k in range(1, 10))]).sum()
    return float((a - 1.0) * math.log(y) - y - math.lgamma(a) + math.log(series))


def _places(widths: Mapping[K, int]) -> dict[K, slice]:
    """One after the other."""
    ends = np.cumsum([0, *widths.values()]).tolist()
    return {key: slice(*pair) for key, pair in zip(widths, pairwise(ends), strict=True)}


def _forward(
    solution: Solution, places: Mapping[Departure, slice], R: Floats, gram: Floats
) -> Floats:
    """One pass that leaves all equations in R, and what these do not fit in `gram`; the last T."""
    N, d = solution.e.shape
    wide = R.shape[1] - 1
    known = np.zeros(d), np.zeros((d, wide)), np.zeros((d, d))
    for low, high, first in spans(N):
        move, seen = _widened(solution.equations(low, high), places)
        s, n, _, p = seen.H.shape
        kept = np.empty((n, d)), np.empty((n, d, wide)), np.empty((n, d, d))
        for each, one in zip(kept, known, strict=True):
            each[0] = one
        room = tuple(np.empty((s, n, 3, *more)) for more in ((p,), (d,), (), (wide,)))
        used = np.ascontiguousarray(solution.used[:, low:high])
        load("two_stage").forward(
            move.arrays, used, seen.arrays, move.growth, kept, room, first, 0.0
        )
        load("two_stage").learn(used, room, first, R, gram)
        known = kept[0][-1].copy(), kept[1][-1].copy(), kept[2][-1].copy()
    return known[1]


def _widened(own: Equations, places: Mapping[Departure, slice]) -> tuple[Steps, Sightings]:
    """Steps and readings of some samples with the coefficients as the last of the constants."""
    move, seen, m = own.steps, own.sightings, sum(each.width for each in places)
    F, G, Q, defect = move.arrays
    H, c = seen.H, G.shape[2]
    s, N, _, p = H.shape
    wide, read = np.zeros((len(G), G.shape[1], c + m)), np.zeros((s, N, 3, p + m))
    wide[:, :, :c], read[:, :, :, :p] = G, H
    counts, columns = seen.counts.copy(), np.zeros((s, p + m), dtype=np.int64)
    columns[:, :p] = seen.columns
    for index in {index for departure in places for index in departure.reads}:
        first = int(counts[index].sum())
        columns[index, first : first + m] = c + np.arange(m)
        counts[index, 1] += m
        read[index, :, :, first:] = 0.0
    for departure, place in places.items():
        if departure.moves is not None:
            wide[:, :3, c:][:, :, place] = departure.moves(own)
        for index, reads in departure.reads.items():
            if seen.there[index].any():
                read[index, :, :, int(seen.counts[index].sum()) :][:, :, place] = reads(own)
    growth = np.column_stack([move.growth, np.ones((N, m))])
    return (
        Steps(F, wide, Q, defect, growth),
        Sightings(seen.there, seen.z, read, seen.noise, seen.numbers, counts, columns),
    )


def _inverse(information: Floats) -> Floats:
    """Covariance of what is known better than one; of the rest nothing is said."""
    values, axes = np.linalg.eigh(information)
    known = values > 1.0
    covariance: Floats = (axes[:, known] / values[known]) @ axes[:, known].T
    return covariance
