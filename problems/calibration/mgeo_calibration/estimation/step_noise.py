"""The gyro's noise in single steps as states, where readings are of a time between two samples.

A reading that is late by a part d of a step is of (1 - d) θ_k + d θ_{k-1}. Between these attitudes
is what the gyro reports without its noise: beside a sensor that is better than a step of the gyro
that is more than what the delay changes. So the noise is estimated, as a rate in the step to each
sample, and the turn back is at the rate without it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.errors import GaussMarkov
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.readings import NOISE
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.types import DEG_H, Unit

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.telemetry.gyro_samples import gyro_noise

#: Share of its variance by which the state is free of the angle that it adds to: with none their
#: covariance has no inverse.
SLACK = 1e-3
#: Of a step, after which nothing is left of it.
_SHORT = 1e-3


@dataclass(frozen=True)
class Steps:
    """Whose the states are, as gyro and sensors own theirs."""

    process: GaussMarkov

    units: ClassVar[Mapping[str, Unit]] = {NOISE: DEG_H}
    considered: ClassVar[tuple[str, ...]] = ()
    influences: ClassVar[tuple[Any, ...]] = ()

    def states(self) -> dict[str, GaussMarkov]:
        """The noise, as a rate [rad/s]."""
        return {NOISE: self.process}


@dataclass(frozen=True)
class WithStepNoise(Suite):
    """A suite whose sensors with a delay see the gyro's noise of the step to their sample.

    Attributes
    ----------
    step : float
        Usual duration of one [s].
    """

    step: float = 1.0

    @cached_property
    def owners(self) -> dict[str, Any]:
        x, y, z = np.broadcast_to(gyro_noise(self, self.step), 3).tolist()
        process = GaussMarkov((x, y, z), _SHORT * self.step)
        return {**super().owners, "step": Steps(process)}

    def blocks_of(self, owner: Gyro | Sensor) -> dict[str, str]:
        blocks = super().blocks_of(owner)
        late = isinstance(owner, Sensor) and owner.delay()
        return blocks | {NOISE: f"step.{NOISE}"} if late else blocks


def for_delays(batch: Batch, belief: Belief) -> tuple[Batch, Belief]:
    """Add these states to the suite of a batch and of a belief if a sensor has a delay."""
    suite = batch.suite
    if not any(sensor.delay() for sensor in suite.sensors):
        return batch, belief
    step = float(np.median(batch.durations))
    more = WithStepNoise(suite.gyro, suite.sensors, suite.world, step)
    begin, own = Belief.initial(more), without_step_noise(more)
    states, sigma, correlation = begin.states.copy(), begin.sigma.copy(), np.eye(more.n_states)
    states[own], sigma[own] = belief.states, belief.sigma
    correlation[np.ix_(own, own)] = belief.correlation
    wider = Belief(more, belief.attitude, states, sigma, correlation)
    return replace(batch, suite=more), wider


def without_step_noise(suite: Suite) -> Ints:
    """All states but those."""
    return np.setdiff1d(np.arange(suite.n_states), _states(suite))


def correlate(suite: Suite, driven: Ints, durations: Floats, Q: Floats) -> None:
    """Let the states of steps be what adds to the angle about each axis, in their covariances Q."""
    own = np.flatnonzero(np.isin(driven, _states(suite)))
    if not own.size:
        return
    axes = np.arange(3)
    rate = Q[:, axes, axes] / durations[:, None]
    Q[:, own, own] = (1.0 + SLACK) * rate / durations[:, None]
    Q[:, axes, own] = Q[:, own, axes] = rate


def _states(suite: Suite) -> Ints:
    name = f"step.{NOISE}"
    first = 3 * suite.blocks.index(name) if name in suite.blocks else 0
    return np.arange(first, first + 3 * (name in suite.blocks))
