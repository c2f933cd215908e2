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
from mgeo_attitude._typing import Bools, Floats, Ints
from scipy.linalg import solve_triangular
from scipy.special import chdtrc

from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.linearization import Equations
from mgeo_calibration.estimation.smoother import Solution, Span

K = TypeVar("K")
#: Numbers of a coefficients, shape (a,), and what they add, shape (n, 3, a).
Columns = tuple[Ints, Floats]
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
        information, score = self.information[np.ix_(own, own)], self.score[own]
        if len(others):  # what they say is taken out
            within = _inverse(self.information[np.ix_(others, others)])[0]
            lost = self.information[np.ix_(own, others)] @ within
            information = information - lost @ self.information[np.ix_(others, own)]
            score = score - lost @ self.score[others]
        covariance, known, axes = _inverse(information)
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
    m = sum(base.width for base in bases)
    columns = np.zeros((m, sum(each.width for each in departures.values())))
    for base, (name, each) in zip(of, departures.items(), strict=True):
        own = each.columns if isinstance(each, Combined) else np.eye(base.width)
        columns[within[base], places[name]] = own
    r, J = solution.prior
    q, d = len(r), solution.e.shape[1]
    R, gram, last = np.zeros((q, q + 1 + m)), np.zeros((m + 1, m + 1)), np.zeros((d, m))
    R[:, : q + 1] = np.linalg.qr(np.column_stack([J, r]))[1][:q]
    _forward(solution, within, last, R, gram)
    slopes = -solve_triangular(R[:, :q], R[:, q + 1 :])
    driven = last + solution.starts[-1][1] @ slopes
    change = np.vstack([driven, solution.growth[-1, : q - d, None] * slopes[d:]])
    order = np.concatenate([solution.parts.driven, solution.parts.constant])
    for base, place in within.items():
        if base.bias is not None:
            change[np.isin(order, [3, 4, 5]), place] += base.bias
    return Scores(
        information=columns.T @ gram[1:, 1:] @ columns,
        score=columns.T @ gram[1:, 0],
        change=change @ columns,
        places=places,
    )


def log_tail(x: float, freedom: int) -> float:
    """Logarithm of what chance leaves beyond a chi-square, also where that is no number above zero.

    There it is the series of the incomplete gamma function for large arguments (NIST Digital
    Library of Mathematical Functions, 8.11.2).
    """
    if x < max(_FAR, 10.0 * freedom):
        return math.log(chdtrc(freedom, x))
    a, y = 0.5 * freedom, 0.5 * x
    series = np.cumprod([1.0, *((a - k) / y for k in range(1, 10))]).sum()
    return float((a - 1.0) * math.log(y) - y - math.lgamma(a) + math.log(series))


def _places(widths: Mapping[K, int]) -> dict[K, slice]:
    """One after the other."""
    ends = np.cumsum([0, *widths.values()]).tolist()
    return {key: slice(*pair) for key, pair in zip(widths, pairwise(ends), strict=True)}


def _forward(
    solution: Solution, places: Mapping[Departure, slice], last: Floats, R: Floats, gram: Floats
) -> None:
    """One pass that leaves all equations in R, what these do not fit in `gram`, and the last T."""
    for span in solution.spans():
        moves, reads = _added(span, places)
        s, n, b = len(reads), span.high - span.low, max(len(numbers) for numbers, _ in reads)
        read, which = np.zeros((s, n, 3, b)), np.zeros((s, b), dtype=np.int64)
        for index, (numbers, columns) in enumerate(reads):
            read[index, :, :, : len(numbers)] = columns
            which[index, : len(numbers)] = numbers
        load("sensitivities").sensitivities(
            span.steps.F,
            moves[1],
            moves[0],
            span.used,
            span.sightings.arrays[1:],
            read,
            np.array([len(numbers) for numbers, _ in reads]),
            which,
            span.readings,
            span.first,
            last,
            R,
            gram,
        )
    gram += np.triu(gram, 1).T


def _added(span: Span, places: Mapping[Departure, slice]) -> tuple[Columns, list[Columns]]:
    """What coefficients add to the steps, and to the readings of each sensor."""
    n, seen = span.high - span.low, span.sightings
    moves, reads = [_none(n - 1)], [[_none(n)] for _ in seen.there]
    for departure, place in places.items():
        numbers = np.arange(place.start, place.stop)
        if departure.moves is not None:
            moves.append((numbers, departure.moves(span)))
        for index, read in departure.reads.items():
            if seen.there[index].any():
                reads[index].append((numbers, read(span)))
    return _live(moves), [_live(each) for each in reads]


def _live(each: Sequence[Columns]) -> Columns:
    """Side by side, without those that are zero."""
    numbers, columns = (np.concatenate(of, axis=-1) for of in zip(*each, strict=True))
    live = columns.any(axis=(0, 1))
    return numbers[live], np.ascontiguousarray(columns[:, :, live])


def _none(n: int) -> Columns:
    return np.zeros(0, dtype=np.int64), np.zeros((n, 3, 0))


def _inverse(information: Floats) -> tuple[Floats, Bools, Floats]:
    """Covariance of what is known better than one, which of the axes are so, and these.

    Of the rest nothing is said.
    """
    values, axes = np.linalg.eigh(information)
    known: Bools = values > 1.0
    covariance: Floats = (axes[:, known] / values[known]) @ axes[:, known].T
    return covariance, known, axes
