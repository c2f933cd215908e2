"""Telemetry of a plan that Basilisk simulates with rigid-body dynamics, actuators and sensors."""

from __future__ import annotations

import dataclasses
import importlib.util
from typing import Any

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.history import can_measure
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.maneuvers.schedule import RotationDynamics
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.direction_sensors import TwoAxisSunSensor
from mgeo_attitude.sensors.environment_errors import EnvironmentErrors
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.measurements import Measurements
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.star_tracker import StarTracker
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.sensors.vector_sensors import Magnetometer, SunSensor
from mgeo_attitude.settings.errors import InvalidValue
from scipy.spatial.transform import Rotation

from mgeo_calibration.simulators.basilisk.vehicle import MagnetorquerVehicle, Vehicle
from mgeo_calibration.simulators.kinematic import build_telemetry, complete_design, continue_errors
from mgeo_calibration.simulators.simulated_run import draw_errors, simulate_run
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth

#: States that Basilisk models, by sensor class.
SENSOR_STATES: dict[type[Sensor], set[str]] = {
    SunSensor: {"misalignment", "bias"},
    TwoAxisSunSensor: {"misalignment", "bias"},
    Photodiode: {"sensitivity"},
    Magnetometer: {"misalignment", "bias"},
    StarTracker: {"misalignment"},
}
GYRO_STATES = {"bias", "scale_factor", "misalignment"}


def simulate_telemetry(
    scenario: Scenario,
    plan: Any,
    seed: int | np.random.Generator | None = None,
    *,
    vehicle: Vehicle | None = None,
    initial_truth: Truth | None = None,
    environment: Environment | None = None,
) -> Telemetry:
    """Simulate one run of a plan with Basilisk's models of dynamics, actuators and sensors, and
    return its telemetry.

    A rigid body with reaction wheels follows the plan by feedback of modified Rodrigues
    parameters, with gyro-based attitude estimates. Without ramps in the plan, rates change as fast
    as the wheels allow. A satellite without wheels uses Basilisk's magnetorquers with
    the scenario's magnetorquer law, the gyro and the true field. True errors are drawn from
    the scenario and equal those of `kinematic.simulate_telemetry` with the same seed; measurement
    noise comes from Basilisk.

    Basilisk integrates two-body orbits. Other orbits are prescribed by the environment, because
    Basilisk has neither mean elements nor SGP4. There are no readings at the start.

    Parameters
    ----------
    scenario : Scenario
    plan : ManeuverPlan or array_like, shape (4 m,)
        Plan, or a design with rates [deg/s] and duration [s] of each maneuver; ``[]`` for none.
    seed : int or Generator, optional
        Equal seeds give identical telemetry. None draws fresh entropy.
    vehicle : Vehicle, optional
        Default: result of `Vehicle.from_scenario`.
    initial_truth : Truth, optional
        Truth of an earlier run to continue from, as in `kinematic.simulate_telemetry`.
    environment : Environment, optional
        Precomputed environment of the scenario.

    Returns
    -------
    Telemetry
        Telemetry with its `truth`.

    Raises
    ------
    ImportError
        If Basilisk is not installed.
    ValueError
        If Basilisk lacks a sensor, the scenario defines no vehicle, the design is invalid, or the
        environment belongs to another scenario.
    """
    require_basilisk()
    from mgeo_calibration.simulators.basilisk.simulation import SimulationInputs, simulate

    if scenario.is_magnetorquer_driven and vehicle is not None:
        raise InvalidValue("vehicle", vehicle, "expected none with magnetorquers")
    environment = environment or Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    validate_suite(model.suite)
    n, gyro, generator = model.n_steps, scenario.gyro, np.random.default_rng(seed)
    design = complete_design(scenario, plan, model)
    drive = model.slew_limits
    body: Vehicle | MagnetorquerVehicle
    limits: RotationDynamics
    if isinstance(drive, MagnetorquerDrive):
        body, limits = MagnetorquerVehicle.from_design(drive, design, model.step, n), drive
    else:
        body = vehicle or Vehicle.from_scenario(scenario)
        limits = drive or body.compute_slew_limits(model.initial_rate)
    nominal_run = simulate_run(
        model,
        Motion.from_design(model, design, n),
        continue_errors(model, draw_errors(model, n, generator), initial_truth),
    )
    bias = nominal_run.varying_states[:, :3]
    # Mean and 1-sigma of the average of a random walk between two known end points.
    sigma = np.array(gyro.effective_rate_random_walk) * np.sqrt(model.step / 12.0)
    mean_bias = 0.5 * (bias[:-1] + bias[1:]) + sigma * generator.standard_normal((n, 3))
    ramped = dataclasses.replace(model, slew_limits=limits)
    result = simulate(
        scenario,
        Motion.from_design(ramped, design, n),
        SimulationInputs(
            model.initial_attitude @ nominal_run.initial_rotation,
            model.initial_rate,
            model.initial_states,
            nominal_run.initial_states,
            mean_bias,
        ),
        body,
        environment,
        generator,
    )
    rotations = Rotation.from_matrix(result.attitude[:-1] @ result.attitude[1:].transpose(0, 2, 1))
    motion = Motion(
        rotations.as_rotvec() / model.step, result.attitude @ nominal_run.initial_rotation.T
    )
    sensors = _mask_readings(model, result.attitude, motion.rates, result.sensors)
    readings = Measurements(np.full(n, model.step), result.mean_rates, sensors)
    telemetry = build_telemetry(
        model, dataclasses.replace(nominal_run, motion=motion, readings=readings)
    )
    assert telemetry.truth is not None
    wheel_momentum = result.wheel_momentum if result.wheel_momentum.size else None
    return dataclasses.replace(
        telemetry, truth=dataclasses.replace(telemetry.truth, wheel_momentum=wheel_momentum)
    )


