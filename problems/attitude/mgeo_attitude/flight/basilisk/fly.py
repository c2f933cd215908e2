"""Flights by Basilisk: what can be flown, and the truth that comes of it."""

from __future__ import annotations

import dataclasses
import importlib.util

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mgeo_attitude.environment import Environment
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.flight.basilisk.vehicle import Vehicle
from mgeo_attitude.flight.flight import Flight, Motion, draw
from mgeo_attitude.flight.flight import fly as fly_exactly
from mgeo_attitude.scenario import Scenario
from mgeo_attitude.sensors import Magnetometer, Sensor, StarTracker, SunSensor
from mgeo_attitude.sensors.readings import Readings

#: Sensors that Basilisk has, each with the states that it has there.
MODELED: dict[type[Sensor], set[str]] = {
    SunSensor: {"misalignment", "bias"},
    Magnetometer: {"misalignment", "bias"},
    StarTracker: {"misalignment"},
}


def fly_run(
    scenario: Scenario,
    design: ArrayLike,
    generator: np.random.Generator,
    vehicle: Vehicle | None = None,
    environment: Environment | None = None,
) -> Flight:
    """Fly a plan by Basilisk, to the end of the scenario, with errors drawn from it.

    A rigid body with reaction wheels follows the plan's rates by feedback of modified Rodrigues
    parameters, with the attitude that its gyro says. Where the plan has no ramps its rates change
    as fast as the wheels allow. The true errors are those of `flight.fly_run` with an equal
    generator; noise is Basilisk's own.

    An orbit of two bodies is integrated by Basilisk. Any other is prescribed from the tables of
    the environment: Basilisk's equations of motion have neither mean elements nor SGP4.

    Parameters
    ----------
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver.
    generator : Generator
        The same flight, bit by bit, from the same one.
    vehicle : Vehicle, optional
        Default: that of the scenario, see `Vehicle.of`.
    environment : Environment, optional
        Saves computing that of the scenario again.

    Raises
    ------
    ImportError
        If Basilisk is not installed.
    ValueError
        For a sensor that Basilisk does not have, a scenario that does not say what it flies with,
        or an `environment` of another.
    """
    require_basilisk()
    from mgeo_attitude.flight.basilisk.simulation import Drawn, simulate

    vehicle = vehicle or Vehicle.of(scenario)
    environment = environment or Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    check_suite(model.suite)
    n, gyro = model.n_steps, scenario.gyro
    drawn = fly_exactly(model, Motion.of(model, design, n), draw(model, n, generator))
    bias = drawn.gyro[:, :3]
    # a random walk between two known ends has this mean and this spread about it
    spread = gyro.rate_random_walk * np.sqrt(model.step / 12.0)
    mean_bias = 0.5 * (bias[:-1] + bias[1:]) + spread * generator.standard_normal((n, 3))
    ramped = dataclasses.replace(model, agility=model.agility or vehicle.agility())
    seen = simulate(
        scenario,
        Motion.of(ramped, design, n),
        Drawn(drawn.start, drawn.errors, mean_bias),
        vehicle,
        environment,
        generator,
    )
    turns = Rotation.from_matrix(seen.attitude[:-1] @ seen.attitude[1:].transpose(0, 2, 1))
    motion = Motion(turns.as_rotvec() / model.step, seen.attitude @ drawn.start.T)
    readings = Readings(np.full(n, model.step), seen.gyro, seen.sensors)
    return dataclasses.replace(drawn, motion=motion, readings=readings)


def require_basilisk() -> None:
    """Raise an ImportError that says how to install Basilisk where it is missing."""
    if importlib.util.find_spec("Basilisk") is None:
        raise ImportError(
            'a flight by Basilisk needs the package bsk: pip install "mgeo-attitude[basilisk]"'
        )


def check_suite(suite: Suite) -> None:
    """Refuse a suite of which Basilisk has no model.

    Raises
    ------
    InvalidValue
        (ValueError) Naming the sensor, what it is or has, and what Basilisk knows.
    """
    for i, sensor in enumerate(suite.sensors):
        states = MODELED.get(type(sensor))
        if states is None:
            kinds = ", ".join(kind.kind for kind in MODELED)
            raise InvalidValue(f"sensors[{i}].kind", sensor.kind, f"Basilisk flies with {kinds}")
        for state in sensor.states().keys() - states:
            raise InvalidValue(
                f"sensors[{i}].{state}",
                sensor.name,
                f"Basilisk's {sensor.kind} has {' and '.join(sorted(states))} only",
            )
    for state in suite.gyro.states().keys() - {"bias", "scale_factor", "misalignment"}:
        raise InvalidValue(
            f"gyro.{state}", suite.gyro, "Basilisk's gyro has bias, scale_factor and misalignment"
        )
