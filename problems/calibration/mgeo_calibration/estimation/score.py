"""What telemetry says of coefficients that a model is without, by score tests.

C. R. Rao, Large sample tests of statistical hypotheses concerning several parameters, Mathematical
Proceedings of the Cambridge Philosophical Society 44 (1948) 50-57. All that is estimated is
estimated beside them, in one pass of the filter.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats
from scipy.linalg import solve_triangular
from scipy.stats import chi2

from mgeo_calibration.estimation.kernels import load
from mgeo_calibration.estimation.linearization import Steps
from mgeo_calibration.estimation.smoother import Solution


@dataclass(frozen=True, eq=False, kw_only=True)
class Departure:
    """What a model is without, linear in k coefficients.

    A coefficient of one is a large one: of combinations that are not known better than that,
    telemetry says nothing.

    Attributes
    ----------
    width : int
        k.
    moves : array, shape (n, 3, k)
        What they add to the attitude's error in each step [rad].
    bias : array, shape (3, k), optional
        What they add to the gyro's bias at the last sample beside its own error [rad/s].
    """

    width: int
    moves: Floats
    bias: Floats | None = None


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
    """

    estimate: Floats
    sigma: Floats
    chi_square: float
    freedom: int

    def p(self, scatter: float = 1.0) -> float:
        """Probability that chance exceeds it, of noise with so many times its variance."""
        return float(chi2.sf(self.chi_square / scatter, self.freedom)) if self.freedom else 1.0


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


def scores(solution: Solution, departures: Mapping[str, Departure]) -> Scores:
    """Of a settled solution."""
    widths = [departure.width for departure in departures.values()]
    ends, m = np.cumsum(widths), sum(widths)
    places = {
        name: slice(int(end) - departure.width, int(end))
        for (name, departure), end in zip(departures.items(), ends, strict=True)
    }
    move, seen = _widened(solution.steps, departures, places, m), solution.sightings
    (N, d), (s, _, _, p) = solution.e.shape, seen.H.shape
    r, J = solution.prior
    q = len(r)
    R = np.zeros((q + m, q + m + 1))
    top = np.linalg.qr(np.column_stack([J, r]))[1]
    R[:q, :q], R[:q, -1] = top[:q, :q], top[:q, q]
    wide = q + m
    kept = np.empty((N, d)), np.empty((N, d, wide)), np.empty((N, d, d))
    readings = tuple(np.empty((s, N, 3, *more)) for more in ((p,), (d,), (), (wide,)))
    load("two_stage").forward(
        move.arrays, solution.used, seen.arrays, move.growth, kept, readings, R
    )
    own, slopes = R[q:, q:-1], -solve_triangular(R[:q, :q], R[:q, q:-1])
    last = kept[1][-1]
    driven = last[:, q:] + last[:, :q] @ slopes
    change = np.vstack([driven, move.growth[-1, : q - d, None] * slopes[d:]])
    order = np.concatenate([solution.parts.driven, solution.parts.constant])
    for name, departure in departures.items():
        if departure.bias is not None:
            change[np.isin(order, [3, 4, 5]), places[name]] += departure.bias
    return Scores(
        information=own.T @ own,
        score=own.T @ R[q:, -1],
        change=change,
        places=places,
    )


def _widened(
    move: Steps, departures: Mapping[str, Departure], places: Mapping[str, slice], m: int
) -> Steps:
    """Steps with the m coefficients as the last of the constants, which no sensor reads."""
    n, d, c = move.G.shape
    G = np.zeros((n, d, c + m))
    G[:, :, :c] = move.G
    for name, departure in departures.items():
        G[:, :3, c:][:, :, places[name]] = departure.moves
    growth = np.column_stack([move.growth, np.ones((len(move.growth), m))])
    return dataclasses.replace(move, G=G, growth=growth)


def _inverse(information: Floats) -> Floats:
    """Covariance of what is known better than one; of the rest nothing is said."""
    values, axes = np.linalg.eigh(information)
    known = values > 1.0
    covariance: Floats = (axes[:, known] / values[known]) @ axes[:, known].T
    return covariance
