"""Where maneuvers with ramps leave the attitude, compiled: what `slew_back` tries many of.

It is what `schedule` makes of a design, turned step by step, without the tables of all steps.
"""

from __future__ import annotations

import math

import numpy as np

from mgeo_attitude._compiled import entry, helper


@entry(
    "float64[:,::1](float64[:,::1], float64[::1], float64[:,::1], int64[::1], float64,"
    "Tuple((float64, float64, float64[:,::1])))"
)
def arrival(attitude, rate, rates, lengths, step, limits):  # type: ignore[no-untyped-def]
    """Attitude, GCRS to body, shape (3, 3), after k maneuvers.

    Parameters
    ----------
    attitude, rate : arrays, shapes (3, 3) and (3,)
        At the start; [rad/s].
    rates : array, shape (k, 3)
        Of the maneuvers [rad/s].
    lengths : array of int, shape (k,)
        Steps of each maneuver, its ramp included, which is cut short where that is longer.
    step : float
        [s]
    limits : tuple
        Those of `SlewLimits`: acceleration, torque, and the torques (rows) of unit accelerations.
    """
    reached, before, mean = attitude.copy(), rate.copy(), np.empty(3)
    for j in range(len(rates)):
        time = _ramp_time(rates[j] - before, limits)
        in_ramp = min(math.ceil(time / step), lengths[j])
        for k in range(in_ramp):
            begin = k * step
            part = min(max((time - begin) / step, 0.0), 1.0)  # of the step, within the ramp
            share = part * _made(begin + 0.5 * part * step, time) + (1.0 - part)
            for a in range(3):
                mean[a] = before[a] + share * (rates[j, a] - before[a])
            _turn(reached, mean, step)
        _turn(reached, rates[j], (lengths[j] - in_ramp) * step)
        share = _made(in_ramp * step, time)
        for a in range(3):
            before[a] += share * (rates[j, a] - before[a])
    return reached


@helper
def _ramp_time(change, limits):  # type: ignore[no-untyped-def]
    """`SlewLimits.ramp_time`."""
    acceleration, torque, demands = limits
    time = np.abs(change).max() / acceleration
    for demand in demands:
        load = demand[0] * change[0] + demand[1] * change[1] + demand[2] * change[2]
        time = max(time, abs(load) / torque)
    return time


@helper
def _made(after, time):  # type: ignore[no-untyped-def]
    """Share of a change that is made `after` seconds of a ramp that takes `time`."""
    return min(max(after / time, 0.0), 1.0) if time > 0.0 else 1.0


@helper
def _turn(attitude, rate, time):  # type: ignore[no-untyped-def]
    """Turn a body at a constant rate: Rodrigues' formula on each column of its attitude."""
    x, y, z = -rate[0] * time, -rate[1] * time, -rate[2] * time
    angle = math.sqrt(x * x + y * y + z * z)
    if angle == 0.0:
        return
    half = math.sin(0.5 * angle) / angle
    sine, versine = math.sin(angle) / angle, 2.0 * half * half
    for j in range(3):
        a, b, c = attitude[0, j], attitude[1, j], attitude[2, j]
        p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
        attitude[0, j] += sine * p + versine * (y * r - z * q)
        attitude[1, j] += sine * q + versine * (z * p - x * r)
        attitude[2, j] += sine * r + versine * (x * q - y * p)


@entry("float64[::1](float64[:,::1], float64[:,::1])")
def missing(target, reached):  # type: ignore[no-untyped-def]
    """Rotation vector [rad], shape (3,), from an attitude to a target, by its quaternion.

    Its largest part is found first, so that none is lost (Shepperd, JGC 1, 1978, 223-224).
    """
    m = np.zeros((3, 3))
    for a in range(3):
        for b in range(3):
            for c in range(3):
                m[a, b] += target[a, c] * reached[b, c]
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    i = 0
    for j in range(1, 3):
        if m[j, j] > m[i, i]:
            i = j
    j, k = (i + 1) % 3, (i + 2) % 3
    vector, scalar = np.empty(3), 0.0
    if trace > m[i, i]:
        scalar = 1.0 + trace
        vector[0], vector[1], vector[2] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    else:
        vector[i] = 1.0 + 2.0 * m[i, i] - trace
        vector[j], vector[k] = m[i, j] + m[j, i], m[i, k] + m[k, i]
        scalar = m[k, j] - m[j, k]
        if scalar < 0.0:
            scalar, vector = -scalar, -vector
    sine = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    factor = 2.0 * math.atan2(sine, scalar) / sine if sine > 0.0 else 0.0
    return factor * vector
