"""The truth: exact rotations, true sensor errors, and what is reported of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.reference import attitudes
from mgeo_attitude.filter.timeline import flown
from mgeo_attitude.flight.draws import Draws, at_rest
from mgeo_attitude.rotation import matrix, multiply
from mgeo_attitude.sensors.readings import Readings, as_array

Floats = NDArray[np.float64]

#: Samples at a time: what is computed of some hundred runs stays in the cache.
_SAMPLES = 256


@dataclass(frozen=True)
class Motion:
    """A plan on n steps, from body axes along those of GCRS.

    Attributes
    ----------
    rates : array, shape (n, 3)
        Body rate in each step [rad/s].
    attitude : array, shape (n + 1, 3, 3)
        GCRS to body.
    """

    rates: Floats
    attitude: Floats

    @classmethod
    def of(cls, model: FilterModel, design: ArrayLike, n_steps: int) -> Motion:
        """Of a design, shape (4 m,)."""
        plan = flown(design, n_steps * model.step, model.step, model.agility)
        starts = np.rint(plan.times[:-1] / model.step).astype(np.int64)
        stretch = np.searchsorted(starts, np.arange(n_steps), side="right") - 1
        return cls(plan.rates[stretch], attitudes(plan.rates, starts, n_steps, model.step))


@dataclass(frozen=True)
class Flight:
    """What happened in r runs of n steps of one plan.

    Attributes
    ----------
    motion : Motion
        What is flown, exactly, from another attitude than planned.
    start : array, shape (3, 3, r)
        True attitude at the start, GCRS to body.
    errors : array, shape (r, n_states)
        True gyro and sensor states at the start; zero for the attitude.
    gyro : array, shape (n + 1, r, n_dynamic - 3)
        True states of the gyro at every sample.
    readings : Readings
    """

    motion: Motion
    start: Floats
    errors: Floats
    gyro: Floats
    readings: Readings

    def attitude(self, sample: int) -> Floats:
        """True attitude at a sample, GCRS to body, shape (3, 3, r)."""
        return multiply(self.motion.attitude[sample][..., None], self.start)

    def states(self, sample: int) -> Floats:
        """True gyro and sensor states at a sample, shape (n_states, r)."""
        states = self.errors.copy()
        states[:, 3 : 3 + self.gyro.shape[-1]] = self.gyro[sample]
        return states.T


def fly_runs(model: FilterModel, motion: Motion, draws: Draws) -> Flight:
    """Fly a plan once for each run that was drawn."""
    start, errors = matrix(-draws.errors[:, :3].T), draws.errors.copy()
    errors[:, :3] = 0.0
    gyro = _gyro_states(model, draws)
    readings = Readings(
        np.full(len(motion.rates), model.step),
        _gyro_readings(model, motion, gyro, draws.gyro_noise),
        tuple(
            _sensor_readings(model, index, motion, start, errors, draws.noise[:, :, index])
            for index in range(len(model.suite.sensors))
        ),
    )
    return Flight(motion, start, errors, gyro, readings)


def _gyro_states(model: FilterModel, draws: Draws) -> Floats:
    """The gyro's states at every sample: each a Markov process of its own."""
    noise = draws.gyro_noise[:, :, 3:]
    decay = np.diag(at_rest(model)[0])[3:]
    states = np.empty((len(noise) + 1, *noise.shape[1:]))
    states[0] = draws.errors[:, 3 : 3 + len(decay)]
    for k, added in enumerate(noise):
        states[k + 1] = decay * states[k] + added
    return states


def _gyro_readings(model: FilterModel, motion: Motion, states: Floats, noise: Floats) -> Floats:
    """Mean of the reported rate over each step, noise and drift of the bias included."""
    gyro, places = model.suite.gyro, model.suite.places(model.suite.gyro)
    turned = np.diag(at_rest(model)[0][:3, 3:6])  # what a bias of one turns the attitude by

    def some(steps: slice) -> Floats:
        x = {state: states[:-1][steps, :, first - 3 : first] for state, first in places.items()}
        x["bias"] = -(turned * x["bias"] + noise[steps, :, :3]) / model.step
        return gyro.measured(SimpleNamespace(**x), motion.rates[steps, None])

    return _by_parts(some, len(motion.rates))


def _sensor_readings(
    model: FilterModel, index: int, motion: Motion, start: Floats, errors: Floats, noise: Floats
) -> Floats:
    """What a sensor reports at every sample but the first, NaN where it sees nothing."""
    sensor = model.suite.sensors[index]
    places = model.suite.places(sensor)
    x = {state: errors[:, first : first + 3] for state, first in places.items()}
    boresight, half_angle = sensor.field_of_view() or ((0.0, 0.0, 0.0), np.pi)

    def some(samples: slice) -> Floats:
        turn = motion.attitude[samples]

        def to_body(vector: Floats) -> Floats:
            vectors = np.einsum("ijr,kj->kri", start, np.broadcast_to(vector, (len(turn), 3)))
            turned: Floats = np.einsum("kij,krj->kri", turn, vectors)
            return turned

        v = to_body(model.references[samples, index])
        report = sensor.measured(SimpleNamespace(to_body=to_body, **x), v)
        seen = (v * boresight).sum(axis=-1) >= np.cos(half_angle)
        seen &= model.available[samples, index, None]
        reported = as_array(sensor.with_noise(report, noise[samples]))
        return np.where(seen[..., None, None], reported, np.nan)

    readings = _by_parts(some, len(motion.attitude))
    readings[0] = np.nan
    return readings


def _by_parts(function: Callable[[slice], Floats], n: int) -> Floats:
    """A function of samples, some of them at a time."""
    return np.concatenate([function(slice(k, k + _SAMPLES)) for k in range(0, n, _SAMPLES)])
