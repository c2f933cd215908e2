"""Gyro noise of single steps as states, for sensors with measurement latency.

A measurement with a latency of a fraction d of a step depends on (1 - d) θ_k + d θ_{k-1}. The
difference of both attitudes is the gyro rate without its noise. For a sensor that is more accurate
than one step of the gyro, the gyro noise changes the reading more than the latency does. The noise
is therefore estimated as a rate in the step that ends at the sample.
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
    """Owner of the step noise states, analogous to the gyro and the sensors."""

    process: GaussMarkov

    units: ClassVar[Mapping[str, Unit]] = {RATE_NOISE: DEG_H}
    considered: ClassVar[tuple[str, ...]] = ()
    bias_sensitivities: ClassVar[tuple[Any, ...]] = ()

    def states(self) -> dict[str, GaussMarkov]:
        """Return the noise process as a rate [rad/s]."""
        return {RATE_NOISE: self.process}


@dataclass(frozen=True)
class StepNoiseSuite(Suite):
    """Suite with step noise states for the sensors with measurement latency.

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
        late = isinstance(source, Sensor) and source.latency_states()
        return blocks | {RATE_NOISE: f"step.{RATE_NOISE}"} if late else blocks


def add_step_noise(batch: Batch, prior: PriorEstimate) -> tuple[Batch, PriorEstimate]:
    """Add step noise states to a batch and its prior if a sensor has a measurement latency.

    Returns
    -------
    batch : Batch
    belief : PriorEstimate
        The arguments themselves if no sensor has a latency.
    """
    suite = batch.suite
    if not any(sensor.latency_states() for sensor in suite.sensors):
        return batch, prior
    step = float(np.median(batch.durations))
    more = StepNoiseSuite(suite.gyro, suite.sensors, suite.environment_errors, step)
    begin, own = PriorEstimate.from_suite(more), list_states_without_step_noise(more)
    states, sigma, correlation = begin.states.copy(), begin.sigma.copy(), np.eye(more.n_states)
    states[own], sigma[own] = prior.states, prior.sigma
    correlation[np.ix_(own, own)] = prior.correlation
    wider = PriorEstimate(more, prior.attitude, states, sigma, correlation)
    return replace(batch, suite=more), wider


def list_states_without_step_noise(suite: Suite) -> Ints:
    """Return the indices of all states except the step noise."""
    return np.setdiff1d(np.arange(suite.n_states), _list_noise_states(suite))


def correlate_step_noise(suite: Suite, stochastic: Ints, durations: Floats, Q: Floats) -> None:
    """Correlate the step noise with the process noise of the attitude, in place.

    Parameters
    ----------
    stochastic : array of int, shape (d,)
        Stochastic states.
    durations : array, shape (n,)
        Durations of the steps [s].
    Q : array, shape (n, d, d)
        Process noise covariances of the steps.
    """
    own = np.flatnonzero(np.isin(stochastic, _list_noise_states(suite)))
    if not own.size:
        return
    axes = np.arange(3)
    rate = Q[:, axes, axes] / durations[:, None]
    Q[:, own, own] = (1.0 + EXCESS_VARIANCE) * rate / durations[:, None]
    Q[:, axes, own] = Q[:, own, axes] = rate


def _list_noise_states(suite: Suite) -> Ints:
    name = f"step.{RATE_NOISE}"
    first = 3 * suite.blocks.index(name) if name in suite.blocks else 0
    return np.arange(first, first + 3 * (name in suite.blocks))
