"""Faults of telemetry for the independent simulator, and the messages that identify them."""

import dataclasses
import re
from datetime import UTC, datetime

import numpy as np
from mgeo_attitude import Scenario
from scipy.spatial.transform import Rotation

from .independent_simulator import constant_rates
from .runs import PLAN, short


def names_cause(cause: str, line: str) -> bool:
    """Return True if a message starts with a cause, or contains the cause among its
    alternatives.
    """
    return re.match(f"(?:{cause})|.*; or (?:{cause})", line) is not None


SCENARIO = short(Scenario.cubesat_6u(), 3000.0)
MOTION = constant_rates(PLAN)


def random_sign(rng):
    return rng.choice([-1.0, 1.0])


def random_axis(rng):
    """Return a random unit vector."""
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


def change_sensor(name, change):
    """Return a function that changes the readings of a sensor in telemetry."""

    def spoil(telemetry, rng):
        rows = change(telemetry.times, telemetry.sensors[name].copy(), rng)
        return dataclasses.replace(telemetry, sensors={**telemetry.sensors, name: rows})

    return spoil


def change_gyro(change):
    """Return a function that changes the gyro rates in telemetry."""

    def spoil(telemetry, rng):
        rates = change(telemetry.times, telemetry.gyro_deg_s.copy(), rng)
        return dataclasses.replace(telemetry, gyro_deg_s=rates)

    return spoil


def add_scale_error(size):
    """Return a change by random scale factors along all axes."""
    return lambda t, rows, rng: rows * (1.0 + size * random_sign(rng) * random_axis(rng))


def add_nonorthogonality(size):
    def change(t, rows, rng):
        a, b, c = np.radians(size) * random_axis(rng)
        return rows @ np.array([[1.0, a, b], [a, 1.0, c], [b, c, 1.0]])

    return change


def build_offset(size, profile, rng):
    """Return an offset along a random axis with a time profile that ends at zero."""
    return size * np.outer(profile - profile[-1], random_axis(rng))


def add_step(size):
    """Return a change by a step of the bias at a random time in the middle."""

    def change(t, rows, rng):
        when = rng.uniform(800.0, 2200.0) / 3000.0 * t[-1]
        return rows + build_offset(size, 1.0 * (t > when), rng)

    return change


def add_drift(size):
    """Return a change by a linear drift of the bias."""
    return lambda t, rows, rng: rows + build_offset(size, t / t[-1], rng)


def add_random_walk(size):
    """Return a change by a random walk of the bias."""

    def change(t, rows, rng):
        steps = rng.standard_normal(rows.shape) / np.sqrt(len(t))
        return rows + size * (np.cumsum(steps, axis=0) - steps.sum(axis=0))

    return change


def temperature(t):
    """Return the temperature of a satellite in a low orbit [deg C]."""
    return 20.0 + 8.0 * np.sin(2.0 * np.pi * t / 5992.0 + 1.0)


def add_temperature_bias(size):
    """Return a change by a bias that is proportional to the temperature."""
    return lambda t, rows, rng: rows + build_offset(size, temperature(t) / 16.0, rng)


def add_scale_asymmetry(size):
    """Return a change by scale factors that differ between the senses of rotation."""
    return lambda t, rows, rng: rows + size * random_axis(rng) * np.abs(rows)


def add_temperature_misalignment(size):
    """Return a change by a misalignment [deg] that is proportional to the temperature."""

    def change(t, rows, rng):
        warm = (temperature(t) - temperature(t).mean()) / np.ptp(temperature(t))
        turn = Rotation.from_rotvec(size * np.outer(warm, random_axis(rng)), degrees=True)
        return turn.apply(rows)

    return change


def change_times(seconds):
    """Return a function that changes the times of telemetry."""
    return lambda telemetry, rng: dataclasses.replace(
        telemetry, times=seconds(telemetry.times, rng)
    )


def flip_axis(rows, rng):
    return rows * np.where(np.arange(3) == rng.integers(3), -1.0, 1.0)


def swap_axes(rows, rng):
    k = rng.integers(3)
    order = np.arange(3)
    order[[k, k - 1]] = order[[k - 1, k]]
    return rows[:, order]


def insert_fill_values(t, rows, rng):
    rows[rng.random(len(rows)) < rng.uniform(0.05, 0.2)] = -9999.0
    return rows


def insert_fill_values_in_channel(t, rows, rng):
    rows[rng.random(len(rows)) < rng.uniform(0.06, 0.2), rng.integers(3)] = -99999.0
    return rows


def clip_channel(t, rows, rng):
    k = rng.integers(3)
    rows[:, k] = np.minimum(rows[:, k], np.quantile(rows[:, k], rng.uniform(0.7, 0.9)))
    return rows


def count_days_since(*date):
    since = (SCENARIO.epoch - datetime(*date, tzinfo=UTC)).total_seconds()
    return change_times(lambda t, rng: (t + since) / 86400.0)


#: Message that identifies the cause, and fault that prevents a calibration.
GROSS = {
    "fill values": (
        r"mag_\w at .*: -9999 in .*expected a measured value",
        change_sensor("mag", insert_fill_values),
    ),
    "fill values of a channel": (
        r"mag_\w at .*: -99999 in .*expected a measured value",
        change_sensor("mag", insert_fill_values_in_channel),
    ),
    "magnetometer clipped": (
        r"mag_\w at .*that is not clipped",
        change_sensor("mag", clip_channel),
    ),
    "magnetometer flipped": (
        "mag agrees with the other sensors if its axes are ",
        change_sensor("mag", lambda t, rows, rng: flip_axis(rows, rng)),
    ),
    "Sun sensor flipped": (
        "sun agrees with the other sensors if its axes are ",
        change_sensor("sun", lambda t, rows, rng: flip_axis(rows, rng)),
    ),
    "magnetometer swapped": (
        "mag agrees with the other sensors if its axes are ",
        change_sensor("mag", lambda t, rows, rng: swap_axes(rows, rng)),
    ),
    "gyro flipped": (
        "gyro agrees with the other sensors if its axes are ",
        change_gyro(lambda t, rows, rng: flip_axis(rows, rng)),
    ),
    "gyro of the other sign": (
        r"gyro agrees with the other sensors if its axes are \(-x, -y, -z\)",
        change_gyro(lambda t, rows, rng: -rows),
    ),
    "gyro times ten": (
        r"gyro at .* Declare gyro\.unit",
        change_gyro(lambda t, rows, rng: 10.0 * rows),
    ),
    "gyro in deg/h": (
        r"gyro at .* Declare gyro\.unit",
        change_gyro(lambda t, rows, rng: 3600.0 * rows),
    ),
    "minutes": (".* at .* Declare .*time_unit", change_times(lambda t, rng: t / 60.0)),
    "milliseconds": (".* at .* Declare .*time_unit", change_times(lambda t, rng: 1e3 * t)),
    "days": (".* at .* Declare .*time_unit", change_times(lambda t, rng: t / 86400.0)),
    "Excel": ("time at .* Declare time_epoch", count_days_since(1899, 12, 30)),
    "MJD": ("time at .* Declare time_epoch", count_days_since(1858, 11, 17)),
    "local time": (
        "mag at .* Declare time_epoch, time_unit and time_system",
        change_times(lambda t, rng: t + 1800.0 * random_sign(rng) * rng.integers(2, 24)),
    ),
}
