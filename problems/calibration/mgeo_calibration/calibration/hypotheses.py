"""Hypotheses about gyro, sensors and orbit that a scenario does not model, for score tests."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.vector_sensors import Magnetometer

from mgeo_calibration.calibration.corrections import unit_of_innovations
from mgeo_calibration.estimation import departures as made
from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.independent_rates import independent_rates
from mgeo_calibration.estimation.residuals import Innovations
from mgeo_calibration.estimation.score import Combined, Departure, Score
from mgeo_calibration.estimation.smoother import Solution
from mgeo_calibration.telemetry.columns import channel_of
from mgeo_calibration.telemetry.telemetry import Telemetry

#: What the key is of something that no state has.
_SPLIT = "calibrate what is before and after on its own"
#: A gyro that reports the rate at its sample is early by half a step.
_SAMPLED = 'rate = "instantaneous" under [gyro] of the mapping, or its times'
#: How an offset may change: slowly, or at once.
_DRIFTS: tuple[made.Profile, ...] = (made.ramp, made.waves)
#: One in the first part looks like a prior that is wrong, and is left to that test.
_STEPS = tuple(made.step(number) for number in range(1, made.PARTS))
_SHARES = np.linspace(0.0, 1.0, 1001)
#: 1-sigmas by which a decay may be negative.
_FAR = 4.0
#: What says that a bias follows a channel; a misalignment follows none.
_INFLUENCES = "influences"
_TAKEN_OUT = "no state has it, take it out of what is read"
_MOST = 4  # other columns: each has a question for gyro and every sensor


@dataclass(frozen=True)
class Hypothesis:
    """An error that the scenario does not model.

    Attributes
    ----------
    options : tuple of Departure or Combined
        Alternative forms of the error, of which the one with the greatest evidence counts.
    says : function
        Describes the estimate of a score, with its 1-sigma.
    key : str
        Key of the scenario that models the error.
    possible : function
        Returns whether a score is physically possible.
    """

    options: tuple[Departure | Combined, ...]
    says: Callable[[Score], str]
    key: str
    possible: Callable[[Score], bool] = lambda score: True


def channels_of(
    telemetry: Telemetry, data: Batch, innovations: Sequence[Innovations]
) -> tuple[dict[str, Floats], int]:
    """The `_MOST` other columns that innovations follow most, at the samples; how many others."""
    found = {}
    for name, values in telemetry.others.items():
        channel = np.interp(data.times, telemetry.times, values)
        if np.ptp(channel) > 0.0:
            scaled = (channel - channel.mean()) / channel.std()
            told = sum(
                float(np.square(scaled[each.samples] @ each.whitened).sum())
                / max(len(each.samples), 1)
                for each in innovations
            )
            found[name] = told, channel
    most = sorted(found, key=lambda name: -found[name][0])[:_MOST]
    return {name: found[name][1] for name in most}, len(found) - len(most)


def hypotheses(solution: Solution, channels: Mapping[str, Floats]) -> dict[str, Hypothesis]:
    """Return all hypotheses, by name.

    Parameters
    ----------
    channels : mapping of str to array, shape (N,)
        What else was measured at the samples, in any unit.
    """
    rates = independent_rates(solution)
    changes = made.vector_rates(solution)
    tested = _of_gyro(solution, rates, channels) | _of_orbit(solution, changes)
    for index in range(len(solution.batch.suite.sensors)):
        if solution.used[index].any():
            late = made.delay(index, rates, changes)
            tested |= _of_sensor(solution, index, late, channels)
    return tested


def _of_gyro(
    solution: Solution, rates: Floats, channels: Mapping[str, Floats]
) -> dict[str, Hypothesis]:
    gyro, times = solution.batch.suite.gyro, solution.batch.times
    duration, size = float(times[-1] - times[0]), gyro.initial_bias_deg_s

    def decays(score: Score) -> str:
        found, sigma = score.estimate[0] / duration, score.sigma[0] / duration
        return f"gyro.bias decays by {sized(gyro.bias_decay + found, sigma)} 1/s, not " + (
            f"{gyro.bias_decay:g}"
        )

    def drifted(score: Score) -> str:
        return (
            f"gyro.bias drifts by {size * _range(_DRIFTS, score):.2g} deg/s, more than "
            f"rate_random_walk = {max(gyro.drift):g} explains"
        )

    rises = made.bias_drift(solution)
    tested = {
        "gyro.bias_decay": Hypothesis(
            (made.bias_decay(solution),),
            decays,
            "gyro.bias_decay",
            lambda score: gyro.bias_decay * duration + score.estimate[0] > -_FAR * score.sigma[0],
        ),
        "gyro.drift": Hypothesis(made.along(rises, _DRIFTS), drifted, "gyro.rate_random_walk"),
        "gyro.step": Hypothesis(
            made.along(rises, _STEPS), partial(_stepped, "gyro.bias", size, "deg/s", times), _SPLIT
        ),
    }
    for state, (factor, unit, key) in _ERRORS.items():
        if state not in gyro.states():
            says = partial(_worst, f"gyro.{state} is", factor, unit)
            departure = made.gyro_error(rates, state)
            tested[f"gyro.{state}"] = Hypothesis((departure,), says, f"gyro.{key}")
    if np.count_nonzero(solution.used.any(axis=1)) > 1:  # else it is the delay of the only sensor
        early = made.gyro_early(rates, solution.batch.durations)
        says = partial(_in_time, "gyro reports rates", "early", "late")
        tested["gyro.delay"] = Hypothesis((early,), says, _SAMPLED)
    for name, channel in channels.items():
        says = partial(_worst, f"gyro.bias follows {name} by", size / np.ptp(channel), "deg/s")
        departure = made.gyro_follows(solution, _scaled(channel))
        if not follows(gyro, name):
            tested[f"gyro.{name}"] = Hypothesis((departure,), says, f"gyro.{_INFLUENCES}")
    return tested


def follows(owner: Gyro | Sensor, column: str) -> bool:
    """Whether the bias of gyro or sensor follows a column of telemetry already."""
    return any(channel_of([column], each.channel) for each in owner.influences)


def _of_sensor(
    solution: Solution, index: int, late: Departure, channels: Mapping[str, Floats]
) -> dict[str, Hypothesis]:
    batch = solution.batch
    sensor, name = batch.suite.sensors[index], batch.suite.sensors[index].name
    shown = unit_of_innovations(sensor)
    unit, factor = shown.text, shown.factor
    sizes = 10.0 * float(np.max(sensor.noise())) * factor
    offset = f"{name}.{sensor.offset}"

    def wanders(score: Score) -> str:
        by = f"{offset} changes by {sizes * _range(_DRIFTS, score):.3g} {unit}"
        if not score.option:
            return f"{by}, evenly"
        return f"{by}, most about {_when(batch.times, _DRIFTS, score):.0f} s"

    rises = made.wander(solution, index)
    tested = {
        f"{name}.drift": Hypothesis(made.along(rises, _DRIFTS), wanders, _SPLIT),
        f"{name}.step": Hypothesis(
            made.along(rises, _STEPS), partial(_stepped, offset, sizes, unit, batch.times), _SPLIT
        ),
    }
    if "delay" not in sensor.states():
        says, key = partial(_in_time, f"{name} is", "late", "early"), f"{name}.initial_delay_s"
        tested[f"{name}.delay"] = Hypothesis((late,), says, key)
    for state in ("scale_factor", "nonorthogonality"):
        if isinstance(sensor, Magnetometer) and state not in sensor.states():
            size, of, key = _ERRORS[state]
            says = partial(_worst, f"{name}.{state} is", size, of)
            departure = made.vector_error(index, state)
            tested[f"{name}.{state}"] = Hypothesis((departure,), says, f"{name}.{key}")
    for other, channel in channels.items():
        says = partial(_worst, f"{offset} follows {other} by", sizes / np.ptp(channel), unit)
        departure = made.follows(index, _scaled(channel))
        key = f"{name}.{_INFLUENCES}" if "bias" in sensor.states() else _TAKEN_OUT
        if not follows(sensor, other):
            tested[f"{name}.{other}"] = Hypothesis((departure,), says, key)
    return tested


def _of_orbit(solution: Solution, changes: made.VectorRates) -> dict[str, Hypothesis]:
    sensors = solution.batch.suite.sensors
    if not any(isinstance(sensor, Magnetometer) for sensor in sensors):
        return {}
    shifted = made.along_track(len(sensors), changes)
    track = "its orbit along the track"
    says = partial(_in_time, "the satellite is", f"behind {track}", f"ahead of {track}")
    return {"orbit.along_track": Hypothesis((shifted,), says, "orbit, epoch")}


#: Factor to the unit of people, that unit, and the key of an initial 1-sigma.
_ERRORS = {
    "scale_factor": (1.0, "", "initial_scale_factor"),
    "misalignment": (float(np.degrees(1.0)), "deg", "initial_misalignment_deg"),
    "nonorthogonality": (float(np.degrees(1.0)), "deg", "initial_nonorthogonality_deg"),
}


def sized(value: float, sigma: float) -> str:
    """With its 1-sigma, to the same digit."""
    if not 0.0 < sigma < np.inf:
        return f"{value:.2g} ± {sigma:.1g}"
    digit = math.floor(math.log10(sigma))
    shown = round(value, -digit)
    digits = max(1, math.floor(math.log10(abs(shown) or sigma)) - digit + 1)
    text = f"{shown:.{-digit}f}" if -4 <= digit <= 0 else f"{shown:.{digits}g}"
    return f"{text} ± {sigma:.1g}"


def _worst(words: str, factor: float, unit: str, score: Score) -> str:
    """The axis that says most."""
    axis = int(np.argmax(np.abs(score.estimate) / score.sigma))
    value = sized(factor * score.estimate[axis], factor * score.sigma[axis])
    return " ".join(filter(None, (words, value, unit, f"along {'xyz'[axis]}")))


def _scaled(channel: Floats) -> Floats:
    """On a scale of order one, from its mean."""
    scaled: Floats = (channel - channel.mean()) / np.ptp(channel)
    return scaled


def _in_time(words: str, positive: str, negative: str, score: Score) -> str:
    """By how many seconds something is off, and to which side."""
    (off,), (sigma,) = score.estimate.tolist(), score.sigma.tolist()
    side = positive if off >= 0.0 else negative
    return f"{words} {sized(made.LATE * abs(off), made.LATE * sigma)} s {side}"


def _stepped(offset: str, size: float, unit: str, times: Floats, score: Score) -> str:
    """Describe an offset that changes at once."""
    by, at = size * _range(_STEPS, score), _when(times, _STEPS, score)
    return f"{offset} changes by {by:.3g} {unit} at about {at:.0f} s"


def _path(profiles: Sequence[made.Profile], score: Score) -> Floats:
    """What an offset goes through, shape (1001, 3)."""
    path: Floats = profiles[score.option](_SHARES) @ score.estimate.reshape(-1, 3)
    return path


def _range(profiles: Sequence[made.Profile], score: Score) -> float:
    return float(np.ptp(_path(profiles, score), axis=0).max())


def _when(times: Floats, profiles: Sequence[made.Profile], score: Score) -> float:
    """At which time an offset changes fastest; of a part in which it does the middle.

    Of one of which nothing is known, and so never changes, the middle of all.
    """
    speed = np.linalg.norm(np.diff(_path(profiles, score), axis=0), axis=1)
    fastest = np.flatnonzero(speed >= 0.999 * speed.max())
    share = 0.5 * (_SHARES[fastest[0]] + _SHARES[fastest[-1] + 1])
    return float(times[0] + share * (times[-1] - times[0]))
