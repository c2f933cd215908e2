"""Flights by Basilisk: what can be flown, and the truth that comes of it."""

from __future__ import annotations

import dataclasses
import importlib.util
from typing import Any

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.history import can_measure
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.drives import CoilDrive
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.maneuvers.schedule import Turning
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.direction_sensors import TwoAxisSunSensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.readings import Readings
from mgeo_attitude.sensors.star_tracker import StarTracker
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.sensors.vector_sensors import Magnetometer, SunSensor
from mgeo_attitude.sensors.world import World
from mgeo_attitude.settings.errors import InvalidValue
from scipy.spatial.transform import Rotation

from mgeo_calibration.flight.basilisk.vehicle import Coiled, Vehicle
from mgeo_calibration.flight.flight import draw, fly_run
from mgeo_calibration.flight.own import commanded, going_on, sent_down
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth

#: Sensors that Basilisk has, each with the states that it has there.
MODELED: dict[type[Sensor], set[str]] = {
    SunSensor: {"misalignment", "bias"},
    TwoAxisSunSensor: {"misalignment", "bias"},
    Photodiode: {"sensitivity"},
    Magnetometer: {"misalignment", "bias"},
    StarTracker: {"misalignment"},
}
GYRO = {"bias", "scale_factor", "misalignment"}


def fly(
    scenario: Scenario,
    plan: Any,
    seed: int | np.random.Generator | None = None,
    *,
    vehicle: Vehicle | None = None,
    after: Truth | None = None,
    environment: Environment | None = None,
) -> Telemetry:
    """Fly a plan once by Basilisk, to the end of the scenario, with errors drawn from it.

    A rigid body with reaction wheels follows the plan's rates by feedback of modified Rodrigues
    parameters, with the attitude that its gyro says. Where the plan has no ramps its rates change
    as fast as the wheels allow. A satellite without wheels is turned by Basilisk's torque rods, by
    the law of its coils with what the gyro says and the true field. With the same seed the true
    errors are those of `flight.fly`; noise is Basilisk's own.

    An orbit of two bodies is integrated by Basilisk. Any other is prescribed from the tables of
    the environment: Basilisk's equations of motion have neither mean elements nor SGP4.

    Parameters
    ----------
    plan : ManeuverPlan or array_like, shape (4 m,)
        Or its design: rates [deg/s] and duration [s] of each maneuver; ``[]`` for none.
    seed : int or Generator, optional
        The same seed, the same telemetry, bit by bit; None takes fresh entropy.
    vehicle : Vehicle, optional
        Default: that of the scenario, see `Vehicle.of`.
    after : Truth, optional
        Of a flight before, as of `flight.fly`.
    environment : Environment, optional
        Saves computing that of the scenario again.

    Returns
    -------
    Telemetry
        With its `truth`. As of `flight.fly`, nothing is reported at the start.

    Raises
    ------
    ImportError
        If Basilisk is not installed.
    ValueError
        For a sensor that Basilisk does not have, a scenario that does not say what it flies with,
        a design that is no plan, or an `environment` of another scenario.
    """
    require_basilisk()
    from mgeo_calibration.flight.basilisk.simulation import Drawn, simulate

    if scenario.turned_by_coils and vehicle is not None:
        raise InvalidValue("vehicle", vehicle, "nothing for a scenario whose coils turn it")
    environment = environment or Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    check_suite(model.suite)
    n, gyro, generator = model.n_steps, scenario.gyro, np.random.default_rng(seed)
    design = commanded(scenario, plan, model)
    drive = model.slew_limits
    flying: Vehicle | Coiled
    limits: Turning
    if isinstance(drive, CoilDrive):
        flying, limits = Coiled.of(drive, design, model.step, n), drive
    else:
        flying = vehicle or Vehicle.of(scenario)
        limits = drive or flying.slew_limits(model.initial_rate)
    drawn = fly_run(
        model, Motion.of(model, design, n), going_on(model, draw(model, n, generator), after)
    )
    bias = drawn.gyro[:, :3]
    # a random walk between two known ends has this mean and this spread about it
    spread = np.array(gyro.drift) * np.sqrt(model.step / 12.0)
    mean_bias = 0.5 * (bias[:-1] + bias[1:]) + spread * generator.standard_normal((n, 3))
    ramped = dataclasses.replace(model, slew_limits=limits)
    seen = simulate(
        scenario,
        Motion.of(ramped, design, n),
        Drawn(
            model.initial_attitude @ drawn.start,
            model.initial_rate,
            model.initial_states,
            drawn.errors,
            mean_bias,
        ),
        flying,
        environment,
        generator,
    )
    turns = Rotation.from_matrix(seen.attitude[:-1] @ seen.attitude[1:].transpose(0, 2, 1))
    motion = Motion(turns.as_rotvec() / model.step, seen.attitude @ drawn.start.T)
    sensors = _reported(model, seen.attitude, motion.rates, seen.sensors)
    readings = Readings(np.full(n, model.step), seen.gyro, sensors)
    sent = sent_down(model, dataclasses.replace(drawn, motion=motion, readings=readings))
    assert sent.truth is not None
    wheels = seen.wheels if seen.wheels.size else None
    return dataclasses.replace(sent, truth=dataclasses.replace(sent.truth, wheel_momentum=wheels))


def _reported(
    model: FilterModel, attitude: Floats, rates: Floats, sensors: tuple[Floats, ...]
) -> tuple[Floats, ...]:
    """Readings at the samples of each sensor, out of the shadow; of star trackers those of stars.

    These are not seen where it turns too fast or is dazzled.
    """
    found = []
    for index, (sensor, vectors) in enumerate(zip(model.suite.sensors, sensors, strict=True)):
        there = model.available[:, index]
        if isinstance(sensor, StarTracker):
            there = can_measure(model, index, attitude, rates)
        found.append(np.where(there[:, None, None], vectors, np.nan))
    return tuple(found)


def require_basilisk() -> None:
    """Raise an ImportError that says how to install Basilisk where it is missing."""
    if importlib.util.find_spec("Basilisk") is None:
        raise ImportError("a flight by Basilisk needs the package bsk: pip install bsk")


def check_suite(suite: Suite) -> None:
    """Refuse a suite of which Basilisk has no model.

    Raises
    ------
    InvalidValue
        (ValueError) Naming the sensor, what it is or has, and what Basilisk knows.
    """
    if suite.world != World():
        raise InvalidValue("world", suite.world, "expected none: Basilisk flies without its errors")
    for i, sensor in enumerate(suite.sensors):
        states = MODELED.get(type(sensor))
        if states is None:
            kinds = ", ".join(kind.kind for kind in MODELED)
            raise InvalidValue(f"sensors[{i}].kind", sensor.kind, f"Basilisk flies with {kinds}")
        _check_states(f"sensors[{i}]", f"Basilisk's {sensor.kind}", sensor, states)
    _check_states("gyro", "Basilisk's gyro", suite.gyro, GYRO)


def _check_states(key: str, name: str, owner: Gyro | Sensor, modeled: set[str]) -> None:
    for state in sorted(owner.states().keys() - modeled):
        expected = f"{name} has {', '.join(sorted(modeled))} only"
        raise InvalidValue(f"{key}.{state}", owner.states()[state], expected)
