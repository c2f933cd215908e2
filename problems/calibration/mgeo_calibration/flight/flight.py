"""The truth: what chance decides, true sensor errors, and what is reported."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.history import can_measure
from mgeo_attitude.filter.kernel import transition
from mgeo_attitude.filter.model import FilterModel, availability, sampled
from mgeo_attitude.geometry.rotation import matrix, rotation_vector
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.errors import influenced
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.readings import Readings, as_array, in_threes, taken
from mgeo_attitude.sensors.suite import Suite
from scipy.linalg import block_diag
from scipy.signal import lfilter


@dataclass(frozen=True)
class Draws:
    """Numbers of a run of n steps.

    Attributes
    ----------
    errors : array, shape (n_states,)
        True attitude error, gyro and sensor states at the start. Those that are rotations are
        vectors of `rotation.rotate`. The attitude is R(-θ) times the model's.
    gyro_noise : array, shape (n, n_dynamic)
        What noise adds in each step to the attitude error, the gyro's states and the sensors'
        processes, at rest.
    noise : array, shape (n + 1, n_sensors, 3)
        Measurement noise of every sensor at every sample; of one of fewer numbers the first count.
    """

    errors: Floats
    gyro_noise: Floats
    noise: Floats


def draw(model: FilterModel, n_steps: int, generator: np.random.Generator) -> Draws:
    """Draw a run of a scenario."""
    suite = model.suite
    (_, Q), k = at_rest(model), suite.n_kinematic
    # a bias that does not drift has no Cholesky factor
    variances, axes = np.linalg.eigh(Q[:k, :k])
    root = block_diag(axes * np.sqrt(np.maximum(variances, 0.0)), np.sqrt(Q[k:, k:]))
    sigma = in_threes(sensor.noise() for sensor in suite.sensors)
    chance = np.linalg.cholesky(model.initial_correlation) @ generator.standard_normal(
        suite.n_states
    )
    return Draws(
        with_errors(suite, model.initial_states, model.initial_sigma * chance),
        np.einsum("kj,ij->ki", generator.standard_normal((n_steps, suite.n_dynamic)), root),
        sigma * generator.standard_normal((n_steps + 1, *sigma.shape)),
    )


def with_errors(suite: Suite, states: Floats, errors: Floats) -> Floats:
    """States of which some have been estimated, shape (n_states,), and the errors of these."""
    true = states + errors
    for first in suite.rotations[1:]:
        block = slice(first, first + 3)
        if states[block].any():
            true[block] = rotation_vector(matrix(states[block]) @ matrix(errors[block]))
    return true


def at_rest(model: FilterModel) -> tuple[Floats, Floats]:
    """Transition and process noise of one step without rotation, both (n_dynamic, n_dynamic).

    Exact, the Markov process of equation (2) and its integral over the step together.
    """
    return transition(model.suite, (0.0, 0.0, 0.0), model.step)


@dataclass(frozen=True)
class Flight:
    """What happened in a run of n steps.

    Attributes
    ----------
    motion : Motion
        What is flown, exactly, from another attitude than planned.
    start : array, shape (3, 3)
        By what the true attitude is off the planned one, in GCRS axes: it is
        ``motion.attitude @ start``, for an error R(-θ) in body axes at the start.
    errors : array, shape (n_states,)
        True gyro and sensor states at the start; zero for the attitude.
    gyro : array, shape (n + 1, n_dynamic - 3)
        True states of the gyro, and of the sensors those that vary, at every sample.
    """

    motion: Motion
    start: Floats
    errors: Floats
    gyro: Floats
    readings: Readings


def coning(begin: Floats, end: Floats, step: float) -> Floats:
    """Mean of the rate over steps less the vector of their turn by their time [rad/s].

    To the third order in the step, of rates that change evenly from those at its begin to those at
    its end, shape (n, 3) (J. E. Bortz, A New Mathematical Formulation for Strapdown Inertial
    Navigation, IEEE Transactions on Aerospace and Electronic Systems AES-7 (1971) 61-66).
    """
    difference: Floats = -step / 12.0 * np.cross(begin, end)
    return difference


def unsteady(planned: FilterModel, design: Floats, n_steps: int, start: Floats) -> Floats:
    """`coning` of a design's n steps, from an attitude as `Flight.start` tells."""
    body = planned.turned(start.T)
    if body.slew_limits is None:  # rates change between steps
        return np.zeros((n_steps, 3))
    plan = body.schedule(design[None], n_steps)
    stretch = np.searchsorted(plan.starts[0], np.arange(n_steps), side="right") - 1
    end = plan.end_rates[0][stretch]
    return coning(np.vstack([body.initial_rate, end[:-1]]), end, body.step)