def _mask_readings(
    model: FilterModel, attitude: Floats, rates: Floats, sensors: tuple[Floats, ...]
) -> tuple[Floats, ...]:
    """Set sensor readings to NaN in eclipse and where a star tracker is blinded."""
    result = []
    for index, (sensor, vectors) in enumerate(zip(model.suite.sensors, sensors, strict=True)):
        is_valid = model.available[:, index]
        if isinstance(sensor, StarTracker):
            is_valid = can_measure(model, index, attitude, rates)
        result.append(np.where(is_valid[:, None, None], vectors, np.nan))
    return tuple(result)


def require_basilisk() -> None:
    if importlib.util.find_spec("Basilisk") is None:
        raise ImportError("the simulator basilisk needs the package bsk: pip install bsk")


def validate_suite(suite: Suite) -> None:
    """Raise InvalidValue if Basilisk cannot model a sensor or a state of a suite.

    Raises
    ------
    InvalidValue
        (ValueError) With the sensor, its kind or state, and the supported kinds or states.
    """
    if suite.environment_errors != EnvironmentErrors():
        raise InvalidValue(
            "environment_errors",
            suite.environment_errors,
            "expected none, because Basilisk does not model environment errors",
        )
    for i, sensor in enumerate(suite.sensors):
        states = SENSOR_STATES.get(type(sensor))
        if states is None:
            kinds = ", ".join(kind.kind for kind in SENSOR_STATES)
            raise InvalidValue(
                f"sensors[{i}].kind", sensor.kind, f"expected a kind that Basilisk models: {kinds}"
            )
        _validate_states(f"sensors[{i}]", f"Basilisk's {sensor.kind}", sensor, states)
    _validate_states("gyro", "Basilisk's gyro", suite.gyro, GYRO_STATES)


def _validate_states(key: str, name: str, owner: Gyro | Sensor, modeled_states: set[str]) -> None:
    for state in sorted(owner.states().keys() - modeled_states):
        expected = f"expected no such state: {name} has only {', '.join(sorted(modeled_states))}"
        raise InvalidValue(f"{key}.{state}", owner.states()[state], expected)
