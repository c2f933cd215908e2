"""Checks of times, positions, field strengths and rates against the orbit and the field model of
the scenario.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import product, takewhile

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.constants import (
    DAY,
    EARTH_RADIUS,
    FIELD_MODEL_END,
    FIELD_MODEL_START,
)
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.frames import rotate, rotation_to_gcrs
from mgeo_attitude.environment.times import TAI_OFFSETS, compute_julian_dates, tai_minus_utc
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.environment_errors import FIELD_UNIT_NT
from mgeo_attitude.sensors.vector_sensors import Magnetometer

from mgeo_calibration.telemetry.findings import Finding, Samples
from mgeo_calibration.telemetry.mapping import UNITS

_MAX_GAP = DAY  # longest time between samples [s]
_MIN_STEP = 3e-4  # shortest median time between samples [s]
_MAX_SAMPLES = 200  # largest number of compared samples
_MIN_SAMPLES = 12  # smallest number of compared samples
_MIN_UNIT_FACTOR = 4.0  # factor of the field strength that indicates another unit
_MAX_EPOCH_DISTANCE = 366.0 * DAY  # largest time from the epoch of the orbit [s]
_MAX_RADIUS = 1e9  # largest radius of a satellite [m]
_FRAMES = ("TOD", "TEME", "ITRF")  # EME2000 agrees with GCRF within a meter.
# smallest distance from the orbit that indicates another frame or time scale [m]
_MIN_ORBIT_DISTANCE = 5e3
_MAX_FRAME_DISTANCE = 1.5e3  # largest distance between TOD and TEME [m]
# largest fraction of the distance that another frame or time scale may leave
_MAX_FRAME_RESIDUAL, _MAX_SCALE_RESIDUAL = 0.2, 0.06
_MAX_MEDIAN_MISFIT = 3.0  # largest median misfit of the field strength, in 1-sigmas
_FIELD_MODEL_ERROR = 0.003  # relative error of the field model
_N_ITERATIONS = 4  # number of iterations for the bias of a magnetometer
_MAX_SCALE_ERROR = 0.1  # 1-sigma of a scale error that may explain wrong field strengths
_NORMAL_MEDIAN = 0.6745  # median magnitude of a standard normal variable
_FIELD_ROTATION_RATE = 0.15  # rotation rate of the field direction along a low orbit [deg/s]
_LAGS = (1, 2, 4, 8, 16, 32, 64)  # number of samples between compared vectors
# smallest bias, relative to the field strength, that corrupts field directions
_MAX_BIAS_RATIO = 0.1
_MAX_ROTATION = 1.0  # largest rotation between compared vectors [rad]


def find_invalid_times(samples: Samples) -> Iterator[Finding]:
    """Yield a finding if times are far from the epoch or outside the range of the field model, if
    the time unit appears wrong, or if the samples have a long gap.
    """
    times, epoch = samples.telemetry.times, samples.scenario.epoch
    start, end = ((limit - epoch).total_seconds() for limit in (FIELD_MODEL_START, FIELD_MODEL_END))
    inside = (times >= start) & (times <= end) & (np.abs(times) < _MAX_EPOCH_DISTANCE)
    steps = np.diff(times)
    years = f"{FIELD_MODEL_START:%Y-%m-%d} to {FIELD_MODEL_END:%Y-%m-%d}"
    result = []
    if not inside.all():
        k = int(np.argmin(inside))
        expected = (
            f"a time within a year of the epoch, and within the field model, IGRF-14, {years}"
        )
        result.append((k, f"{times[k] / DAY:.6g} days after the epoch", expected))
    if (steps > _MAX_GAP).any():
        k = int(np.argmax(steps > _MAX_GAP))
        expected = f"a sample at least every {_MAX_GAP:g} s"
        result.append((k, f"{steps[k]:.6f} s until the next sample", expected))
    if len(steps) and (step := np.median(steps)) < _MIN_STEP:
        value = f"{step:.3g} s until the next sample (median)"
        result.append((0, value, f"{_MIN_STEP:g} s or more"))
    advice = "declare time_epoch and time_unit, or correct the scenario's epoch"
    for k, value, expected in result:
        yield Finding(samples.mapping.time, samples.format_place(k), value, expected, advice)


def find_invalid_norms(samples: Samples) -> Iterator[Finding]:
    """Yield a finding for each satellite position, and for each vector sensor, with an implausible
    vector length, which indicates a wrong unit.
    """
    position = samples.telemetry.position
    if position is not None:
        radius = _compute_length(position)
        outside = (radius < EARTH_RADIUS) | (radius > _MAX_RADIUS)
        for row in np.flatnonzero(outside).tolist():
            value = f"a radius of {radius[row]:.6g} m"
            expected = f"{EARTH_RADIUS:.6g} to {_MAX_RADIUS:.6g} m"
            advice = "declare position.unit and position.scale"
            yield Finding("position", samples.format_place(row), value, expected, advice)
    for sensor, k, measured, strength in _select_vectors(samples):
        result, should = (float(np.median(each)) for each in (_compute_length(measured), strength))
        bias = np.sqrt(3.0) * sensor.initial_bias_nt if isinstance(sensor, Magnetometer) else 0.0
        if not should / _MIN_UNIT_FACTOR - bias < result < should * _MIN_UNIT_FACTOR + 3.0 * bias:
            ratio, unit = should / result if result else np.inf, sensor.telemetry_unit.text
            fits = [u for u, by in UNITS[unit].items() if 0.25 < ratio / by < 4.0]
            unit_key = f"unit = {fits[0]!r}" if fits else "unit or scale"
            advice = f"declare {unit_key} of {sensor.name}"
            advice += ", or a larger initial_bias_nt in the scenario" if bias else ""
            value = f"a length of {result:.3g} {unit} (median)"
            expected = f"about {should:.5g} {unit}"
            yield Finding(sensor.name, samples.format_place(k[0]), value, expected, advice)


def find_inconsistent_positions(samples: Samples) -> Iterator[Finding]:
    """Yield a finding if the positions are far from the orbit of the scenario but agree with the
    orbit in another reference frame or time scale.

    Positions that deviate from the scenario's orbit by more than `_MIN_ORBIT_DISTANCE` are compared
    with the orbit for each frame and time scale. The finding names the frame or time scale that
    explains the deviation.
    """
    telemetry, mapping = samples.telemetry, samples.mapping
    if telemetry.position is None or len(k := _select_samples(telemetry.position)) < _MIN_SAMPLES:
        return
    times, position, epoch = telemetry.times[k], telemetry.position[k], samples.scenario.epoch
    utc = {"UTC": 0.0} | {s: tai_minus_utc(epoch) - behind for s, behind in TAI_OFFSETS.items()}
    shifts = {name: utc[name] - utc[mapping.time_scale] for name in utc}
    orbit = {}
    for name, shift in shifts.items():
        if mapping.time_system is None or name == mapping.time_scale:
            with suppress(ValueError, ArithmeticError):  # The orbit may not cover all times.
                orbit[name] = samples.scenario.orbit.propagate(epoch, times - shift)[0]
    if mapping.time_scale not in orbit:
        return
    at = compute_julian_dates(epoch, times)
    frames = {"": position}
    if mapping.position.frame is None:
        frames |= {name: rotate(rotation_to_gcrs(name, at), position) for name in _FRAMES}
    distances = {
        (frame, scale): float(np.median(_compute_length(there - where)))
        for (frame, there), (scale, where) in product(frames.items(), orbit.items())
    }
    (frame, scale), min_distance = min(distances.items(), key=lambda each: each[1])
    distance = distances["", mapping.time_scale]
    descriptions, keys = [], []
    if frame:
        alike = [f for f in _FRAMES if distances[f, scale] < min_distance + _MAX_FRAME_DISTANCE]
        descriptions.append(f"positions look like {' or '.join(alike)}")
        keys.append("position.frame")
    if scale != mapping.time_scale:
        descriptions.append(f"time tags look like {scale} time: {abs(shifts[scale]):.6g} s")
        keys.append("time_system")
    if (
        descriptions
        and distance > _MIN_ORBIT_DISTANCE
        and min_distance < distance * (_MAX_FRAME_RESIDUAL if frame else _MAX_SCALE_RESIDUAL)
    ):
        value = f"{1e-3 * distance:.4g} km from the scenario's orbit (median)"
        expected = f"{1e-3 * min_distance:.1f} km: {' and '.join(descriptions)}"
        advice = f"declare {' and '.join(keys)}"
        yield Finding("position", samples.format_place(k[0]), value, expected, advice)


def find_inconsistent_field_strengths(samples: Samples) -> Iterator[Finding]:
    """Yield a finding for each magnetometer whose field strengths disagree with the field on the
    orbit for every plausible bias. If a scale factor common to all axes explains the disagreement,
    the finding says so.

    The bias b minimizes the difference between |y - b|² and |B|² (R. Alonso, M. D. Shuster,
    TWOSTEP, Journal of the Astronautical Sciences 50 (2002) 433-451).
    """
    for sensor, k, measured, strength in _select_vectors(samples):
        if not isinstance(sensor, Magnetometer):
            continue
        share = np.hypot(_FIELD_MODEL_ERROR, sensor.initial_scale_factor)
        noise = np.hypot(
            FIELD_UNIT_NT * max(sensor.noise_sigmas()),
            samples.scenario.environment_errors.field_error_nt,
        )
        sigma = np.hypot(noise, share * strength)
        bias_sigma = sensor.initial_bias_nt
        length, _ = _fit_lengths(measured, strength, sigma, (bias_sigma,) * 3)
        misfit = np.abs(length - strength) / sigma
        if np.median(misfit) / _NORMAL_MEDIAN > _MAX_MEDIAN_MISFIT:
            worst = int(misfit.argmax())
            value = f"{length[worst]:.5g} nT without its bias"
            expected = f"{strength[worst]:.5g} ± {sigma[worst]:.0f} nT, the field on the orbit"
            advice = "declare time_epoch, time_unit and time_system, correct epoch and orbit, or "
            advice += f"add bias_sensitivities, such as a magnetorquer's current, to {sensor.name}"
            length, scale = _fit_lengths(
                measured, strength, sigma, (*(bias_sigma,) * 3, _MAX_SCALE_ERROR)
            )
            misfit = np.abs(length / scale - strength) / sigma
            if np.median(misfit) / _NORMAL_MEDIAN < _MAX_MEDIAN_MISFIT:
                error = (
                    f"{100.0 * abs(scale - 1.0):.1f} % too {'large' if scale > 1.0 else 'small'}"
                )
                key = f"{sensor.name}.initial_scale_factor"
                advice = f"set {key} in the scenario if all readings are {error}, or {advice}"
            yield Finding(sensor.name, samples.format_place(k[worst]), value, expected, advice)


def _fit_lengths(
    measured: Floats, strength: Floats, sigma: Floats, prior_sigmas: Sequence[float]
) -> tuple[Floats, float]:
    """Fit a bias, and a scale factor if `prior_sigmas` has a fourth value, so that the lengths of
    the measured vectors agree with the field strengths. Return the lengths without the bias, and
    the scale factor.
    """
    x, prior, n = np.zeros(4), np.array(prior_sigmas), len(prior_sigmas)
    weight = 0.5 / (strength * sigma)
    for _ in range(_N_ITERATIONS):
        left, scaled = measured - x[:3], (1.0 + x[3]) * strength
        more = weight * ((left**2).sum(axis=1) - scaled**2)
        slopes = 2.0 * weight[:, None] * np.column_stack([left, scaled * strength])
        matrix = np.vstack([slopes[:, :n], np.diag(1.0 / prior)])
        x[:n] += np.linalg.lstsq(matrix, np.append(more, -x[:n] / prior), rcond=None)[0]
    return _compute_length(measured - x[:3]), 1.0 + float(x[3])


def find_inconsistent_rates(samples: Samples) -> Iterator[Finding]:
    """Yield a finding if the gyro rates disagree with the rotation of the vectors that the sensors
    measure.

    Vectors are compared over the longest lag with a rotation below `_MAX_ROTATION`.
    """
    telemetry, scenario = samples.telemetry, samples.scenario
    bias = 3.0 * np.sqrt(3.0) * scenario.gyro.initial_bias_deg_s
    for sensor in scenario.sensors if telemetry.has_gyro else ():
        rows = telemetry.sensors[sensor.name]
        both = np.flatnonzero(np.isfinite(rows[:, 0]) & np.isfinite(telemetry.gyro_deg_s[:, 0]))
        if len(sensor.telemetry_suffixes) != 3 or len(both) < 2 * _LAGS[-1]:
            continue
        times, noise, field_rate = telemetry.times[both], max(sensor.noise_sigmas()), 0.0
        if isinstance(sensor, Magnetometer):
            length = float(np.median(_compute_length(rows[both])))
            noise, field_rate = noise * FIELD_UNIT_NT / length, _FIELD_ROTATION_RATE
            if sensor.initial_bias_nt > _MAX_BIAS_RATIO * length:
                continue
        unit = rows[both] / _compute_length(rows[both])[:, None]
        chords = ((lag, _compute_length(unit[lag:] - unit[:-lag])) for lag in _LAGS)
        small = list(takewhile(lambda each: np.median(each[1]) < _MAX_ROTATION, chords))
        if not small:
            continue
        lag, chord = small[-1]
        steps = np.diff(times, prepend=times[0])[:, None]
        angle = np.cumsum(steps * telemetry.gyro_deg_s[both], axis=0)
        duration = times[lag:] - times[:-lag]
        rate = (angle[lag:] - angle[:-lag]) / duration[:, None]
        reported = float(np.median(_compute_length(np.cross(rate, unit[lag:]))))
        result = float(np.median(np.degrees(chord) / duration))
        slack = bias + field_rate + np.degrees(3.0 * noise) / float(np.median(duration))
        if not result / 1.5 - slack < reported < 1.5 * result + slack:
            value = f"median rate of {reported:.4g} deg/s perpendicular to {sensor.name}"
            expected = f"about {result:.4g} deg/s, at which the vectors of {sensor.name} rotate"
            advice = "declare gyro.unit, gyro.scale or time_unit, or a larger initial_bias_deg_s"
            yield Finding("gyro", samples.format_place(both[1]), value, expected, advice)


def _select_vectors(samples: Samples) -> Iterator[tuple[Sensor, Ints, Floats, Floats]]:
    """Yield each vector sensor with sample indices, measured vectors and expected vector
    lengths.
    """
    telemetry = samples.telemetry
    for sensor in samples.scenario.sensors:
        k = _select_samples(telemetry.sensors.get(sensor.name, np.empty((0, 3))))
        if len(sensor.telemetry_suffixes) != 3 or sensor.has_unit_length or len(k) < _MIN_SAMPLES:
            continue
        times = telemetry.times[k]
        try:
            around = Environment.from_times(
                samples.scenario, times, telemetry.interpolate_positions(times)
            )
        except (ValueError, ArithmeticError):
            continue  # The orbit does not cover all times or positions.
        if isinstance(sensor, Magnetometer):
            yield sensor, k, telemetry.sensors[sensor.name][k], _compute_length(around.field)
        elif len(k := k[around.sunlit]):
            yield sensor, k, telemetry.sensors[sensor.name][k], np.ones(len(k))


def _select_samples(rows: Floats) -> Ints:
    """Return the indices of at most `_MAX_SAMPLES` rows without NaN, evenly distributed over the
    data.
    """
    k = np.flatnonzero(np.isfinite(rows[:, 0]))
    if len(k) <= _MAX_SAMPLES:
        return k
    spread: Ints = k[np.linspace(0, len(k) - 1, _MAX_SAMPLES).astype(int)]
    return spread


def _compute_length(rows: Floats) -> Floats:
    lengths: Floats = np.linalg.norm(rows, axis=1)
    return lengths
