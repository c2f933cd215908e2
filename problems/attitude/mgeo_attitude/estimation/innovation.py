"""A sensor's innovation in the errors of an estimate: value, first and second derivatives."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.estimation.estimate import Estimate
from mgeo_attitude.estimation.taylor import Taylor, Term, UncertainRotation

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def expand(
    suite: Suite, index: int, y: Any, reference: Floats, estimate: Estimate, aligned: bool
) -> tuple[Floats, Floats, Ints, dict[Term, Floats]]:
    """Innovation r, H = -∂r/∂e and the terms of second order in the errors e of an estimate.

    Parameters
    ----------
    index : int
        Number of the sensor in the suite.
    y : array, shape (r, 3), or a tuple of them
        What it reports.
    reference : array, shape (3,)
        GCRS.
    aligned : bool
        Whether to take the derivatives where every rotation but the attitude is none.

    Returns
    -------
    r : array, shape (3, r)
    H : array, shape (3, m, r)
        For the m states that matter.
    states : array, shape (m,)
        Which ones.
    terms of second order, see `Taylor.terms`; their numbers are those of the 3-vectors
    """
    r = found = _innovation(suite, index, y, reference, estimate, False)
    if aligned:
        found = _innovation(suite, index, y, reference, estimate, True)
    value, terms = r.value, found.terms
    first = [term[0] for term in terms if len(term) == 1]
    H = np.empty((3, 3 * len(first), value.shape[-1]))
    for k, number in enumerate(first):
        np.negative(terms[(number,)], out=H[:, 3 * k : 3 * k + 3])
    return (
        value,
        H,
        states_of(tuple(first)),
        {term: terms[term] for term in terms if len(term) == 2},
    )


def _innovation(
    suite: Suite, index: int, y: Any, reference: Floats, estimate: Estimate, aligned: bool
) -> Taylor:
    sensor, attitude = suite.sensors[index], UncertainRotation(None, 0, -1.0)

    def to_body(vector: Floats) -> Taylor:
        return attitude.rotate(np.einsum("i,ijr->rj", vector, estimate.rotations[:, :, 0]))

    own: dict[str, UncertainRotation | Taylor] = {}
    for state, first in suite.places(sensor).items():
        if state in sensor.rotations:
            known = estimate.rotations[:, :, suite.rotations.index(first)]
            own[state] = UncertainRotation(None if aligned else known, first // 3)
        else:
            own[state] = Taylor.variable(estimate.states[first : first + 3].T, first // 3)
    predicted = sensor.measured(SimpleNamespace(to_body=to_body, **own), to_body(reference))
    innovation: Taylor = sensor.innovation(y, predicted)
    return innovation


def second_moments(terms: dict[Term, Floats], P: Floats) -> tuple[Floats, Floats]:
    """Mean, shape (3, r), and covariance, shape (3, 3, r), of terms of second order.

    For e ~ N(0, P) the term ½ eᵀ B e has the mean ½ tr(B P) and covariance ½ tr(B P B' P).
    """
    numbers = sorted({number for term in terms for number in term})
    states = states_of(tuple(numbers))
    n = len(states)
    half = np.zeros((3, n, n, P.shape[-1]))
    for (i, j), part in terms.items():
        a, b = 3 * numbers.index(i), 3 * numbers.index(j)
        half[:, a : a + 3, b : b + 3] += part.reshape(3, 3, 3, -1)
    B = half + half.swapaxes(1, 2)
    BP = np.einsum("qacr,cbr->qabr", B, P[states[:, None], states])
    mean = 0.5 * np.einsum("qaar->qr", BP)
    return mean, 0.5 * np.einsum("qabr,pbar->qpr", BP, BP)


@cache
def states_of(numbers: tuple[int, ...]) -> Ints:
    """The states of 3-vectors, one after the other."""
    return np.add.outer(3 * np.array(numbers, dtype=np.int64), np.arange(3)).ravel()
