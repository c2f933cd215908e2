"""Hypotheses of the score tests: errors of gyro, sensors and orbit that a scenario omits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.error_models import expand_per_axis
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.vector_sensors import Magnetometer
from mgeo_attitude.settings.types import DEG_H, DIMENSIONLESS

from mgeo_calibration.estimation import model_errors
from mgeo_calibration.estimation.batch import RATE_MAGNITUDES, Batch
from mgeo_calibration.estimation.residuals import Innovations
from mgeo_calibration.estimation.score import ModelError, ModelErrorCombination, Score
from mgeo_calibration.estimation.smoother import Solution
from mgeo_calibration.telemetry.columns import find_channel, split_name_and_unit
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Actions for errors that no key of the scenario models.
_SPLIT_ACTION = "calibrate the data before and after the change separately"
_TIMING_ACTION = 'set rate = "instantaneous" under [gyro] of the mapping, or correct its times'
_REMOVAL_ACTION = "correct the readings, because no state models this error"
_ORBIT_ACTION = "check the orbit, the epoch and the clock of the telemetry"
#: Scenario key that models the dependence of an error on a housekeeping channel.
_SENSITIVITY_KEYS = {
    "bias": "bias_sensitivities",
    "misalignment": 'bias_sensitivities with error = "misalignment"',
}
#: Time profiles of an offset: slow drifts, and a step within one part of the data. The prior test
#: covers a step in the first part.
_DRIFT_PROFILES: tuple[model_errors.Profile, ...] = (
    model_errors.compute_linear_profile,
    model_errors.compute_cosine_profiles,
)
_STEP_PROFILES = tuple(
    model_errors.build_step_profile(number) for number in range(1, model_errors.N_PARTS)
)
#: Times at which an estimated offset is evaluated, as fractions of the duration of the data.
_TIME_FRACTIONS = np.linspace(0.0, 1.0, 1001)
#: Number of 1-sigmas by which a decay may be negative, and largest coefficient of an axes error for
#: which the model is linear.
_MAX_NEGATIVE_DECAY, _MAX_COEFFICIENT = 4.0, 5.0
#: Largest number of tested housekeeping channels. Each channel adds a hypothesis for the gyro and
#: for every sensor.
_MAX_CHANNELS = 4
_RARE_WEIGHT = 0.02
_LARGE_AXES_ERROR_DEG = float(np.degrees(model_errors.LARGE_AXES_ERROR))
#: Size of an axes error with a coefficient of one, its unit, and the key that models it.
_AXES_ERRORS = {
    "scale_factor": (model_errors.LARGE_AXES_ERROR, "", "initial_scale_factor"),
    "misalignment": (_LARGE_AXES_ERROR_DEG, "deg", "initial_misalignment_deg"),
    "nonorthogonality": (_LARGE_AXES_ERROR_DEG, "deg", "initial_nonorthogonality_deg"),
    "scale_asymmetry": (
        model_errors.LARGE_AXES_ERROR,
        "",
        f"bias_sensitivities of {', '.join(RATE_MAGNITUDES)}",
    ),
}


@dataclass(frozen=True)
class Hypothesis:
    """Hypothesis of a score test: the telemetry contains an error that the scenario does not model.
    The action of the hypothesis usually names the scenario key that models the error.

    Attributes
    ----------
    name : str
        Gyro or sensor, and error: for example ``mag.latency``.
    action : str
        What the user should do if the error exists, as an imperative.
    describe : function
        Formats the estimate of a score with its 1-sigma and unit.
    options : tuple of ModelError or ModelErrorCombination
        Alternative models of the error, of which the most significant is reported.
    is_applicable : bool
        False if the scenario already models the error.
    is_possible : function
        Returns whether a score is physically possible.
    observability_condition : str
        Condition in which the error is not observable.
    alternative_coefficient : float, optional
        Coefficient of an alternative convention that the user may have overlooked.
    weight : float
        Share of the significance level relative to other tests. Rare errors, and errors that are
        large if they exist, have a smaller weight.
    """

    name: str
    action: str
    describe: Callable[[Score], str]
    options: tuple[ModelError | ModelErrorCombination, ...]
    is_applicable: bool = True
    is_possible: Callable[[Score], bool] = lambda score: True
    observability_condition: str = "in this telemetry"
    alternative_coefficient: float | None = None
    weight: float = 1.0


def build_hypotheses(
    solution: Solution, channels: Mapping[str, Floats], has_gyro: bool = True
) -> dict[str, Hypothesis]:
    """Return the hypotheses that can be tested on a converged fit, one per unmodeled error, as a
    dict by name such as ``mag.latency``.

    Parameters
    ----------
    channels : mapping of str to array, shape (N,)
        Housekeeping channels at the samples of the fit, in any unit.
    has_gyro : bool
        False for a satellite without gyro, which has no gyro errors.
    """
    rates, changes = (
        model_errors.compute_smoothed_rates(solution),
        model_errors.build_vector_rates(solution),
    )
    tested = [*_list_gyro_hypotheses(solution, rates, channels)] if has_gyro else []
    for index in range(len(solution.batch.suite.sensors)):
        if solution.is_used[index].any():
            latency_error = model_errors.build_latency_error(index, rates, changes)
            tested += _list_sensor_hypotheses(solution, index, latency_error, channels)
    sensors = solution.batch.suite.sensors
    shifted = model_errors.build_along_track_error(len(sensors), changes)
    describe = partial(
        _format_time_shift,
        "the satellite is {} s behind the declared orbit",
        "the satellite is {} s ahead of the declared orbit",
    )
    has_field = any(isinstance(sensor, Magnetometer) for sensor in sensors)
    tested.append(Hypothesis("orbit.along_track", _ORBIT_ACTION, describe, (shifted,), has_field))
    return {each.name: each for each in tested if each.is_applicable}


def select_correlated_channels(
    telemetry: Telemetry, data: Batch, innovations: Sequence[Innovations]
) -> tuple[dict[str, Floats], int]:
    """Return the housekeeping channels that correlate most strongly with the innovations, and the
    number of channels left out. The channels are a dict of arrays, interpolated to the samples of
    the fit.
    """
    result = {}
    for name, values in telemetry.housekeeping.items():
        channel = np.interp(data.times, telemetry.times, values)
        if np.ptp(channel) > 0.0:
            scaled = (channel - channel.mean()) / channel.std()
            channel_correlation = sum(
                float(np.square(scaled[each.samples] @ each.whitened_values).sum())
                / max(len(each.samples), 1)
                for each in innovations
            )
            result[name] = channel_correlation, channel
    selected = sorted(result, key=lambda name: -result[name][0])[:_MAX_CHANNELS]
    return {name: result[name][1] for name in selected}, len(result) - len(selected)


def has_sensitivity(owner: Gyro | Sensor, column: str, error: str = "bias") -> bool:
    """Return True if the scenario contains a bias sensitivity of the gyro or sensor to a
    housekeeping channel, for the given kind of error.
    """
    return any(
        find_channel([column], each.channel)
        for each in owner.bias_sensitivities
        if each.error == error
    )


def _set_key(key: str, fit_key: str | None = None) -> str:
    """Format the action of setting a scenario key, or of estimating the state with --fit."""
    return f"set {key} in the scenario" + (f", or try --fit {fit_key}" if fit_key else "")


def _list_gyro_hypotheses(
    solution: Solution, rates: Floats, channels: Mapping[str, Floats]
) -> Iterator[Hypothesis]:
    gyro, batch = solution.batch.suite.gyro, solution.batch
    times, durations = batch.times, batch.durations
    duration = float(times[-1] - times[0])
    size = DEG_H.factor * math.radians(gyro.initial_bias_deg_s)

    def describe_decay(score: Score) -> str:
        result, sigma = score.estimate[0] / duration, score.sigma[0] / duration
        decay = format_with_sigma(gyro.bias_decay + result, sigma)
        return f"gyro.bias decays by {decay} 1/s, declared {gyro.bias_decay:g} 1/s"

    def is_decay_possible(score: Score) -> bool:
        total = gyro.bias_decay * duration + score.estimate[0]
        return bool(total > -_MAX_NEGATIVE_DECAY * score.sigma[0])

    def describe_drift(score: Score) -> str:
        by = size * _compute_range(_DRIFT_PROFILES, score)
        walk = by / DEG_H.factor / math.sqrt(duration)
        return (
            f"gyro.bias drifts by {_format_size(by)} deg/h, as with a random walk of about "
            f"{walk:.1g} rad/s^1.5, declared {max(gyro.effective_rate_random_walk):g} rad/s^1.5"
        )

    def describe_noise(score: Score) -> str:
        # Gyro and sensors contribute about half of the variance of a score each.
        more = 2.0 * max(0.0, score.chi_square / max(score.degrees_of_freedom, 1) - 1.0)
        walk = max(expand_per_axis(gyro.angle_random_walk_deg_per_sqrt_h)) * math.sqrt(1.0 + more)
        return f"gyro is noisier than declared, about {walk:.2g} deg/sqrt(h)"

    drift_error, steps = (
        model_errors.build_bias_drift_error(solution),
        partial(_format_step, "gyro.bias", size, DEG_H.text, times),
    )
    noise, decay = (
        (model_errors.build_gyro_noise_error(solution),),
        (model_errors.build_bias_decay_error(solution),),
    )
    constant = -gyro.bias_decay * duration or None
    walk, name = "gyro.angle_random_walk_deg_per_sqrt_h", "gyro.bias_decay"
    yield Hypothesis(
        name,
        _set_key(name),
        describe_decay,
        decay,
        is_possible=is_decay_possible,
        alternative_coefficient=constant,
    )
    yield Hypothesis(
        "gyro.drift",
        _set_key("gyro.rate_random_walk"),
        describe_drift,
        model_errors.build_profile_errors(drift_error, _DRIFT_PROFILES),
    )
    yield Hypothesis(
        "gyro.step",
        _SPLIT_ACTION,
        steps,
        model_errors.build_profile_errors(drift_error, _STEP_PROFILES),
    )
    yield Hypothesis("gyro.noise", _set_key(walk), describe_noise, noise, weight=_RARE_WEIGHT)
    modeled = {*gyro.states()} | (
        {"scale_asymmetry"} if has_sensitivity(gyro, RATE_MAGNITUDES[0]) else set()
    )
    for state in _AXES_ERRORS:
        yield _build_axes_hypothesis(
            "gyro",
            state,
            model_errors.build_gyro_parameter_error(rates, state),
            state not in modeled,
        )
    yield Hypothesis(
        "gyro.latency",
        _TIMING_ACTION,
        partial(
            _format_time_shift,
            "gyro rates precede their times by {} s",
            "gyro rates lag their times by {} s",
        ),
        (model_errors.build_gyro_time_tag_error(rates, durations),),
        # With a single sensor, a latency of the gyro is equivalent to a latency of the sensor.
        is_applicable=int(solution.is_used.any(axis=1).sum()) > 1,
        observability_condition="without rotations",
        alternative_coefficient=0.5 * float(np.median(durations)) / model_errors.LARGE_DELAY_S,
    )
    for column, channel in channels.items():
        model_error = model_errors.build_gyro_channel_error(solution, _scale_channel(channel))
        yield _build_channel_hypothesis(
            "gyro", gyro, "bias", (column, channel), model_error, (size, DEG_H.text)
        )


def _list_sensor_hypotheses(
    solution: Solution, index: int, latency: ModelError, channels: Mapping[str, Floats]
) -> Iterator[Hypothesis]:
    times, sensor = solution.batch.times, solution.batch.suite.sensors[index]
    name, states = sensor.name, sensor.states()
    unit = sensor.units.get(sensor.offset_state, DIMENSIONLESS)
    shown_unit = unit.text.removeprefix("-")
    size = model_errors.LARGE_OFFSET * float(np.max(sensor.noise_sigmas())) * unit.factor
    offset, drift_error = (
        f"{name}.{sensor.offset_state}",
        model_errors.build_offset_drift_error(solution, index),
    )

    def describe_drift(score: Score) -> str:
        change = size * _compute_range(_DRIFT_PROFILES, score)
        by = f"{offset} changes by {_format_size(change)} {shown_unit}".rstrip()
        if not score.alternative:
            return f"{by}, at a constant rate"
        return f"{by}, fastest at about {_find_change_time(times, _DRIFT_PROFILES, score):.0f} s"

    steps = partial(_format_step, offset, size, shown_unit, times)
    yield Hypothesis(
        f"{name}.drift",
        _SPLIT_ACTION,
        describe_drift,
        model_errors.build_profile_errors(drift_error, _DRIFT_PROFILES),
    )
    yield Hypothesis(
        f"{name}.step",
        _SPLIT_ACTION,
        steps,
        model_errors.build_profile_errors(drift_error, _STEP_PROFILES),
    )
    yield Hypothesis(
        f"{name}.latency",
        _set_key(f"{name}.initial_latency_s", f"{name}.latency"),
        partial(
            _format_time_shift,
            f"{name} readings lag their times by {{}} s",
            f"{name} readings precede their times by {{}} s",
        ),
        (latency,),
        is_applicable="latency" not in states,
        observability_condition="without rotations",
    )
    for state in ("scale_factor", "nonorthogonality"):
        if isinstance(sensor, Magnetometer):
            error = model_errors.build_vector_error(index, state)
            yield _build_axes_hypothesis(name, state, error, state not in states)
    for each in channels.items():
        channel = _scale_channel(each[1])
        model_error = model_errors.build_offset_channel_error(index, channel)
        yield _build_channel_hypothesis(
            name, sensor, sensor.offset_state, each, model_error, (size, shown_unit)
        )
        if "misalignment" in states and sensor.offset_state == "bias":
            model_error = model_errors.build_misalignment_channel_error(index, channel)
            yield _build_channel_hypothesis(
                name, sensor, "misalignment", each, model_error, (_LARGE_AXES_ERROR_DEG, "deg")
            )


def _build_axes_hypothesis(
    name: str, state: str, error: ModelError, is_applicable: bool
) -> Hypothesis:
    size, unit, key = _AXES_ERRORS[state]
    describe = partial(_format_worst_axis, f"{name}.{state} is", size, unit)
    weight = _RARE_WEIGHT if state == "scale_asymmetry" else 1.0
    return Hypothesis(
        f"{name}.{state}",
        _set_key(f"{name}.{key}", f"{name}.{state}"),
        describe,
        (error,),
        is_applicable,
        is_possible=lambda score: bool(np.abs(score.estimate).max() < _MAX_COEFFICIENT),
        observability_condition="without rotations",
        weight=weight,
    )


def _build_channel_hypothesis(
    name: str,
    owner: Gyro | Sensor,
    error: str,
    column: tuple[str, Floats],
    model_error: ModelError,
    size: tuple[float, str],
) -> Hypothesis:
    (channel_name, values), (large, unit) = column, size
    is_offset = error == (owner.offset_state if isinstance(owner, Sensor) else "bias")
    prefix = f"{name}." if is_offset else f"{name}.{error}."
    fit_key = f"{prefix}{split_name_and_unit(channel_name)[0]}"
    return Hypothesis(
        f"{prefix}{channel_name}",
        _set_key(f"{name}.{_SENSITIVITY_KEYS[error]}", fit_key)
        if error in _SENSITIVITY_KEYS
        else _REMOVAL_ACTION,
        partial(
            _format_worst_axis,
            f"{name}.{error} depends on {channel_name} by",
            large / np.ptp(values),
            f"{unit} per unit".lstrip(),
        ),
        (model_error,),
        is_applicable=not has_sensitivity(owner, channel_name, error),
        weight=1.0 if is_offset else _RARE_WEIGHT,
    )


def format_with_sigma(value: float, sigma: float) -> str:
    """Return a value and its 1-sigma as text such as ``0.124 ± 0.003``, with the value rounded to
    the leading digit of the 1-sigma.
    """
    if not 0.0 < sigma < np.inf:
        return f"{value:.2g} ± {sigma:.1g}"
    digit = math.floor(math.log10(sigma))
    shown = round(value, -digit)
    digits = max(1, math.floor(math.log10(abs(shown) or sigma)) - digit + 1)
    text = f"{shown:.{-digit}f}" if -4 <= digit <= 0 else f"{shown:.{digits}g}"
    return f"{text} ± {sigma:.1g}"


def _format_worst_axis(prefix: str, factor: float, unit: str, score: Score) -> str:
    axis = int(np.argmax(np.abs(score.estimate) / score.sigma))
    value = format_with_sigma(factor * score.estimate[axis], factor * score.sigma[axis])
    return " ".join(filter(None, (prefix, value, unit, f"along {'xyz'[axis]}")))


def _format_time_shift(positive: str, negative: str, score: Score) -> str:
    (off,), (sigma,) = score.estimate.tolist(), score.sigma.tolist()
    large = model_errors.LARGE_DELAY_S
    template = positive if off >= 0.0 else negative
    return template.format(format_with_sigma(large * abs(off), large * sigma))


def _format_step(offset: str, size: float, unit: str, times: Floats, score: Score) -> str:
    change, time = (
        size * _compute_range(_STEP_PROFILES, score),
        _find_change_time(times, _STEP_PROFILES, score),
    )
    amount = f"{_format_size(change)} {unit}".rstrip()
    return f"{offset} changes by {amount} at about {time:.0f} s"


def _format_size(value: float) -> str:
    return f"{value:.3g}" if value < 1000.0 else f"{value:.0f}"


def _scale_channel(channel: Floats) -> Floats:
    scaled: Floats = (channel - channel.mean()) / np.ptp(channel)
    return scaled


def _evaluate_offset(profiles: Sequence[model_errors.Profile], score: Score) -> Floats:
    """Return the time history of the sensor or gyro offset that a score test estimates, with one
    row for each time in `_TIME_FRACTIONS`.
    """
    path: Floats = profiles[score.alternative](_TIME_FRACTIONS) @ score.estimate.reshape(-1, 3)
    return path


def _compute_range(profiles: Sequence[model_errors.Profile], score: Score) -> float:
    return float(np.ptp(_evaluate_offset(profiles, score), axis=0).max())


def _find_change_time(
    times: Floats, profiles: Sequence[model_errors.Profile], score: Score
) -> float:
    """Return the time in seconds at which an estimated offset changes fastest. For an offset that
    changes at a constant rate, return the middle of the data.
    """
    speed = np.linalg.norm(np.diff(_evaluate_offset(profiles, score), axis=0), axis=1)
    fastest = np.flatnonzero(speed >= 0.999 * speed.max())
    fraction = 0.5 * (_TIME_FRACTIONS[fastest[0]] + _TIME_FRACTIONS[fastest[-1] + 1])
    return float(times[0] + fraction * (times[-1] - times[0]))
