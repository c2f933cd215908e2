"""Flights of the independent simulation with one fault each, and what its cause is called."""

import dataclasses
import re
from datetime import UTC, datetime

import numpy as np
from mgeo_attitude import Scenario
from scipy.spatial.transform import Rotation

from .flights import PLAN, short
from .independent import steady


def says(cause: str, line: str) -> bool:
    """Return whether a line begins with a cause, or has the cause among its alternatives."""
    return re.match(f"(?:either )?(?:{cause})|either .*, or (?:{cause})", line) is not None


SCENARIO = short(Scenario.cubesat_6u(), 3000.0)
MOTION = steady(PLAN)


def sign(rng):
    return rng.choice([-1.0, 1.0])


def axis(rng):
    """A unit vector anywhere."""
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


def sensor(name, change):
    """Telemetry with other readings of a sensor."""

    def spoil(telemetry, rng):
        rows = change(telemetry.times, telemetry.sensors[name].copy(), rng)
        return dataclasses.replace(telemetry, sensors={**telemetry.sensors, name: rows})

    return spoil


def gyro(change):
    """Telemetry with other rates."""

    def spoil(telemetry, rng):
        rates = change(telemetry.times, telemetry.gyro_deg_s.copy(), rng)
        return dataclasses.replace(telemetry, gyro_deg_s=rates)

    return spoil


def scaled(size):
    """By errors of scale along all axes."""
    return lambda t, rows, rng: rows * (1.0 + size * sign(rng) * axis(rng))


def sheared(size):
    def change(t, rows, rng):
        a, b, c = np.radians(size) * axis(rng)
        return rows @ np.array([[1.0, a, b], [a, 1.0, c], [b, c, 1.0]])

    return change


def changed(size, profile, rng):
    """By an offset that goes as a profile along any axis, and is none at the end."""
    return size * np.outer(profile - profile[-1], axis(rng))


def stepped(size):
    """By a step in the bias somewhere in the middle."""

    def change(t, rows, rng):
        when = rng.uniform(800.0, 2200.0) / 3000.0 * t[-1]
        return rows + changed(size, 1.0 * (t > when), rng)

    return change


def ramp(size):
    """By a drift of the bias."""
    return lambda t, rows, rng: rows + changed(size, t / t[-1], rng)


def walk(size):
    """By a random walk of the bias."""

    def change(t, rows, rng):
        steps = rng.standard_normal(rows.shape) / np.sqrt(len(t))
        return rows + size * (np.cumsum(steps, axis=0) - steps.sum(axis=0))

    return change


def temperature(t):
    """Of a satellite in a low orbit [deg C]."""
    return 20.0 + 8.0 * np.sin(2.0 * np.pi * t / 5992.0 + 1.0)


def warmed(size):
    """By a bias that follows the temperature."""
    return lambda t, rows, rng: rows + changed(size, temperature(t) / 16.0, rng)


def asymmetric(size):
    """By scale factors that differ between the senses of rotation."""
    return lambda t, rows, rng: rows + size * axis(rng) * np.abs(rows)


def bent(size):
    """By a misalignment [deg] that follows the temperature."""

    def change(t, rows, rng):
        warm = (temperature(t) - temperature(t).mean()) / np.ptp(temperature(t))
        turn = Rotation.from_rotvec(size * np.outer(warm, axis(rng)), degrees=True)
        return turn.apply(rows)

    return change


def shifted(seconds):
    """With other times."""
    return lambda telemetry, rng: dataclasses.replace(
        telemetry, times=seconds(telemetry.times, rng)
    )


def flipped(rows, rng):
    return rows * np.where(np.arange(3) == rng.integers(3), -1.0, 1.0)


def swapped(rows, rng):
    k = rng.integers(3)
    order = np.arange(3)
    order[[k, k - 1]] = order[[k - 1, k]]
    return rows[:, order]


def filled(t, rows, rng):
    rows[rng.random(len(rows)) < rng.uniform(0.05, 0.2)] = -9999.0
    return rows


def filled_in_one(t, rows, rng):
    rows[rng.random(len(rows)) < rng.uniform(0.06, 0.2), rng.integers(3)] = -99999.0
    return rows


def clipped(t, rows, rng):
    k = rng.integers(3)
    rows[:, k] = np.minimum(rows[:, k], np.quantile(rows[:, k], rng.uniform(0.7, 0.9)))
    return rows


def days_since(*date):
    since = (SCENARIO.epoch - datetime(*date, tzinfo=UTC)).total_seconds()
    return shifted(lambda t, rng: (t + since) / 86400.0)


#: Words that name the cause, and what spoils telemetry so that it cannot be calibrated.
GROSS = {
    "fill values": (r"mag_\w at .*: -9999 in .*expected a measured value", sensor("mag", filled)),
    "fill values of a channel": (
        r"mag_\w at .*: -99999 in .*expected a measured value",
        sensor("mag", filled_in_one),
    ),
    "magnetometer clipped": (r"mag_\w at .*that is not clipped", sensor("mag", clipped)),
    "magnetometer flipped": (
        "mag agrees with the other sensors if its axes are ",
        sensor("mag", lambda t, rows, rng: flipped(rows, rng)),
    ),
    "Sun sensor flipped": (
        "sun agrees with the other sensors if its axes are ",
        sensor("sun", lambda t, rows, rng: flipped(rows, rng)),
    ),
    "magnetometer swapped": (
        "mag agrees with the other sensors if its axes are ",
        sensor("mag", lambda t, rows, rng: swapped(rows, rng)),
    ),
    "gyro flipped": (
        "gyro agrees with the other sensors if its axes are ",
        gyro(lambda t, rows, rng: flipped(rows, rng)),
    ),
    "gyro of the other sign": (
        r"gyro agrees with the other sensors if its axes are \(-x, -y, -z\)",
        gyro(lambda t, rows, rng: -rows),
    ),
    "gyro times ten": (
        r"gyro at .* declare gyro\.unit",
        gyro(lambda t, rows, rng: 10.0 * rows),
    ),
    "gyro in deg/h": (
        r"gyro at .* declare gyro\.unit",
        gyro(lambda t, rows, rng: 3600.0 * rows),
    ),
    "minutes": (".* at .* declare .*time_unit", shifted(lambda t, rng: t / 60.0)),
    "milliseconds": (".* at .* declare .*time_unit", shifted(lambda t, rng: 1e3 * t)),
    "days": (".* at .* declare .*time_unit", shifted(lambda t, rng: t / 86400.0)),
    "Excel": ("time at .* declare time_epoch", days_since(1899, 12, 30)),
    "MJD": ("time at .* declare time_epoch", days_since(1858, 11, 17)),
    "local time": (
        "mag at .* declare time_epoch, time_unit and time_system",
        shifted(lambda t, rng: t + 1800.0 * sign(rng) * rng.integers(2, 24)),
    ),
}
