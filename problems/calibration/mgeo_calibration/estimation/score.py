"""Score tests of coefficients that the model does not contain.

C. R. Rao, Large sample tests of statistical hypotheses concerning several parameters, Mathematical
Proceedings of the Cambridge Philosophical Society 44 (1948) 50-57. One pass of the filter estimates
the states of the model together with the coefficients.
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
#: Indices of coefficients, shape (a,), and their effect, shape (n, 3, a).
Columns = tuple[Ints, Floats]
#: Chi-square above which the tail probability is computed by a series.
_FAR = 500.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Departure:
    """Regressors of a model error that is linear in k coefficients.

    A coefficient of one is a large error. A combination of coefficients with a 1-sigma above one is
    not tested.

    Attributes
    ----------
    width : int
        Number k of coefficients.
    moves : function of Equations, optional
        Change of the attitude error in each step [rad], shape (n - 1, 3, k).
    reads : mapping of int to function of Equations
        Change of the readings of a sensor, by sensor index, in the filter's units, shape (n, 3, k).
    bias : array, shape (3, k), optional
        Change of the gyro bias at the last sample in addition to its estimated error [rad/s].
    """

    width: int
    moves: Callable[[Equations], Floats] | None = None
    reads: Mapping[int, Callable[[Equations], Floats]] = field(default_factory=dict)
    bias: Floats | None = None


@dataclass(frozen=True, eq=False)
class Combined:
    """Model error with coefficients that are linear combinations of a departure's coefficients.

    Attributes
    ----------
    departure : Departure
    columns : array, shape (departure.width, k)
        Coefficients of the departure for each of the k combinations.
    """

    departure: Departure
    columns: Floats

    @property
    def width(self) -> int:
        """Number k of combinations."""
        return int(self.columns.shape[1])


@dataclass(frozen=True, eq=False)
class Score:
    """Score test of the coefficients of a departure.

    Attributes
    ----------
    estimate, sigma : arrays, shape (k,)
        Estimated coefficients and their 1-sigmas. Combinations that are not tested have an estimate
        of zero and an infinite 1-sigma.
    chi_square : float
        Test statistic; chi-square distributed if the model is correct.
    freedom : int
        Degrees of freedom; zero if no combination is tested.
    option, options : int
        Index of the departure among the tested alternatives, and their number.
    """

    estimate: Floats
    sigma: Floats
    chi_square: float
    freedom: int
    option: int = 0
    options: int = 1

    def p(self, scatter: float = 1.0) -> float:
        """Return the p-value for noise with a variance `scatter` times the declared variance."""
        return float(np.exp(-0.5 * self.evidence(scatter)))

    def evidence(self, scatter: float = 1.0) -> float:
        """Return -2 ln p, which is finite even where p underflows.

        If the model is correct, -2 ln p is chi-square distributed with two degrees of freedom.
        """
        if not self.freedom:
            return 0.0
        tail = log_tail(self.chi_square / scatter, self.freedom)
        return max(0.0, -2.0 * (tail + math.log(self.options)))


@dataclass(frozen=True, eq=False)
class Scores:
    """Scores and information of the m coefficients of all departures.

    Attributes
    ----------
    information : array, shape (m, m)
        Fisher information of the coefficients.
    score : array, shape (m,)
        Gradient of the log-likelihood at coefficients of zero.
    change : array, shape (n_states, m)
        Change of the estimates at the last sample per coefficient, stochastic states first.
    places : mapping of str to slice
        Coefficients of each departure, by name.
    """

    information: Floats
    score: Floats
    change: Floats
    places: Mapping[str, slice]

    def of(self, name: str, beside: Sequence[str] = ()) -> Score:
        """Return the score test of one model error.

        Parameters
        ----------
        name : str
            Name of the model error.
        beside : sequence of str
            Names of other model errors to estimate at the same time.
        """
        numbers = np.arange(len(self.score))
        own = numbers[self.places[name]]
        others = np.concatenate([numbers[:0], *(numbers[self.places[each]] for each in beside)])
        information, score = self.information[np.ix_(own, own)], self.score[own]
        if len(others):
            within = _invert_information(self.information[np.ix_(others, others)])[0]
            lost = self.information[np.ix_(own, others)] @ within
            information = information - lost @ self.information[np.ix_(others, own)]
            score = score - lost @ self.score[others]
        covariance, known, axes = _invert_information(information)
        sigma = np.sqrt(np.diag(covariance))
        sigma[(np.abs(axes[:, ~known]) > _PART).any(axis=1)] = np.inf
        return Score(
            estimate=covariance @ score,
            sigma=sigma,
            chi_square=float(score @ covariance @ score),
            freedom=int(known.sum()),
        )


#: Smallest component of a unit eigenvector that counts as a contribution of a coefficient.
_PART = 0.1


def scores(solution: Solution, departures: Mapping[str, Departure | Combined]) -> Scores:
    """Compute the scores of model errors at a converged solution in one pass of the filter.

    Parameters
    ----------
    solution : Solution
    departures : mapping of str to Departure or Combined
        Model errors by name.
    """
    of = [each.departure if isinstance(each, Combined) else each for each in departures.values()]
    bases = dict.fromkeys(of)  # Departures compare by identity; a dict keeps their order.
    within = _assign_slices({base: base.width for base in bases})
    places = _assign_slices({name: each.width for name, each in departures.items()})
    m = sum(base.width for base in bases)
    columns = np.zeros((m, sum(each.width for each in departures.values())))
    for base, (name, each) in zip(of, departures.items(), strict=True):
        own = each.columns if isinstance(each, Combined) else np.eye(base.width)
        columns[within[base], places[name]] = own
    r, J = solution.prior
    q, d = len(r), solution.e.shape[1]
    R, gram, last = np.zeros((q, q + 1 + m)), np.zeros((m + 1, m + 1)), np.zeros((d, m))
    R[:, : q + 1] = np.linalg.qr(np.column_stack([J, r]))[1][:q]
    _run_filter(solution, within, last, R, gram)
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
    """Return the logarithm of the upper tail probability of a chi-square distribution.

    The result is finite even where the probability underflows. Large arguments use the asymptotic
    series of the incomplete gamma function (NIST Digital Library of Mathematical Functions,
    8.11.2).

    Parameters
    ----------
    x : float
        Chi-square.
    freedom : int
        Degrees of freedom.
    """
    if x < max(_FAR, 10.0 * freedom):
        return math.log(chdtrc(freedom, x))
    a, y = 0.5 * freedom, 0.5 * x
    series = np.cumprod([1.0, *((a - k) / y for k in range(1, 10))]).sum()
    return float((a - 1.0) * math.log(y) - y - math.lgamma(a) + math.log(series))


def _assign_slices(widths: Mapping[K, int]) -> dict[K, slice]:
    ends = np.cumsum([0, *widths.values()]).tolist()
    return {key: slice(*pair) for key, pair in zip(widths, pairwise(ends), strict=True)}


def _run_filter(
    solution: Solution, places: Mapping[Departure, slice], last: Floats, R: Floats, gram: Floats
) -> None:
    """Run the filter with the coefficients; write R, `gram` and the last sensitivities in place."""
    for span in solution.spans():
        moves, reads = _collect_effects(span, places)
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


def _collect_effects(
    span: Span, places: Mapping[Departure, slice]
) -> tuple[Columns, list[Columns]]:
    """Return the effect of all coefficients on the steps and on the readings of each sensor."""
    n, seen = span.high - span.low, span.sightings
    moves, reads = [_build_empty_columns(n - 1)], [[_build_empty_columns(n)] for _ in seen.there]
    for departure, place in places.items():
        numbers = np.arange(place.start, place.stop)
        if departure.moves is not None:
            moves.append((numbers, departure.moves(span)))
        for index, read in departure.reads.items():
            if seen.there[index].any():
                reads[index].append((numbers, read(span)))
    return _drop_zero_columns(moves), [_drop_zero_columns(each) for each in reads]


def _drop_zero_columns(each: Sequence[Columns]) -> Columns:
    numbers, columns = (np.concatenate(of, axis=-1) for of in zip(*each, strict=True))
    live = columns.any(axis=(0, 1))
    return numbers[live], np.compress(live, columns, axis=2)


def _build_empty_columns(n: int) -> Columns:
    return np.zeros(0, dtype=np.int64), np.zeros((n, 3, 0))


def _invert_information(information: Floats) -> tuple[Floats, Bools, Floats]:
    """Invert an information matrix over the combinations with a 1-sigma below one.

    Returns
    -------
    covariance : array, shape (m, m)
        Pseudo-inverse over these combinations.
    known : array of bool, shape (m,)
        True for eigenvectors with a 1-sigma below one.
    axes : array, shape (m, m)
        All eigenvectors.
    """
    values, axes = np.linalg.eigh(information)
    known: Bools = values > 1.0
    covariance: Floats = (axes[:, known] / values[known]) @ axes[:, known].T
    return covariance, known, axes