def moved(planned: FilterModel, design: Floats, n_steps: int, errors: Floats) -> Motion:
    """The motion of a design when the attitude at the start is off by the errors drawn.

    It is told from the attitude that is planned. Rates are flown as planned, but by coils, to which
    the field is another then.
    """
    start = _start(planned.initial_attitude, errors)
    return Motion.of(planned.turned(start.T), design, n_steps)


def _start(planned: Floats, errors: Floats) -> Floats:
    """`Flight.start` of the errors drawn, for an attitude planned at the start."""
    return matrix(-errors[:3] @ planned)


def gyro_of(model: FilterModel, rates: Floats, draws: Draws) -> tuple[Floats, Floats]:
    """`Flight.gyro` and what the gyro reports, shape (n, 3), of a body that turns at such rates."""
    suite, (F, _) = model.suite, at_rest(model)
    gyro = np.vstack([draws.errors[3 : len(F)], draws.gyro_noise[:, 3:]])
    for state, decay in zip(gyro.T, np.diag(F)[3:], strict=True):
        state[:] = lfilter([1.0], [1.0, -decay], state)  # a Gauss-Markov process
    x = {name: gyro[:-1, first - 3 : first] for name, first in suite.places(suite.gyro).items()}
    # what bias and noise turn the attitude by in a step is reported as their mean over it
    x["bias"] = -(np.diag(F[:3, 3:6]) * x["bias"] + draws.gyro_noise[:, :3]) / model.step
    follows = model.influences[1 : len(rates) + 1]
    influenced(suite.gyro.influences, x, columns(follows, suite, suite.gyro))
    return gyro, suite.gyro.measured(SimpleNamespace(**x), rates)


def fly_run(
    model: FilterModel, motion: Motion, draws: Draws, environment: Environment | None = None
) -> Flight:
    """Fly a plan with the errors that were drawn.

    Eclipses are those of the true orbit if the `environment` of the model is given, which has no
    shadow if the scenario has none, or else those that are believed.
    """
    suite = model.suite
    start, errors = _start(motion.attitude[0], draws.errors), draws.errors.copy()
    errors[:3] = 0.0
    gyro, reported = gyro_of(model, motion.rates, draws)
    attitude = motion.attitude @ start
    seen = model if environment is None else in_true_shadow(model, environment, gyro)
    readings = Readings(
        np.full(len(motion.rates), model.step),
        reported,
        tuple(
            _reported(seen, index, attitude, motion.rates, errors, gyro, draws.noise[:, index])
            for index in range(len(suite.sensors))
        ),
    )
    return Flight(motion, start, errors, gyro, readings)


def columns(influences: Floats, suite: Suite, owner: Gyro | Sensor) -> list[Floats]:
    """Those of an owner of all influences, shape (n, m), each of shape (n, 1)."""
    own = suite.influence_columns(owner)
    return [influences[:, [k]] for k in range(own.start, own.stop)]


def _reported(
    model: FilterModel,
    index: int,
    attitude: Floats,
    rates: Floats,
    errors: Floats,
    varying: Floats,
    noise: Floats,
) -> Floats:
    """What a sensor reports at every sample but the first, NaN where it sees nothing."""
    sensor = model.suite.sensors[index]
    x = {
        name: varying[:, first - 3 : first]
        if first < model.suite.n_dynamic
        else errors[first : first + 3]
        for name, first in model.suite.places(sensor).items()
    }

    def to_body(vector: Floats) -> Floats:
        turned: Floats = np.einsum(
            "kij,kj->ki", attitude, np.broadcast_to(vector, (len(attitude), 3))
        )
        return turned

    influenced(sensor.influences, x, columns(model.influences, model.suite, sensor))
    looks = model.references[:, model.suite.looks(index)].swapaxes(0, 1)
    rate = np.vstack([rates[:1], rates])  # of the step that leads to a sample
    report = sensor.measured(*taken(sensor, x, list(looks), to_body, rate))
    seen = can_measure(model, index, attitude, rates)
    seen[0] = False  # the start is what is believed
    reported = as_array(sensor.with_noise(report, noise[:, : len(sensor.noise())]))
    return np.where(seen[:, None, None], reported, np.nan)


def in_true_shadow(model: FilterModel, environment: Environment, varying: Floats) -> FilterModel:
    """A model whose sensors see the Sun where it truly shines, whoever believes what.

    Parameters
    ----------
    environment : Environment
        Of the orbit that is believed; without its shadow, nothing changes.
    varying : array, shape (n + 1, n_dynamic - 3)
        See `Flight.gyro`.
    """
    suite = model.suite
    if not suite.world.has_orbit_error or not environment.shadow:
        return model
    first = 3 * suite.blocks.index("world.orbit_error") - 3
    there = availability(suite, suite.world.displaced(environment, varying[:, first : first + 3]))
    for column, sensor in zip(there.T, suite.sensors, strict=True):
        column &= sampled(sensor, model.step, len(there))
    return dataclasses.replace(model, available=there)
