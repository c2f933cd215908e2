"""Errors that a scenario does not model, for score tests: one list of hypotheses."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.errors import by_axis
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.vector_sensors import Magnetometer

from mgeo_calibration.calibration.corrections import unit_of_innovations
from mgeo_calibration.estimation import departures as made
from mgeo_calibration.estimation.batch import RATE_MAGNITUDES, Batch
from mgeo_calibration.estimation.residuals import Innovations
from mgeo_calibration.estimation.score import Combined, Departure, Score
from mgeo_calibration.estimation.smoother import Solution
from mgeo_calibration.telemetry.columns import channel_of
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Keys of errors that no state models.
_SPLIT = "calibrate what is before and after on its own"
_SAMPLED = 'rate = "instantaneous" under [gyro] of the mapping, or its times'
_INFLUENCES = "influences"
_FOLLOWS = {"bias": "{}.influences", "misalignment": '{}.influences with error = "misalignment"'}
_TAKEN_OUT = "no state models it, remove it from the readings"
#: Courses of an offset: slow ones, and a change within one part of the flight. A change in the
#: first part is left to the test of the prior.
_DRIFTS: tuple[made.Course, ...] = (made.ramp, made.waves)
_STEPS = tuple(made.step(number) for number in range(1, made.PARTS))
_SHARES = np.linspace(0.0, 1.0, 1001)
#: 1-sigmas by which a decay may be negative.
_FAR = 4.0
#: Other columns that are tested, at most: each has hypotheses for gyro and every sensor.
_MOST_CHANNELS = 4
_RARE = 0.2
#: Size of an axes error with a coefficient of one, its unit, and the key of its initial 1-sigma.
_AXES = {
    "scale_factor": (1.0, "", "initial_scale_factor"),
    "misalignment": (float(np.degrees(1.0)), "deg", "initial_misalignment_deg"),
    "nonorthogonality": (float(np.degrees(1.0)), "deg", "initial_nonorthogonality_deg"),
}


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """An error that the scenario does not model.

    Attributes
    ----------
    name : str
        Owner and error: ``mag.delay``.
    key : str
        Key of the scenario that models the error, or what to do.
    options : tuple of Departure or Combined
        Alternative forms of the error, of which the most significant counts.
    says : function
        Describes the estimate of a score, with its 1-sigma and unit.
    possible : function
        Returns whether a score is physically possible.
    shown_by : str
        What makes the error observable.
    instead : float, optional
        Coefficient that is likely if the error exists at all: a convention that was not declared.
    weight : float
        Share of the significance level, relative to other tests; less of an error that is rare, or
        large where it exists.
    """

    name: str
    key: str
    options: tuple[Departure | Combined, ...]
    says: Callable[[Score], str]
    possible: Callable[[Score], bool] = lambda score: True
    shown_by: str = "telemetry"
    instead: float | None = None
    weight: float = 1.0


def hypotheses(
    solution: Solution, channels: Mapping[str, Floats], has_gyro: bool = True
) -> dict[str, Hypothesis]:
    """Return all hypotheses that a flight can be tested for, by name.

    Parameters
    ----------
    channels : mapping of str to array, shape (N,)
        Other columns at the samples, in any unit.
    has_gyro : bool
        Whether the rates are measured; a satellite without gyro has no errors of a gyro.
    """
    rates, changes = made.smoothed_rates(solution), made.vector_rates(solution)
    tested = [*_of_gyro(solution, rates, channels)] if has_gyro else []
    for index in range(len(solution.batch.suite.sensors)):
        if solution.used[index].any():
            late = made.delay(index, rates, changes)
            tested += _of_sensor(solution, index, late, channels)
    tested += _of_orbit(solution, changes)
    return {each.name: each for each in tested}


def channels_of(
    telemetry: Telemetry, data: Batch, innovations: Sequence[Innovations]
) -> tuple[dict[str, Floats], int]:
    """Return the other columns that innovations follow most, and the number of the rest."""
    found = {}
    for name, values in telemetry.others.items():
        channel = np.interp(data.times, telemetry.times, values)
        if np.ptp(channel) > 0.0:
            scaled = (channel - channel.mean()) / channel.std()
            followed = sum(
                float(np.square(scaled[each.samples] @ each.whitened).sum())
                / max(len(each.samples), 1)
                for each in innovations
            )
            found[name] = followed, channel
    most = sorted(found, key=lambda name: -found[name][0])[:_MOST_CHANNELS]
    return {name: found[name][1] for name in most}, len(found) - len(most)


def follows(owner: Gyro | Sensor, column: str, error: str = "bias") -> bool:
    """Return whether the scenario models that an error of an owner follows a column."""
    return any(
        channel_of([column], each.channel) for each in owner.influences if each.error == error
    )


def _of_gyro(
    solution: Solution, rates: Floats, channels: Mapping[str, Floats]
) -> Iterator[Hypothesis]:
    gyro, batch = solution.batch.suite.gyro, solution.batch
    times, durations = batch.times, batch.durations
    duration, size = float(times[-1] - times[0]), gyro.initial_bias_deg_s
    walk = max(by_axis(gyro.angle_random_walk_deg_per_sqrt_h))

    def decays(score: Score) -> str:
        found, sigma = score.estimate[0] / duration, score.sigma[0] / duration
        return f"gyro.bias decays by {sized(gyro.bias_decay + found, sigma)} 1/s, not " + (
            f"{gyro.bias_decay:g}"
        )

    def is_noisy(score: Score) -> str:
        # about half of the variance of a score is the gyro's, the other half the sensors'
        more = 2.0 * max(0.0, score.chi_square / max(score.freedom, 1) - 1.0)
        noisier = walk * math.sqrt(1.0 + more)
        return f"gyro is noisier than declared, about {noisier:.2g} deg/sqrt(h)"

    yield Hypothesis(
        name="gyro.bias_decay",
        key="gyro.bias_decay",
        options=(made.bias_decay(solution),),
        says=decays,
        possible=lambda score: (
            gyro.bias_decay * duration + score.estimate[0] > -_FAR * score.sigma[0]
        ),
        instead=-gyro.bias_decay * duration or None,
    )

    def drifts(score: Score) -> str:
        by = size * _range(_DRIFTS, score)
        walk = math.radians(by) / math.sqrt(duration)
        return (
            f"gyro.bias drifts by {by:.2g} deg/s, as with a random walk of about {walk:.1g}, not "
            f"{max(gyro.drift):g} rad/s^1.5"
        )

    rises = made.bias_drift(solution)
    yield Hypothesis(
        name="gyro.drift",
        key="gyro.rate_random_walk",
        options=made.along(rises, _DRIFTS),
        says=drifts,
    )
    yield Hypothesis(
        name="gyro.step",
        key=_SPLIT,
        options=made.along(rises, _STEPS),
        says=partial(_stepped, "gyro.bias", size, "deg/s", times),
    )
    yield Hypothesis(
        name="gyro.noise",
        key="gyro.angle_random_walk_deg_per_sqrt_h",
        options=(made.gyro_noise(solution),),
        says=is_noisy,
        weight=_RARE,
    )
    if not any(follows(gyro, magnitude) for magnitude in RATE_MAGNITUDES):
        yield Hypothesis(
            name="gyro.scale_asymmetry",
            key=f"gyro.{_INFLUENCES} of {', '.join(RATE_MAGNITUDES)}",
            options=(made.gyro_error(rates, "scale_asymmetry"),),
            says=partial(_worst, "gyro.scale_asymmetry is", made.LARGE_AXES_ERROR, ""),
            shown_by="rotation",
            weight=_RARE,
        )
    for state, (factor, unit, key) in _AXES.items():
        if state not in gyro.states():
            yield Hypothesis(
                name=f"gyro.{state}",
                key=f"gyro.{key}",
                options=(made.gyro_error(rates, state),),
                says=partial(_worst, f"gyro.{state} is", made.LARGE_AXES_ERROR * factor, unit),
                shown_by="rotation",
            )
    if np.count_nonzero(solution.used.any(axis=1)) > 1:  # else it is the delay of the only sensor
        yield Hypothesis(
            name="gyro.delay",
            key=_SAMPLED,
            options=(made.gyro_early(rates, durations),),
            says=partial(_in_time, "gyro reports rates", "early", "late"),
            shown_by="rotation",
            instead=0.5 * float(np.median(durations)) / made.LARGE_DELAY_S,
        )
    for column, channel in channels.items():
        if not follows(gyro, column):
            yield Hypothesis(
                name=f"gyro.{column}",
                key=f"gyro.{_INFLUENCES}",
                options=(made.gyro_follows(solution, _scaled(channel)),),
                says=partial(
                    _worst, f"gyro.bias follows {column} by", size / np.ptp(channel), "deg/s"
                ),
            )


def _of_sensor(
    solution: Solution, index: int, late: Departure, channels: Mapping[str, Floats]
) -> Iterator[Hypothesis]:
    batch = solution.batch
    sensor, name = batch.suite.sensors[index], batch.suite.sensors[index].name
    shown = unit_of_innovations(sensor)
    size = made.LARGE_OFFSET * float(np.max(sensor.noise())) * shown.factor
    offset = f"{name}.{sensor.offset}"

    def wanders(score: Score) -> str:
        by = f"{offset} changes by {size * _range(_DRIFTS, score):.3g} {shown.text}"
        if not score.option:
            return f"{by}, evenly"
        return f"{by}, most about {_when(batch.times, _DRIFTS, score):.0f} s"

    rises = made.wander(solution, index)
    yield Hypothesis(
        name=f"{name}.drift", key=_SPLIT, options=made.along(rises, _DRIFTS), says=wanders
    )
    yield Hypothesis(
        name=f"{name}.step",
        key=_SPLIT,
        options=made.along(rises, _STEPS),
        says=partial(_stepped, offset, size, shown.text, batch.times),
    )
    if "delay" not in sensor.states():
        yield Hypothesis(
            name=f"{name}.delay",
            key=f"{name}.initial_delay_s",
            options=(late,),
            says=partial(_in_time, f"{name} is", "late", "early"),
            shown_by="rotation",
        )
    for state in ("scale_factor", "nonorthogonality"):
        if isinstance(sensor, Magnetometer) and state not in sensor.states():
            factor, unit, key = _AXES[state]
            yield Hypothesis(
                name=f"{name}.{state}",
                key=f"{name}.{key}",
                options=(made.vector_error(index, state),),
                says=partial(_worst, f"{name}.{state} is", made.LARGE_AXES_ERROR * factor, unit),
                shown_by="rotation",
            )
    for column, channel in channels.items():
        if not follows(sensor, column, sensor.offset):
            yield Hypothesis(
                name=f"{name}.{column}",
                key=_FOLLOWS.get(sensor.offset, _TAKEN_OUT).format(name),
                options=(made.follows(index, _scaled(channel)),),
                says=partial(
                    _worst, f"{offset} follows {column} by", size / np.ptp(channel), shown.text
                ),
            )
        turns = "misalignment" in sensor.states() and sensor.offset == "bias"
        if turns and not follows(sensor, column, "misalignment"):
            per_unit = np.degrees(made.LARGE_AXES_ERROR) / np.ptp(channel)
            yield Hypothesis(
                name=f"{name}.misalignment.{column}",
                key=_FOLLOWS["misalignment"].format(name),
                options=(made.turns_with(index, _scaled(channel)),),
                says=partial(_worst, f"{name}.misalignment follows {column} by", per_unit, "deg"),
                weight=_RARE,
            )


def _of_orbit(solution: Solution, changes: made.VectorRates) -> Iterator[Hypothesis]:
    sensors = solution.batch.suite.sensors
    if any(isinstance(sensor, Magnetometer) for sensor in sensors):
        track = "its orbit along the track"
        yield Hypothesis(
            name="orbit.along_track",
            key="orbit, epoch",
            options=(made.along_track(len(sensors), changes),),
            says=partial(_in_time, "the satellite is", f"behind {track}", f"ahead of {track}"),
        )


def sized(value: float, sigma: float) -> str:
    """Format a value with its 1-sigma, to the same digit."""
    if not 0.0 < sigma < np.inf:
        return f"{value:.2g} ± {sigma:.1g}"
    digit = math.floor(math.log10(sigma))
    shown = round(value, -digit)
    digits = max(1, math.floor(math.log10(abs(shown) or sigma)) - digit + 1)
    text = f"{shown:.{-digit}f}" if -4 <= digit <= 0 else f"{shown:.{digits}g}"
    return f"{text} ± {sigma:.1g}"


def _worst(words: str, factor: float, unit: str, score: Score) -> str:
    """Describe the most significant axis."""
    axis = int(np.argmax(np.abs(score.estimate) / score.sigma))
    value = sized(factor * score.estimate[axis], factor * score.sigma[axis])
    return " ".join(filter(None, (words, value, unit, f"along {'xyz'[axis]}")))


def _in_time(words: str, positive: str, negative: str, score: Score) -> str:
    """Describe a time by its size and sign."""
    (off,), (sigma,) = score.estimate.tolist(), score.sigma.tolist()
    side = positive if off >= 0.0 else negative
    return f"{words} {sized(made.LARGE_DELAY_S * abs(off), made.LARGE_DELAY_S * sigma)} s {side}"


def _stepped(offset: str, size: float, unit: str, times: Floats, score: Score) -> str:
    """Describe an offset that changes at once."""
    by, at = size * _range(_STEPS, score), _when(times, _STEPS, score)
    return f"{offset} changes by {by:.3g} {unit} at about {at:.0f} s"


def _scaled(channel: Floats) -> Floats:
    """Return a channel without its mean, over its range."""
    scaled: Floats = (channel - channel.mean()) / np.ptp(channel)
    return scaled


def _path(courses: Sequence[made.Course], score: Score) -> Floats:
    """Return the offset over the flight, shape (1001, 3)."""
    path: Floats = courses[score.option](_SHARES) @ score.estimate.reshape(-1, 3)
    return path


def _range(courses: Sequence[made.Course], score: Score) -> float:
    return float(np.ptp(_path(courses, score), axis=0).max())


def _when(times: Floats, courses: Sequence[made.Course], score: Score) -> float:
    """Return the time at which an offset changes fastest, the middle if it changes evenly."""
    speed = np.linalg.norm(np.diff(_path(courses, score), axis=0), axis=1)
    fastest = np.flatnonzero(speed >= 0.999 * speed.max())
    share = 0.5 * (_SHARES[fastest[0]] + _SHARES[fastest[-1] + 1])
    return float(times[0] + share * (times[-1] - times[0]))
