"""Flights of the independent simulation with one fault each, and what its cause is called."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from mgeo_attitude import Scenario
from mgeo_calibration import Telemetry

from .flights import PLAN, short
from .independent import Craft, fly, steady

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


def stepped(size):
    """By a step in the bias somewhere in the middle."""

    def change(t, rows, rng):
        return rows + np.outer(t > rng.uniform(800.0, 2200.0), size * axis(rng))

    return change


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
