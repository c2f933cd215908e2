"""Monte Carlo run of a plan with exact rates: random errors, true motion and sensor readings."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.history import can_measure
from mgeo_attitude.filter.kernel import compute_transition
from mgeo_attitude.filter.model import FilterModel, compute_availability, find_sample_instants
from mgeo_attitude.geometry.rotation import rotation_matrix, rotation_vector
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.error_models import apply_bias_sensitivities
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.measurements import (
    Measurements,
    apply_latency,
    stack_measurement,
    stack_noise_sigmas,
)
from mgeo_attitude.sensors.suite import Suite
from scipy.linalg import block_diag
from scipy.signal import lfilter


@dataclass(frozen=True)
class RandomErrors:
    """Initial errors, process noise and measurement noise of a simulated run.

    Attributes
    ----------
    initial_errors : array, shape (n_states,)
        True attitude error θ, and true gyro and sensor states at the start. Rotations are vectors
        of `rotation.rotate`. The true attitude is R(-θ) times the attitude of the model.
    process_noise : array, shape (n, n_dynamic)
        Increments of the attitude error, the gyro states and the sensor processes in each step, for
        a body at rest.
    measurement_noise : array, shape (n + 1, n_sensors, 3)
        Measurement noise of every sensor at every sample, padded to three components.
    """

    initial_errors: Floats
    process_noise: Floats
    measurement_noise: Floats


def draw_errors(model: FilterModel, n_steps: int, generator: np.random.Generator) -> RandomErrors:
    """Draw the random errors of a run from the covariances of a filter model."""
    suite = model.suite
    (_, Q), k = discretize_at_rest(model), suite.n_kinematic
    # The covariance of a constant bias is singular and has no Cholesky factor.
    variances, axes = np.linalg.eigh(Q[:k, :k])
    root = block_diag(axes * np.sqrt(np.maximum(variances, 0.0)), np.sqrt(Q[k:, k:]))
    sigma = stack_noise_sigmas(sensor.noise_sigmas() for sensor in suite.sensors)
    chance = np.linalg.cholesky(model.initial_correlation) @ generator.standard_normal(
        suite.n_states
    )
    return RandomErrors(
        add_errors(suite, model.initial_states, model.initial_sigma * chance),
        np.einsum("kj,ij->ki", generator.standard_normal((n_steps, suite.n_dynamic)), root),
        sigma * generator.standard_normal((n_steps + 1, *sigma.shape)),
    )


def add_errors(suite: Suite, states: Floats, errors: Floats) -> Floats:
    """Add errors to estimated states, and return the true states. Rotation errors are composed with
    the estimated rotations.
    """
    true = states + errors
    for first in suite.rotation_indices[1:]:
        block = slice(first, first + 3)
        if states[block].any():
            true[block] = rotation_vector(
                rotation_matrix(states[block]) @ rotation_matrix(errors[block])
            )
    return true


def discretize_at_rest(model: FilterModel) -> tuple[Floats, Floats]:
    """Return the transition matrix and process noise covariance of one filter step at zero body
    rate.

    Returns
    -------
    F, Q : arrays, shape (n_dynamic, n_dynamic)
        Discretization of the Markov process of equation (2) and its integral over the step.
    """
    return compute_transition(model.suite, (0.0, 0.0, 0.0), model.step)


@dataclass(frozen=True)
class SimulatedRun:
    """True motion, true states and sensor readings of a run with n steps.

    Attributes
    ----------
    motion : Motion
        Motion of the plan, executed exactly.
    initial_rotation : array, shape (3, 3)
        Rotation of the true attitude from the planned attitude, in GCRS axes. The true attitude is
        ``motion.attitude @ initial_rotation``.
    initial_states : array, shape (n_states,)
        True gyro and sensor states at the start; the attitude block is zero.
    varying_states : array, shape (n + 1, n_dynamic - 3)
        True gyro states and varying sensor states at every sample.
    readings : Measurements
    """

    motion: Motion
    initial_rotation: Floats
    initial_states: Floats
    varying_states: Floats
    readings: Measurements


def compute_coning_correction(start_rates: Floats, end_rates: Floats, step: float) -> Floats:
    """Return the coning correction of each step: the mean rate minus the rotation vector per unit
    time.

    Third-order expansion for linearly varying rates (J. E. Bortz, A New Mathematical Formulation
    for Strapdown Inertial Navigation, IEEE Transactions on Aerospace and Electronic Systems AES-7
    (1971) 61-66).

    Parameters
    ----------
    start_rates, end_rates : arrays, shape (n, 3)
        Rates at the start and at the end of each step [rad/s].
    step : float
        Duration of a step [s].
    """
    difference: Floats = -step / 12.0 * np.cross(start_rates, end_rates)
    return difference


def compute_design_coning(
    nominal_model: FilterModel, design: Floats, n_steps: int, initial_rotation: Floats
) -> Floats:
    """Return the coning correction of each step of a design, executed from the true initial
    attitude.

    Parameters
    ----------
    nominal_model : FilterModel
        Model with the planned initial attitude.
    design : array, shape (4 m,)
    n_steps : int
    initial_rotation : array, shape (3, 3)
        See `SimulatedRun`.

    Returns
    -------
    array, shape (n_steps, 3)
        [rad/s]
    """
    body = nominal_model.rotate_initial_attitude(initial_rotation.T)
    if body.slew_limits is None:  # The rate is constant within each step.
        return np.zeros((n_steps, 3))
    plan = body.build_schedule(design[None], n_steps)
    maneuver = np.searchsorted(plan.starts[0], np.arange(n_steps), side="right") - 1
    end = plan.end_rates[0][maneuver]
    return compute_coning_correction(np.vstack([body.initial_rate, end[:-1]]), end, body.step)


def compute_true_motion(
    nominal_model: FilterModel, design: Floats, n_steps: int, errors: Floats
) -> Motion:
    """Return the true motion of a satellite that executes a design from its true initial attitude.

    The motion is given relative to the planned attitude. Its rates are the planned rates, except
    for magnetorquers, whose torque depends on the field in the body frame.

    Parameters
    ----------
    errors : array, shape (n_states,)
        See `RandomErrors.initial_errors`.
    """
    start = _build_initial_rotation(nominal_model.initial_attitude, errors)
    return Motion.from_design(nominal_model.rotate_initial_attitude(start.T), design, n_steps)


def _build_initial_rotation(nominal_attitude: Floats, errors: Floats) -> Floats:
    """Return the rotation from the planned to the true initial attitude, in GCRS axes."""
    return rotation_matrix(-errors[:3] @ nominal_attitude)


def simulate_gyro(
    model: FilterModel, rates: Floats, random_errors: RandomErrors
) -> tuple[Floats, Floats]:
    """Simulate a gyro along a motion, and return its true states and reported rates.

    Parameters
    ----------
    model : FilterModel
        True model.
    rates : array, shape (n, 3)
        True mean body rate in each step [rad/s].
    random_errors : RandomErrors

    Returns
    -------
    gyro : array, shape (n + 1, n_dynamic - 3)
        See `SimulatedRun.varying_states`.
    reported : array, shape (n, 3)
        Reported rates [rad/s].
    """
    suite, (F, _) = model.suite, discretize_at_rest(model)
    gyro = np.vstack([random_errors.initial_errors[3 : len(F)], random_errors.process_noise[:, 3:]])
    for state, decay in zip(gyro.T, np.diag(F)[3:], strict=True):
        state[:] = lfilter([1.0], [1.0, -decay], state)  # Gauss-Markov process
    x = {
        name: gyro[:-1, first - 3 : first]
        for name, first in suite.get_first_indices(suite.gyro).items()
    }
    # The gyro reports the mean rate error over the step.
    x["bias"] = -(np.diag(F[:3, 3:6]) * x["bias"] + random_errors.process_noise[:, :3]) / model.step
    follows = model.sensitivity_factors[1 : len(rates) + 1]
    apply_bias_sensitivities(
        suite.gyro.bias_sensitivities, x, select_sensitivity_channels(follows, suite, suite.gyro)
    )
    return gyro, suite.gyro.predict_measurement(SimpleNamespace(**x), rates)


def simulate_run(
    model: FilterModel,
    motion: Motion,
    random_errors: RandomErrors,
    environment: Environment | None = None,
) -> SimulatedRun:
    """Simulate the true states and sensor readings of a run from its motion and random errors.

    Parameters
    ----------
    model : FilterModel
        True model.
    motion : Motion
    random_errors : RandomErrors
    environment : Environment, optional
        Environment of the model. If given, eclipses follow the true orbit, otherwise the estimated
        orbit.
    """
    suite = model.suite
    start, errors = (
        _build_initial_rotation(motion.attitude[0], random_errors.initial_errors),
        random_errors.initial_errors.copy(),
    )
    errors[:3] = 0.0
    gyro, reported = simulate_gyro(model, motion.rates, random_errors)
    attitude = motion.attitude @ start
    sensor_model = model if environment is None else apply_true_eclipses(model, environment, gyro)
    readings = Measurements(
        np.full(len(motion.rates), model.step),
        reported,
        tuple(
            _simulate_readings(
                sensor_model,
                index,
                attitude,
                motion.rates,
                errors,
                gyro,
                random_errors.measurement_noise[:, index],
            )
            for index in range(len(suite.sensors))
        ),
    )
    return SimulatedRun(motion, start, errors, gyro, readings)


def select_sensitivity_channels(
    channel_deviations: Floats, suite: Suite, owner: Gyro | Sensor
) -> list[Floats]:
    """Return the housekeeping channels that affect the bias of a gyro or sensor, one array of
    shape (n, 1) per bias sensitivity.

    Parameters
    ----------
    channel_deviations : array, shape (n, m)
        Deviations of the channels from their reference, for gyro and all sensors.
    """
    own = suite.find_sensitivity_columns(owner)
    return [channel_deviations[:, [k]] for k in range(own.start, own.stop)]


def _simulate_readings(
    model: FilterModel,
    index: int,
    attitude: Floats,
    rates: Floats,
    errors: Floats,
    varying_states: Floats,
    noise: Floats,
) -> Floats:
    """Simulate the readings of one sensor. Readings are NaN at the first sample and where the
    sensor cannot measure.
    """
    sensor = model.suite.sensors[index]
    x = {
        name: varying_states[:, first - 3 : first]
        if first < model.suite.n_dynamic
        else errors[first : first + 3]
        for name, first in model.suite.get_first_indices(sensor).items()
    }

    def to_body(vector: Floats) -> Floats:
        rotated: Floats = np.einsum(
            "kij,kj->ki", attitude, np.broadcast_to(vector, (len(attitude), 3))
        )
        return rotated

    apply_bias_sensitivities(
        sensor.bias_sensitivities,
        x,
        select_sensitivity_channels(model.sensitivity_factors, model.suite, sensor),
    )
    references = model.references[:, model.suite.list_vector_indices(index)].swapaxes(0, 1)
    rate = np.vstack([rates[:1], rates])  # rate of the step that ends at each sample
    report = sensor.predict_measurement(*apply_latency(sensor, x, list(references), to_body, rate))
    is_measured = can_measure(model, index, attitude, rates)
    is_measured[0] = False  # The prior describes the start.
    reported = stack_measurement(sensor.add_noise(report, noise[:, : len(sensor.noise_sigmas())]))
    return np.where(is_measured[:, None, None], reported, np.nan)


def apply_true_eclipses(
    model: FilterModel, environment: Environment, varying_states: Floats
) -> FilterModel:
    """Return a copy of a filter model with eclipses along the true orbit.

    Parameters
    ----------
    environment : Environment
        Environment of the estimated orbit.
    varying_states : array, shape (n + 1, n_dynamic - 3)
        See `SimulatedRun`.
    """
    suite = model.suite
    if not suite.environment_errors.has_orbit_error or not environment.has_eclipses:
        return model
    first = 3 * suite.blocks.index("environment_errors.orbit_error") - 3
    available = compute_availability(
        suite,
        suite.environment_errors.displace_position(
            environment, varying_states[:, first : first + 3]
        ),
    )
    for column, sensor in zip(available.T, suite.sensors, strict=True):
        column &= find_sample_instants(sensor, model.step, len(available))
    return dataclasses.replace(model, available=available)
