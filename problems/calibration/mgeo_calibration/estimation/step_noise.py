"""Gyro noise of single steps as states, for sensors with a measurement latency.

A measurement with a latency of a fraction d of a step depends on (1 - d) θ_k + d θ_{k-1}. The
difference of both attitudes is the gyro rate without its noise. If the sensor is more accurate than
one step of the gyro, the gyro noise changes the reading more than the latency does. The noise is
therefore estimated, as a rate in the step that ends at the sample.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.error_models import GaussMarkov
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.measurements import RATE_NOISE
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.types import DEG_H, Unit

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.telemetry.gyro_samples import compute_rate_sigma

#: Relative excess variance of the noise state over the process noise of the angle. Without an
#: excess the two would be perfectly correlated and their covariance singular.
EXCESS_VARIANCE = 1e-3
#: Correlation time of the noise state relative to a step: the noise of successive steps is
#: independent.
_RELATIVE_CORRELATION_TIME = 1e-3


@dataclass(frozen=True)
class StepNoise:
    """Gyro noise in the current step, as an additional error source of a suite."""

    process: GaussMarkov

    units: ClassVar[Mapping[str, Unit]] = {RATE_NOISE: DEG_H}
    considered: ClassVar[tuple[str, ...]] = ()
    bias_sensitivities: ClassVar[tuple[Any, ...]] = ()

    def states(self) -> dict[str, GaussMarkov]:
        """Return the Gauss-Markov process of the step noise [rad/s], keyed by state name."""
        return {RATE_NOISE: self.process}


@dataclass(frozen=True)
class StepNoiseSuite(Suite):
    """Suite that also estimates the gyro noise of the current step, for sensors with a measurement
    latency.

    Attributes
    ----------
    step : float
        Typical duration of a step [s].
    """

    step: float = 1.0

    @cached_property
    def error_sources(self) -> dict[str, Any]:
        x, y, z = np.broadcast_to(compute_rate_sigma(self, self.step), 3).tolist()
        process = GaussMarkov((x, y, z), _RELATIVE_CORRELATION_TIME * self.step)
        return {**super().error_sources, "step": StepNoise(process)}

    def list_blocks(self, source: Gyro | Sensor) -> dict[str, str]:
        blocks = super().list_blocks(source)
        has_latency = isinstance(source, Sensor) and source.latency_states()
        return blocks | {RATE_NOISE: f"step.{RATE_NOISE}"} if has_latency else blocks


def add_step_noise(batch: Batch, prior: PriorEstimate) -> tuple[Batch, PriorEstimate]:
    """Add states for the gyro noise of the current step to a batch and its prior, and return both.

    The arguments are returned unchanged if no sensor has a measurement latency.

    Parameters
    ----------
    batch : Batch
    prior : PriorEstimate
        Prior estimate at the first sample.

    Returns
    -------
    batch : Batch
        Batch with a `StepNoiseSuite`.
    prior : PriorEstimate
        Prior with the initial 1-sigma of the step noise.
    """
    suite = batch.suite
    if not any(sensor.latency_states() for sensor in suite.sensors):
        return batch, prior
    step = float(np.median(batch.durations))
    extended_suite = StepNoiseSuite(suite.gyro, suite.sensors, suite.environment_errors, step)
    initial, original_states = (
        PriorEstimate.from_suite(extended_suite),
        list_states_without_step_noise(extended_suite),
    )
    states, sigma, correlation = (
        initial.states.copy(),
        initial.sigma.copy(),
        np.eye(extended_suite.n_states),
    )
    states[original_states], sigma[original_states] = prior.states, prior.sigma
    correlation[np.ix_(original_states, original_states)] = prior.correlation
    extended_prior = PriorEstimate(extended_suite, prior.attitude, states, sigma, correlation)
    return replace(batch, suite=extended_suite), extended_prior


def list_states_without_step_noise(suite: Suite) -> Ints:
    """Return the indices of all states except the step noise.

    Parameters
    ----------
    suite : Suite
        Suite with or without step noise.
    """
    return np.setdiff1d(np.arange(suite.n_states), _list_noise_states(suite))


def correlate_step_noise(suite: Suite, stochastic: Ints, durations: Floats, Q: Floats) -> None:
    """Write the step noise variance and its covariance with the attitude to Q, in place.

    Both follow from the process noise of the attitude. Without step noise in the suite, the
    covariances are unchanged.

    Parameters
    ----------
    suite : Suite
    stochastic : array of int, shape (d,)
        Stochastic states.
    durations : array, shape (n,)
        Durations of the steps [s].
    Q : array, shape (n, d, d)
        Process noise covariances of the steps.
    """
    noise_columns = np.flatnonzero(np.isin(stochastic, _list_noise_states(suite)))
    if not noise_columns.size:
        return
    axes = np.arange(3)
    rate = Q[:, axes, axes] / durations[:, None]
    Q[:, noise_columns, noise_columns] = (1.0 + EXCESS_VARIANCE) * rate / durations[:, None]
    Q[:, axes, noise_columns] = Q[:, noise_columns, axes] = rate


def _list_noise_states(suite: Suite) -> Ints:
    name = f"step.{RATE_NOISE}"
    first = 3 * suite.blocks.index(name) if name in suite.blocks else 0
    return np.arange(first, first + 3 * (name in suite.blocks))
