"""Flights of the independent simulation with one fault each, and what its cause is called."""

import dataclasses
import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from mgeo_attitude import Scenario
from mgeo_attitude.environment.frames import gcrs_to_itrs
from mgeo_attitude.environment.times import instants
from mgeo_calibration import Telemetry

from .flights import PLAN, short
from .independent import Craft, fly, steady


def says(cause: str, line: str) -> bool:
    """Whether a line begins with a cause, or has it as the other of two that may be so."""
    return re.match(f"(?:{cause})|.*: [^;]*, or (?:{cause})", line) is not None


SCENARIO = short(Scenario.cubesat_6u(), 3000.0)
MOTION = steady(PLAN)


@dataclass(frozen=True)
class Fault:
    """A way to be wrong, by a random generator, and the words that name its cause.

    Attributes
    ----------
    craft : function
        What the satellite does.
    spoil : function
        Of telemetry, what is sent down.
    cause : str
        Regular expression that the first line begins with.
    """

    cause: str
    craft: Callable[[np.random.Generator], Craft] = lambda rng: Craft()
    spoil: Callable[[Telemetry, np.random.Generator], Telemetry] = lambda telemetry, rng: telemetry

    def fly(self, seed: int) -> Telemetry:
        rng = np.random.default_rng([seed, 48])
        return self.spoil(fly(SCENARIO, MOTION, seed, self.craft(rng)), rng)


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


def late(name, low, high):
    return lambda rng: Craft(late={name: rng.uniform(low, high)})


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


#: Of about the least sizes that matter.
SCORED = {
    "magnetometer late": Fault(r"mag is 0\.\d+ ± 0\.\d+ s late", late("mag", 0.15, 0.4)),
    "magnetometer early": Fault(r"mag is 0\.\d+ ± 0\.\d+ s early", late("mag", -0.4, -0.15)),
    "Sun sensor late": Fault(r"sun is 0\.\d+ ± 0\.\d+ s late", late("sun", 0.2, 0.5)),
    "magnetometer's scale": Fault(r"mag\.scale_factor is ", spoil=sensor("mag", scaled(0.004))),
    "soft iron": Fault(r"mag\.nonorthogonality is ", spoil=sensor("mag", sheared(0.25))),
    "gyro's scale": Fault(r"gyro\.scale_factor is ", spoil=gyro(scaled(0.006))),
    "gyro's axes": Fault(r"gyro\.nonorthogonality is ", spoil=gyro(sheared(0.4))),
    "step of the magnetometer": Fault(r"mag\.bias changes by ", spoil=sensor("mag", stepped(250))),
    "step of the Sun sensor": Fault(r"sun\.bias changes by ", spoil=sensor("sun", stepped(0.01))),
    "step of the gyro": Fault(r"gyro\.bias drifts by ", spoil=gyro(stepped(0.004))),
    "walk of the gyro": Fault(r"gyro\.bias drifts by ", lambda rng: Craft(walk=1.6e-6)),
    "orbit": Fault(
        r"the satellite is \d+\.?\d* ± 0\.\d+ s (behind|ahead of) its orbit",
        lambda rng: Craft(behind=sign(rng) * rng.uniform(2.0, 6.0)),
    ),
}


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


def frozen(t, rows, rng):
    a = int(rng.integers(200, 1500))
    rows[a : a + int(rng.integers(300, 1200))] = rows[a]
    return rows


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


def in_itrf(telemetry, rng):
    position, _ = SCENARIO.orbit.propagate(SCENARIO.epoch, telemetry.times)
    rotation = gcrs_to_itrs(instants(SCENARIO.epoch, telemetry.times))
    return dataclasses.replace(telemetry, position=np.einsum("nij,nj->ni", rotation, position))


def days_since(*date):
    since = (SCENARIO.epoch - datetime(*date, tzinfo=UTC)).total_seconds()
    return shifted(lambda t, rng: (t + since) / 86400.0)


#: Of telemetry that cannot be calibrated, or ends wrong.
GROSS = {
    "magnetometer frozen": Fault("mag does not change from ", spoil=sensor("mag", frozen)),
    "fill values": Fault(r"mag_\w is -9999 in .*fill value", spoil=sensor("mag", filled)),
    "fill values of a channel": Fault(
        r"mag_\w is -99999 in .*fill value", spoil=sensor("mag", filled_in_one)
    ),
    "magnetometer clipped": Fault(r"mag_\w is .*it is clipped", spoil=sensor("mag", clipped)),
    "magnetometer flipped": Fault(
        "mag agrees with all else if its axes are ",
        spoil=sensor("mag", lambda t, rows, rng: flipped(rows, rng)),
    ),
    "Sun sensor flipped": Fault(
        "sun agrees with all else if its axes are ",
        spoil=sensor("sun", lambda t, rows, rng: flipped(rows, rng)),
    ),
    "magnetometer swapped": Fault(
        "mag agrees with all else if its axes are ",
        spoil=sensor("mag", lambda t, rows, rng: swapped(rows, rng)),
    ),
    "gyro flipped": Fault(
        "gyro agrees with all else if its axes are ",
        spoil=gyro(lambda t, rows, rng: flipped(rows, rng)),
    ),
    "gyro of the other sign": Fault(
        r"gyro agrees with all else if its axes are \(-x, -y, -z\)",
        spoil=gyro(lambda t, rows, rng: -rows),
    ),
    "gyro times ten": Fault(
        "gyro: the vectors turn as if its rates were a tenth as large",
        spoil=gyro(lambda t, rows, rng: 10.0 * rows),
    ),
    "gyro in deg/h": Fault(
        "gyro: the vectors turn as if its rates were in deg/h",
        spoil=gyro(lambda t, rows, rng: 3600.0 * rows),
    ),
    "minutes": Fault("times are in minutes", spoil=shifted(lambda t, rng: t / 60.0)),
    "milliseconds": Fault("times are in milliseconds", spoil=shifted(lambda t, rng: 1e3 * t)),
    "days": Fault("times are in days", spoil=shifted(lambda t, rng: t / 86400.0)),
    "Excel": Fault("times are days of Excel", spoil=days_since(1899, 12, 30)),
    "MJD": Fault("times are modified Julian dates", spoil=days_since(1858, 11, 17)),
    "local time": Fault(
        r"times are \d+(\.5)? h (ahead of|behind) UTC",
        spoil=shifted(lambda t, rng: t + 1800.0 * sign(rng) * rng.integers(2, 24)),
    ),
    "ITRF": Fault("position turns with the Earth", spoil=in_itrf),
    "a late sensor": Fault(r"mag is \d.* s late", late("mag", 1.5, 3.0)),
    "far along the orbit": Fault(
        r"the satellite is .* (behind|ahead of) its orbit",
        lambda rng: Craft(behind=sign(rng) * rng.uniform(100.0, 1000.0)),
    ),
}
FAULTS = SCORED | GROSS
