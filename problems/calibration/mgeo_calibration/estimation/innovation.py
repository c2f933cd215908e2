"""A sensor's innovation in the errors of an estimate: value, first and second derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.geometry.rotation import multiply
from mgeo_attitude.sensors.influences import influenced
from mgeo_attitude.sensors.readings import taken
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.estimation.estimate import Estimate
from mgeo_calibration.estimation.taylor import Taylor, uncertain, uncertain_rotation

STILL = np.zeros(3)


def innovation(
    suite: Suite,
    index: int,
    y: Any,
    vector: Floats,
    estimate: Estimate,
    aligned: bool = False,
    gradient: Sequence[Floats] = (),
    kind: type[Taylor] = Taylor,
    rate: Floats = STILL,
    influences: Sequence[Any] = (),
) -> Taylor:
    """Innovation as a polynomial in the errors of an estimate, by numbers of their blocks.

    Parameters
    ----------
    index : int
        Number of the sensor in the suite.
    y : array, shape (r, 3), or a tuple of them
        What it reports.
    vector : array, shape (3,) or (r, 3)
        What it looks at, GCRS; see `Sensor.inertial_vector`.
    aligned : bool
        Whether the estimate of every rotation but the attitude is taken to be none.
    gradient : sequence of arrays, shape (3,)
        What else it looks at, GCRS; see `Suite.looks`.
    rate : array, shape (3,) or (r, 3)
        Of the body [rad/s]; see `readings.taken`.
    influences : sequence of floats or arrays, shape (r, 1)
        What the sensor's are times, see `Suite.influence_values`.
    kind : type
        `Taylor`, or `Linear` for the first derivatives alone.
    """
    sensor, turn = suite.sensors[index], uncertain_rotation(None, 0, -1.0, kind)

    def to_body(vector: Floats | Taylor) -> Taylor:
        if isinstance(vector, Taylor):
            C = estimate.rotations[:, :, 0].swapaxes(0, 1)
            return turn(vector.map(lambda part: multiply(C, part)))
        each = "i,ijr->rj" if vector.ndim == 1 else "ri,ijr->rj"
        return turn(np.einsum(each, vector, estimate.rotations[:, :, 0]))

    own: dict[str, Callable[[Any], Taylor] | Taylor] = {}
    for state, first in suite.places(sensor).items():
        if state in sensor.rotations:
            known = estimate.rotations[:, :, suite.rotations.index(first)]
            own[state] = uncertain_rotation(None if aligned else known, first // 3, kind=kind)
        else:
            own[state] = uncertain(estimate.states[first : first + 3].T, first // 3, kind)
    influenced(sensor.influences, own, influences, lambda value, state: state * value)
    predicted = sensor.measured(*taken(sensor, own, [vector, *gradient], to_body, rate))
    found: Taylor = sensor.innovation(y, predicted)
    return found


def jacobian(r: Taylor) -> tuple[Ints, Floats]:
    """The p states that matter, shape (p,), and H = -∂r/∂e of these, shape (m, p, runs)."""
    numbers = tuple(term[0] for term in r.terms if len(term) == 1)
    H = np.empty((len(r.value), 3 * len(numbers), r.value.shape[-1]))
    for k, number in enumerate(numbers):
        np.negative(r.terms[(number,)], out=H[:, 3 * k : 3 * k + 3])
    return _states(numbers), H


def second_moments(r: Taylor, P: Floats) -> tuple[Floats, Floats]:
    """Mean, shape (m, runs), and covariance, shape (m, m, runs), of the terms of second order.

    For e ~ N(0, P) the term ½ eᵀ B e has the mean ½ tr(B P) and covariance ½ tr(B P B' P).
    """
    terms = {term: part for term, part in r.terms.items() if len(term) == 2}
    numbers = tuple(sorted({number for term in terms for number in term}))
    states = _states(numbers)
    m, n = len(r.value), len(states)
    half = np.zeros((m, n, n, P.shape[-1]))
    for (i, j), part in terms.items():
        a, b = 3 * numbers.index(i), 3 * numbers.index(j)
        half[:, a : a + 3, b : b + 3] += part.reshape(m, 3, 3, -1)
    B = half + half.swapaxes(1, 2)
    BP = np.einsum("qacr,cbr->qabr", B, P[states[:, None], states])
    mean = 0.5 * np.einsum("qaar->qr", BP)
    return mean, 0.5 * np.einsum("qabr,pbar->qpr", BP, BP)


@cache
def _states(numbers: tuple[int, ...]) -> Ints:
    """The states of blocks, one after the other."""
    return np.add.outer(3 * np.array(numbers, dtype=np.int64), np.arange(3)).ravel()
