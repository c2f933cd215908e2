"""Multiplicative error-state Kalman filter for many runs at once.

The last axis of all arrays except readings is the run. NumPy loops over some hundred runs are about
as fast as compiled code. The result of a run does not depend on the other runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from types import SimpleNamespace
from typing import Literal

import numpy as np
import pydantic.dataclasses
from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.kernel import compute_transition
from mgeo_attitude.geometry.rotation import exponential_map, multiply, rotation_vector
from mgeo_attitude.sensors.error_models import apply_bias_sensitivities
from mgeo_attitude.sensors.measurements import Measurements, unstack_measurement
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.base import Settings

from mgeo_calibration.estimation.innovation import (
    ZERO_RATE,
    Estimate,
    compute_innovation,
    compute_jacobian,
    compute_second_order_moments,
    reset_covariance,
)

NO_CHANNELS = np.zeros(0)


@pydantic.dataclasses.dataclass(frozen=True, kw_only=True)
class FilterSettings(Settings):
    """Options of the filter for second-order effects.

    The defaults are the options that `docs/consistency.md` recommends.

    Examples
    --------
    >>> from mgeo_calibration import Estimator
    >>> Estimator.plain() == Estimator(), Estimator().second_order
    (False, True)
    """

    jacobians: Literal["estimate", "aligned"] = "estimate"
    """misalignment at which measurement Jacobians are evaluated: the estimate, or zero"""
    second_order: bool = True
    """include mean and covariance of the second-order measurement terms (Jazwinski)"""
    reset: bool = True
    """transform the covariance when an estimated rotation error is applied (Markley)"""

    @staticmethod
    def build_textbook() -> FilterSettings:
        """Return the options of the textbook filter, with the H of equation (2)."""
        return FilterSettings(jacobians="aligned", second_order=False, reset=False)


@dataclass(frozen=True)
class ErrorStateFilter:
    """Error-state filter of a suite, with multiplicative rotation errors.

    Estimated errors are applied to the state after each update.
    """

    suite: Suite
    settings: FilterSettings

    def run(
        self,
        start: Estimate,
        readings: Sequence[Measurements],
        rates: Floats,
        vectors: Floats,
        channel_values: Floats | None = None,
    ) -> Iterator[tuple[Estimate, Estimate, Floats]]:
        """Estimate the state at every sample.

        Parameters
        ----------
        start : Estimate
            Estimate before the measurements of the first sample.
        readings : sequence of r Readings
            Readings of runs with equal steps.
        rates : array, shape (n, 3)
            Body rate in each step for the covariance propagation [rad/s].
        vectors : array, shape (n + 1, n_vectors, 3)
            Observed vectors and their gradients in GCRS; see `FilterModel.references`.
        channel_values : array, shape (n + 1, n_influences), optional
            Channels of bias sensitivities; see `Suite.compute_channel_deviations`. Required if the suite has
            any.

        Yields
        ------
        before, after : Estimate
            Estimates before and after the measurements of a sample.
        nis : array, shape (n_sensors, r)
            Normalized innovations squared; NaN where a sensor has no reading.
        """
        at_rate = cache(partial(compute_transition, self.suite))
        gyro = np.stack([run.gyro for run in readings], axis=1)
        sensors = [
            np.stack(runs, axis=1) for runs in zip(*(run.sensors for run in readings), strict=True)
        ]
        estimate = start
        follows = np.zeros((len(vectors), 0)) if channel_values is None else channel_values
        own = [follows[:, self.suite.find_sensitivity_columns(each)] for each in self.suite.sensors]
        of_gyro = follows[:, self.suite.find_sensitivity_columns(self.suite.gyro)]
        for k in range(len(vectors)):
            if k:
                step = float(readings[0].durations[k - 1])
                F, Q = at_rate(tuple(rates[k - 1].tolist()), step)
                rest, _ = at_rate((0.0, 0.0, 0.0), step)
                estimate = self.predict(estimate, gyro[k - 1], step, F, Q, rest, of_gyro[k])
            before, nis = estimate, np.full((len(sensors), len(readings)), np.nan)
            for index, reported in enumerate(sensors):
                if not np.isnan(reported[k]).all():
                    rate = rates[max(k - 1, 0)]
                    estimate, nis[index] = self.update(
                        estimate, index, reported[k], vectors[k], rate, own[index][k]
                    )
            yield before, estimate, nis

    def predict(
        self,
        estimate: Estimate,
        reported_rate: Floats,
        step: float,
        F: Floats,
        Q: Floats,
        rest_transition: Floats,
        channel_values: Floats = NO_CHANNELS,
    ) -> Estimate:
        """Propagate the estimate over a step, equation (3), with the corrected gyro rates.

        Parameters
        ----------
        reported_rate : array, shape (r, 3)
            Mean reported rate [rad/s].
        step : float
            Duration of the step [s].
        F, Q, rest_transition : arrays, shape (n_dynamic, n_dynamic)
            Transition matrix, process noise covariance, and transition matrix without rotation; see
            `transition`.
        channel_values : array, shape (m,)
            Channels of the gyro's bias sensitivities.
        """
        decay, mean_bias = (
            np.diag(rest_transition)[3:, None],
            -np.diag(rest_transition[:3, 3:6])[:, None] / step,
        )
        gyro, d = self.suite.gyro, self.suite.n_dynamic
        x = {
            state: estimate.states[i : i + 3]
            for state, i in self.suite.get_first_indices(gyro).items()
        }
        for number, state in enumerate((s for s in x if s in gyro.rotations), start=1):
            x[state] = rotation_vector(estimate.rotations[:, :, number])
        x["bias"] = mean_bias * x["bias"]
        apply_bias_sensitivities(gyro.bias_sensitivities, x, channel_values.tolist())
        own = SimpleNamespace(**{state: value.T for state, value in x.items()})
        turn = exponential_map(-step * gyro.correct_measurement(own, reported_rate).T)
        rotations, states = estimate.rotations.copy(), estimate.states.copy()
        rotations[:, :, 0] = multiply(rotations[:, :, 0], turn.swapaxes(0, 1))
        states[3:d] *= decay
        # Only the attitude rows of F are not diagonal.
        top = np.repeat(F[:3, :, None], turn.shape[-1], axis=-1)
        top[:, :3] = turn
        for columns, value in zip(self.suite.gyro_sensitivity_slices, channel_values, strict=True):
            top[:, columns] *= value
        P = estimate.covariance.copy()
        rows = multiply(top, P[:d])
        attitude = multiply(rows[:, :d], top.swapaxes(0, 1))
        rows[:, 3:d] *= decay
        P[3:d] *= decay[:, None]
        P[:, 3:d] *= decay
        P[:3], P[:, :3] = rows, rows.swapaxes(0, 1)
        P[:3, :3] = 0.5 * (attitude + attitude.swapaxes(0, 1))
        P[:d, :d] += Q[..., None]
        return Estimate(estimate.rotation_indices, rotations, states, P)

    def update(
        self,
        estimate: Estimate,
        index: int,
        readings: Floats,
        vectors: Floats,
        rate: Floats = ZERO_RATE,
        channel_values: Floats = NO_CHANNELS,
    ) -> tuple[Estimate, Floats]:
        """Update the estimate with the readings of a sensor, equation (4).

        Considered states keep their estimate and covariance.

        Parameters
        ----------
        index : int
            Index of the sensor in the suite.
        readings : array, shape (r, k, 3)
            Readings; NaN in runs without a reading, which are not updated.
        vectors : array, shape (n_vectors, 3)
            Observed vectors and their gradients in GCRS.
        rate : array, shape (3,)
            Body rate [rad/s]; see `readings.taken`.
        channel_values : array, shape (m,)
            Channels of the sensor's bias sensitivities.

        Returns
        -------
        estimate : Estimate
        nis : array, shape (r,)
            Normalized innovation squared.
        """
        options, P, seen = self.settings, estimate.covariance, ~np.isnan(readings[:, 0, 0])
        y = unstack_measurement(np.where(seen[:, None, None], readings, 0.0))
        considered = self.suite.considered_indices
        predicted = partial(
            compute_innovation,
            self.suite,
            index,
            y,
            vectors[index],
            gradient=tuple(vectors[self.suite.gradient_rows(index)]),
            rate=rate,
            channel_values=tuple(channel_values),
        )
        r = predicted(estimate)
        slopes = (
            predicted(estimate, ignore_misalignments=True) if options.jacobians == "aligned" else r
        )
        states, H = compute_jacobian(slopes)
        HP, z = multiply(H, P[states]), r.value
        S = multiply(HP[:, states], H.swapaxes(0, 1))
        for i, sigma in enumerate(self.suite.sensors[index].noise_sigmas()):
            S[i, i] += sigma**2
        if options.second_order:
            mean, covariance = compute_second_order_moments(slopes, P)
            z, S = z + mean, S + covariance
        G, w = whiten(S, HP, z)
        G *= seen
        e = (G * w[:, None]).sum(axis=0)
        e[considered] = 0.0
        nis = np.where(seen, (w * w).sum(axis=0), np.nan)
        columns = G.swapaxes(0, 1).copy()
        kept = P[considered[:, None], considered]
        learned = multiply(columns, G)
        P = np.subtract(P, learned, out=learned)
        P[considered[:, None], considered] = kept
        if options.reset:
            reset_covariance(P, e, estimate.rotation_indices)
        return estimate.correct(e, P), nis


def whiten(S: Floats, HP: Floats, z: Floats) -> tuple[Floats, Floats]:
    """Return L⁻¹ H P and L⁻¹ z for S = L Lᵀ; NaN if S is not positive definite."""
    rows = np.concatenate([S, HP, z[:, None]], axis=1)
    with np.errstate(invalid="ignore"):
        for i, row in enumerate(rows):
            row /= np.sqrt(row[i])
            for j in range(i + 1, len(rows)):
                rows[j] -= row[j] * row
    return rows[:, len(S) : -1], rows[:, -1]
