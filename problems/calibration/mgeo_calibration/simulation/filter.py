"""Multiplicative error-state Kalman filter for many Monte Carlo runs at once.

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
    """Options of the error-state Kalman filter that control second-order effects.

    The defaults are the options that `docs/validation/consistency.md` recommends.

    Examples
    --------
    >>> from mgeo_calibration import FilterSettings
    >>> FilterSettings.build_textbook() == FilterSettings(), FilterSettings().second_order
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
        """Return the settings of a first-order filter without second-order terms or a covariance
        reset. Measurement Jacobians are evaluated at zero misalignments.

        These Jacobians are the H of equation (2).
        """
        return FilterSettings(jacobians="aligned", second_order=False, reset=False)


@dataclass(frozen=True)
class ErrorStateFilter:
    """Error-state Kalman filter for a gyro and sensors, with multiplicative rotation errors.

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
        """Filter the measurements of several runs. For each sample, yield the estimates before and
        after its measurements, and the normalized innovations squared.

        Parameters
        ----------
        start : Estimate
            Estimate before the measurements of the first sample.
        readings : sequence of r Measurements
            Measurements of r runs with equal steps.
        rates : array, shape (n, 3)
            Body rate in each step for the covariance propagation [rad/s].
        vectors : array, shape (n + 1, n_vectors, 3)
            Observed vectors and their gradients in GCRS; see `FilterModel.references`.
        channel_values : array, shape (n + 1, n_sensitivities), optional
            Channels of the bias sensitivities; see `Suite.compute_channel_deviations`. Required if
            the suite has bias sensitivities.

        Yields
        ------
        before, after : Estimate
            Estimates of all runs before and after the measurements of a sample.
        nis : array, shape (n_sensors, r)
            Normalized innovations squared; NaN where a sensor has no reading.
        """
        transition_at_rate = cache(partial(compute_transition, self.suite))
        gyro = np.stack([run.gyro for run in readings], axis=1)
        sensors = [
            np.stack(runs, axis=1) for runs in zip(*(run.sensors for run in readings), strict=True)
        ]
        estimate = start
        channels = np.zeros((len(vectors), 0)) if channel_values is None else channel_values
        sensor_channels = [
            channels[:, self.suite.find_sensitivity_columns(each)] for each in self.suite.sensors
        ]
        gyro_channels = channels[:, self.suite.find_sensitivity_columns(self.suite.gyro)]
        for k in range(len(vectors)):
            if k:
                step = float(readings[0].durations[k - 1])
                F, Q = transition_at_rate(tuple(rates[k - 1].tolist()), step)
                rest_transition, _ = transition_at_rate((0.0, 0.0, 0.0), step)
                estimate = self.predict(
                    estimate, gyro[k - 1], step, F, Q, rest_transition, gyro_channels[k]
                )
            before, nis = estimate, np.full((len(sensors), len(readings)), np.nan)
            for index, reported in enumerate(sensors):
                if not np.isnan(reported[k]).all():
                    rate = rates[max(k - 1, 0)]
                    estimate, nis[index] = self.update(
                        estimate, index, reported[k], vectors[k], rate, sensor_channels[index][k]
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
        """Propagate the estimate over one step with the corrected gyro rates.

        The covariance follows equation (3) of docs/explanation/models-and-filter.md.

        Parameters
        ----------
        estimate : Estimate
            Estimate at the start of the step.
        reported_rate : array, shape (r, 3)
            Mean measured rate in the step [rad/s].
        step : float
            Duration of the step [s].
        F, Q, rest_transition : arrays, shape (n_dynamic, n_dynamic)
            Transition matrix, process noise covariance, and transition matrix without rotation; see
            `compute_transition`.
        channel_values : array, shape (m,)
            Channels of the gyro's bias sensitivities.

        Returns
        -------
        Estimate
            Estimate at the end of the step.
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
        gyro_states = SimpleNamespace(**{state: value.T for state, value in x.items()})
        rotation = exponential_map(-step * gyro.correct_measurement(gyro_states, reported_rate).T)
        rotations, states = estimate.rotations.copy(), estimate.states.copy()
        rotations[:, :, 0] = multiply(rotations[:, :, 0], rotation.swapaxes(0, 1))
        states[3:d] *= decay
        # Only the attitude rows of F are not diagonal.
        F_attitude = np.repeat(F[:3, :, None], rotation.shape[-1], axis=-1)
        F_attitude[:, :3] = rotation
        for columns, value in zip(self.suite.gyro_sensitivity_slices, channel_values, strict=True):
            F_attitude[:, columns] *= value
        P = estimate.covariance.copy()
        rows = multiply(F_attitude, P[:d])
        attitude = multiply(rows[:, :d], F_attitude.swapaxes(0, 1))
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
        """Update the estimate with the readings of one sensor. Return the new estimate and the
        normalized innovations squared.

        The update is equation (4) of docs/explanation/models-and-filter.md. Considered states keep
        their estimate and covariance.

        Parameters
        ----------
        estimate : Estimate
            Estimate before the readings.
        index : int
            Index of the sensor in the suite.
        readings : array, shape (r, k, 3)
            Readings; NaN in runs without a reading, which are not updated.
        vectors : array, shape (n_vectors, 3)
            Observed vectors and their gradients in GCRS.
        rate : array, shape (3,)
            Body rate [rad/s]; see `measurements.apply_latency`.
        channel_values : array, shape (m,)
            Channels of the sensor's bias sensitivities.

        Returns
        -------
        estimate : Estimate
            Estimate after the readings.
        nis : array, shape (r,)
            Normalized innovation squared; NaN in runs without a reading.
        """
        settings, P, has_reading = self.settings, estimate.covariance, ~np.isnan(readings[:, 0, 0])
        y = unstack_measurement(np.where(has_reading[:, None, None], readings, 0.0))
        considered = self.suite.considered_indices
        linearize = partial(
            compute_innovation,
            self.suite,
            index,
            y,
            vectors[index],
            auxiliary_vectors=tuple(vectors[self.suite.find_auxiliary_rows(index)]),
            rate=rate,
            channel_values=tuple(channel_values),
        )
        r = linearize(estimate)
        expansion = (
            linearize(estimate, ignore_misalignments=True) if settings.jacobians == "aligned" else r
        )
        states, H = compute_jacobian(expansion)
        HP, z = multiply(H, P[states]), r.value
        S = multiply(HP[:, states], H.swapaxes(0, 1))
        for i, sigma in enumerate(self.suite.sensors[index].noise_sigmas()):
            S[i, i] += sigma**2
        if settings.second_order:
            mean, covariance = compute_second_order_moments(expansion, P)
            z, S = z + mean, S + covariance
        G, w = whiten(S, HP, z)
        G *= has_reading
        e = (G * w[:, None]).sum(axis=0)
        e[considered] = 0.0
        nis = np.where(has_reading, (w * w).sum(axis=0), np.nan)
        columns = G.swapaxes(0, 1).copy()
        considered_covariance = P[considered[:, None], considered]
        reduction = multiply(columns, G)
        P = np.subtract(P, reduction, out=reduction)
        P[considered[:, None], considered] = considered_covariance
        if settings.reset:
            reset_covariance(P, e, estimate.rotation_indices)
        return estimate.correct(e, P), nis


def whiten(S: Floats, HP: Floats, z: Floats) -> tuple[Floats, Floats]:
    """Multiply H P and the innovation z by the inverse Cholesky factor of the innovation covariance
    S.

    Parameters
    ----------
    S : array, shape (m, m, r)
        Innovation covariances S = L Lᵀ of r runs.
    HP : array, shape (m, n_states, r)
    z : array, shape (m, r)

    Returns
    -------
    L⁻¹ H P : array, shape (m, n_states, r)
    L⁻¹ z : array, shape (m, r)
        NaN in runs in which S is not positive definite.
    """
    rows = np.concatenate([S, HP, z[:, None]], axis=1)
    with np.errstate(invalid="ignore"):
        for i, row in enumerate(rows):
            row /= np.sqrt(row[i])
            for j in range(i + 1, len(rows)):
                rows[j] -= row[j] * row
    return rows[:, len(S) : -1], rows[:, -1]
