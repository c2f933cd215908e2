"""Estimates of many filter runs, and sensor innovations with their first and second derivatives.

The last axis of all arrays is the run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.geometry.rotation import multiply, rotation_matrix, rotation_vector, skew
from mgeo_attitude.sensors.error_models import apply_bias_sensitivities
from mgeo_attitude.sensors.measurements import apply_latency
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.estimation.taylor import (
    TaylorPolynomial,
    add_error,
    build_rotation_with_error,
)

ZERO_RATE = np.zeros(3)


@dataclass(frozen=True)
class Estimate:
    """Estimated attitude, states and error covariances of r filter runs.

    The error e of a rotation is multiplicative, R = R̂ R(e). All other errors are additive.

    Attributes
    ----------
    rotation_indices : array of int, shape (3, k)
        Indices of the states that are rotations, attitude first; see `Suite.rotations`.
    rotations : array, shape (3, 3, k, r)
        Rotation matrix from body to GCRS, then the rotation matrices of the other rotations.
    states : array, shape (n_states, r)
        States; zero for rotations.
    covariance : array, shape (n_states, n_states, r)
        Covariance of the errors.
    """

    rotation_indices: Ints
    rotations: Floats
    states: Floats
    covariance: Floats

    @classmethod
    def from_states(
        cls, suite: Suite, attitude: Floats, states: Floats, covariance: Floats
    ) -> Estimate:
        """Build an estimate from the attitudes, states and covariances of r runs.

        Parameters
        ----------
        suite : Suite
        attitude : array, shape (3, 3, r)
            Rotation matrices from body to GCRS.
        states : array, shape (n_states, r)
            States, with rotation vectors for the rotations other than the attitude.
        covariance : array, shape (n_states, n_states, r)
            Covariance of the errors.
        """
        indices = np.arange(3)[:, None] + np.array(suite.rotation_indices)
        rotations, other_states = rotation_matrix(states[indices]), states.copy()
        rotations[:, :, 0], other_states[indices] = attitude, 0.0
        return cls(indices, rotations, other_states, covariance)

    @classmethod
    def from_model(cls, model: FilterModel, n_runs: int = 1) -> Estimate:
        """Return the initial estimate of a filter model, repeated for `n_runs` runs.

        Parameters
        ----------
        model : FilterModel
            Model with the initial attitude, states and covariance.
        n_runs : int
            Number of runs.
        """
        states = np.repeat(model.initial_states[:, None], n_runs, axis=-1)
        P = np.repeat(model.initial_covariance[..., None], n_runs, axis=-1)
        return cls.from_states(model.suite, model.initial_attitude.T[..., None], states, P)

    def correct(self, e: Floats, covariance: Floats) -> Estimate:
        """Apply the errors `e` to the estimate, and return the result with the covariance of the
        remaining errors.

        Parameters
        ----------
        e : array, shape (n_states, r)
            Errors to apply: rotation vectors multiply the rotations, other errors are added.
        covariance : array, shape (n_states, n_states, r)
            Covariance of the errors that remain.
        """
        states = self.states + e
        states[self.rotation_indices] = 0.0
        rotations = np.einsum(
            "ijkr,jlkr->ilkr", self.rotations, rotation_matrix(e[self.rotation_indices])
        )
        return Estimate(self.rotation_indices, rotations, states, covariance)

    def compute_errors(self, attitude: Floats, states: Floats) -> Floats:
        """Return the errors of the estimate relative to the true attitude and states, as an array
        of shape (n_states, r).

        `correct` with these errors gives the true state.

        Parameters
        ----------
        attitude : array, shape (3, 3, r)
            True rotation matrices from GCRS to body.
        states : array, shape (n_states, r)
            True states, with rotation vectors for rotations.
        """
        true = rotation_matrix(states[self.rotation_indices])
        true[:, :, 0] = attitude.swapaxes(0, 1)
        e = states - self.states
        e[self.rotation_indices] = rotation_vector(
            np.einsum("jikr,jlkr->ilkr", self.rotations, true)
        )
        return e


def reset_covariance(P: Floats, e: Floats, rotation_indices: Ints) -> None:
    """Transform error covariances in place after a correction by `e`, so that rotation errors refer
    to the corrected rotations.

    An error g of a rotation becomes the rotation vector of R(-e) R(g). The derivative at g = e is
    (I - ½ [e×]) / (1 + |e|² / 4).

    Parameters
    ----------
    P : array, shape (n_states, n_states, r)
        Covariances of the errors.
    e : array, shape (n_states, r)
        Errors by which the estimate was corrected.
    rotation_indices : array of int, shape (3, k)
        Indices of the states that are rotations.
    """
    g = e[rotation_indices]
    jacobians = (np.eye(3)[:, :, None, None] - 0.5 * skew(g)) / (1.0 + 0.25 * (g * g).sum(axis=0))
    for number, first in enumerate(rotation_indices[0]):
        jacobian, block = jacobians[:, :, number], slice(first, first + 3)
        rows = multiply(jacobian, P[block])
        P[block], P[:, block] = rows, rows.swapaxes(0, 1)
        P[block, block] = multiply(rows[:, block], jacobian.swapaxes(0, 1))


def compute_innovation(
    suite: Suite,
    index: int,
    y: Any,
    vector: Floats,
    estimate: Estimate,
    ignore_misalignments: bool = False,
    auxiliary_vectors: Sequence[Floats] = (),
    kind: type[TaylorPolynomial] = TaylorPolynomial,
    rate: Floats = ZERO_RATE,
    channel_values: Sequence[Any] = (),
) -> TaylorPolynomial:
    """Return a sensor's innovation (reading minus prediction) as a Taylor polynomial in the
    estimation errors.

    The number of an error 3-vector in the polynomial is the number of its state block.

    Parameters
    ----------
    suite : Suite
    index : int
        Index of the sensor in the suite.
    y : array, shape (r, 3), or a tuple of arrays
        Reading.
    vector : array, shape (3,) or (r, 3)
        Observed vector in GCRS; see `Sensor.inertial_vector`.
    estimate : Estimate
        Estimates of r runs.
    ignore_misalignments : bool
        Treat the estimates of all rotations other than the attitude as zero.
    auxiliary_vectors : sequence of arrays, shape (3,)
        Auxiliary vectors of the sensor in GCRS; see `Suite.compute_auxiliary_vectors`.
    kind : type
        `TaylorPolynomial`, or `LinearPolynomial` for first derivatives only.
    rate : array, shape (3,) or (r, 3)
        Body rate [rad/s]; see `measurements.apply_latency`.
    channel_values : sequence of floats or arrays, shape (r, 1)
        Values of the channels of the sensor's bias sensitivities; see
        `Suite.compute_channel_deviations`.

    Returns
    -------
    TaylorPolynomial
        Innovation with m components for each run.
    """
    sensor, rotate_to_body = suite.sensors[index], build_rotation_with_error(None, 0, -1.0, kind)

    def to_body(vector: Floats | TaylorPolynomial) -> TaylorPolynomial:
        if isinstance(vector, TaylorPolynomial):
            C = estimate.rotations[:, :, 0].swapaxes(0, 1)
            return rotate_to_body(vector.map(lambda part: multiply(C, part)))
        subscripts = "i,ijr->rj" if vector.ndim == 1 else "ri,ijr->rj"
        return rotate_to_body(np.einsum(subscripts, vector, estimate.rotations[:, :, 0]))

    state_values: dict[str, Callable[[Any], TaylorPolynomial] | TaylorPolynomial] = {}
    for state, first in suite.get_first_indices(sensor).items():
        if state in sensor.rotations:
            rotation = estimate.rotations[:, :, suite.rotation_indices.index(first)]
            state_values[state] = build_rotation_with_error(
                None if ignore_misalignments else rotation, first // 3, kind=kind
            )
        else:
            state_values[state] = add_error(estimate.states[first : first + 3].T, first // 3, kind)
    apply_bias_sensitivities(
        sensor.bias_sensitivities, state_values, channel_values, lambda value, state: state * value
    )
    predicted = sensor.predict_measurement(
        *apply_latency(sensor, state_values, [vector, *auxiliary_vectors], to_body, rate)
    )
    result: TaylorPolynomial = sensor.innovation(y, predicted)
    return result


def compute_jacobian(innovation: TaylorPolynomial) -> tuple[Ints, Floats]:
    """Return the measurement Jacobian H of an innovation, together with the indices of the states
    in its columns.

    Parameters
    ----------
    innovation : TaylorPolynomial
        Innovation from `compute_innovation`, with m components in r runs.

    Returns
    -------
    states : array of int, shape (p,)
        Indices of the states with a first-order term.
    H : array, shape (m, p, r)
        Negative derivative of the innovation with respect to the errors of these states.
    """
    numbers = tuple(term[0] for term in innovation.terms if len(term) == 1)
    H = np.empty((len(innovation.value), 3 * len(numbers), innovation.value.shape[-1]))
    for k, number in enumerate(numbers):
        np.negative(innovation.terms[(number,)], out=H[:, 3 * k : 3 * k + 3])
    return _list_states(numbers), H


def compute_second_order_moments(innovation: TaylorPolynomial, P: Floats) -> tuple[Floats, Floats]:
    """Return the mean and covariance of an innovation's second-order terms for normally distributed
    state errors.

    The term ½ eᵀ B e has the mean ½ tr(B P), and two terms have the covariance ½ tr(B P B' P).

    Parameters
    ----------
    innovation : TaylorPolynomial
        Innovation from `compute_innovation`, with m components.
    P : array, shape (n_states, n_states, n_runs)
        Covariance of the errors.

    Returns
    -------
    mean : array, shape (m, n_runs)
    covariance : array, shape (m, m, n_runs)
    """
    terms = {term: part for term, part in innovation.terms.items() if len(term) == 2}
    numbers = tuple(sorted({number for term in terms for number in term}))
    states = _list_states(numbers)
    m, n = len(innovation.value), len(states)
    half = np.zeros((m, n, n, P.shape[-1]))
    for (i, j), part in terms.items():
        a, b = 3 * numbers.index(i), 3 * numbers.index(j)
        half[:, a : a + 3, b : b + 3] += part.reshape(m, 3, 3, -1)
    B = half + half.swapaxes(1, 2)
    BP = np.einsum("qacr,cbr->qabr", B, P[states[:, None], states])
    mean = 0.5 * np.einsum("qaar->qr", BP)
    return mean, 0.5 * np.einsum("qabr,pbar->qpr", BP, BP)


@cache
def _list_states(numbers: tuple[int, ...]) -> Ints:
    return np.add.outer(3 * np.array(numbers, dtype=np.int64), np.arange(3)).ravel()
