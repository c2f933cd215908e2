"""Assembly of Basilisk modules into a simulation, its execution, and its results."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import mul
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from Basilisk.architecture import bskLogging
from Basilisk.simulation import spacecraft
from Basilisk.utilities import SimulationBaseClass
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.orbit import Orbit
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.sensors.vector_sensors import Magnetometer
from scipy.spatial.transform import Rotation

from mgeo_calibration.simulators.basilisk.control import (
    Guidance,
    Reference,
    add_reaction_wheels,
    build_control_loop,
    build_magnetorquer_control,
)
from mgeo_calibration.simulators.basilisk.environment import (
    EnvironmentMessages,
    build_central_body,
    build_eclipse_model,
    build_field_model,
    compute_middle_time,
    format_field_coefficients,
)
from mgeo_calibration.simulators.basilisk.sensors import (
    SENSOR_BUILDERS,
    Recorders,
    SensorInputs,
    build_gyro,
)
from mgeo_calibration.simulators.basilisk.vehicle import MagnetorquerVehicle, Vehicle
from mgeo_calibration.simulators.simulated_run import compute_coning_correction

#: Longest simulation step [s]; the scenario's step is divided into equal parts.
MAX_STEP = 1.0


@dataclass(frozen=True)
class SimulationInputs:
    """Initial conditions and true sensor errors of a Basilisk simulation.

    Attributes
    ----------
    attitude : array, shape (3, 3)
        Initial rotation matrix from GCRS to body.
    rate : array, shape (3,)
        Initial body rate [rad/s].
    estimates : array, shape (n_states,)
        Estimated gyro and sensor states on board; zero before a calibration.
    true_states : array, shape (n_states,)
        True gyro and sensor states at the start.
    mean_bias : array, shape (n, 3)
        Mean gyro bias in each step [rad/s].
    """

    attitude: Floats
    rate: Floats
    estimates: Floats
    true_states: Floats
    mean_bias: Floats


@dataclass(frozen=True)
class SimulationResult:
    """Attitude, position, sensor readings and wheel momentum from a Basilisk simulation of n steps.

    Attributes
    ----------
    attitude : array, shape (n + 1, 3, 3)
        Rotation matrices from GCRS to body.
    position : array, shape (n + 1, 3)
        Position in GCRS [m].
    field : array, shape (n + 1, 3)
        Magnetic field in GCRS [nT]; empty without a field model.
    mean_rates : array, shape (n, 3)
        Mean reported rate in each step [rad/s].
    sensors : tuple of arrays, shape (n + 1, k, 3)
        Readings as in `Measurements`.
    wheel_momentum : array, shape (n + 1, k)
        Momentum of each wheel [N m s]; k = 0 for a satellite with magnetorquers.
    """

    attitude: Floats
    position: Floats
    field: Floats
    mean_rates: Floats
    sensors: tuple[Floats, ...]
    wheel_momentum: Floats


def simulate(
    scenario: Scenario,
    motion: Motion,
    inputs: SimulationInputs,
    vehicle: Vehicle | MagnetorquerVehicle,
    environment: Environment,
    generator: np.random.Generator,
) -> SimulationResult:
    """Run a Basilisk simulation, and return attitude, sensor readings and wheel momentum.

    Magnetorquers ignore `motion`. The generator provides only the seeds of the noise.
    """
    bskLogging.setDefaultLogLevel(bskLogging.BSK_ERROR)
    suite, n = scenario.suite, scenario.n_steps
    n_substeps = math.ceil(scenario.step / MAX_STEP)
    h = scenario.step / n_substeps
    step_ns = round(h * 1e9)

    def select_errors(owner: Any) -> dict[str, Floats]:
        indices = suite.get_first_indices(owner).items()
        return {
            name: inputs.true_states[i : i + 3] for name, i in indices if name in owner.states()
        }

    def draw_seed() -> int:
        return int(generator.integers(1, 2**31 - 1))

    messages = EnvironmentMessages(environment, scenario.epoch, n_substeps * step_ns)
    satellite = _build_satellite(scenario, inputs, vehicle, environment, messages)
    modules: list[Any] = [messages, satellite]
    field = eclipse = wheel_recorder = None
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(vehicle, MagnetorquerVehicle) or any(
            isinstance(sensor, Magnetometer) for sensor in suite.sensors
        ):
            coefficients = Path(folder, "igrf.COF")
            coefficients.write_text(
                format_field_coefficients(compute_middle_time(environment, scenario.epoch))
            )
            modules.append(field := build_field_model(satellite, messages, coefficients))
        if scenario.eclipse:
            modules.append(eclipse := build_eclipse_model(satellite, messages))
        sensor_inputs = SensorInputs(satellite, messages, field, eclipse)
        gyro_errors = select_errors(suite.gyro)
        imu = build_gyro(suite.gyro, gyro_errors, h, sensor_inputs, draw_seed())
        sensor_modules = [
            SENSOR_BUILDERS[type(sensor)](sensor, select_errors(sensor), sensor_inputs, draw_seed)
            for sensor in suite.sensors
        ]
        bias = np.repeat(
            inputs.mean_bias / (1.0 + gyro_errors.get("scale_factor", 0.0)), n_substeps, axis=0
        )
        correct_rate = _build_rate_correction(suite, inputs.estimates)
        loop: Sequence[Any]
        if isinstance(vehicle, MagnetorquerVehicle):
            timing = step_ns, n_substeps, inputs.rate
            effector, loop = build_magnetorquer_control(
                vehicle, satellite, field, imu, correct_rate, bias, timing
            )
        else:
            effector, configuration = add_reaction_wheels(vehicle, satellite, inputs.rate)
            reference = Reference.from_motion(motion, inputs.rate, scenario.step, n_substeps)
            guidance = Guidance(imu, reference, inputs.rate, correct_rate, bias, step_ns)
            loop = [guidance, *build_control_loop(vehicle, guidance, effector, configuration)]
            wheel_recorder = effector.rwSpeedOutMsg.recorder()
        modules.insert(1, effector)
        modules += [imu, *(each.module for each in sensor_modules), *loop]
        recorded = Recorders(
            satellite.scStateOutMsg.recorder(),
            messages.unit_sun.recorder(),
            eclipse and eclipse.eclipseOutMsgs[0].recorder(),
        )
        gyro_recorder, field_recorder = (
            imu.sensorOutMsg.recorder(),
            field and field.envOutMsgs[0].recorder(),
        )
        reported = [each.message.recorder() for each in sensor_modules]
        recorders = [
            each
            for each in (*recorded, gyro_recorder, field_recorder, wheel_recorder, *reported)
            if each is not None
        ]
        run = _initialize_simulation([*modules, *recorders], step_ns)
    run.ConfigureStopTime(n * n_substeps * step_ns)
    run.ExecuteSimulation()
    wheels = np.zeros((n + 1, 0))
    if isinstance(vehicle, Vehicle) and wheel_recorder is not None:
        count = len(vehicle.wheels.axes)
        wheels = (
            wheel_recorder.wheelSpeeds[::n_substeps, :count] * configuration.read().JsList[:count]
        )
    vectors = [
        each.convert(own, recorded)[::n_substeps]
        for each, own in zip(sensor_modules, reported, strict=True)
    ]
    for each in vectors:
        each[0] = np.nan  # There are no readings at the start.
    rates = recorded.state.omega_BN_B[::n_substeps]
    step_rotations = _compose_rotations(
        gyro_recorder.DRFramePlatform[1:].reshape(-1, n_substeps, 3)
    )
    return SimulationResult(
        attitude=Rotation.from_mrp(recorded.state.sigma_BN[::n_substeps]).inv().as_matrix(),
        position=recorded.state.r_BN_N[::n_substeps],
        field=np.zeros((0, 3))
        if field_recorder is None
        else 1e9 * field_recorder.magField_N[::n_substeps],
        mean_rates=step_rotations / scenario.step
        + compute_coning_correction(rates[:-1], rates[1:], scenario.step),
        sensors=tuple(vectors),
        wheel_momentum=wheels,
    )


def _initialize_simulation(modules: list[Any], step_ns: int) -> Any:
    run = SimulationBaseClass.SimBaseClass()
    run.SetProgressBar(False)
    run.CreateNewProcess("simulation").addTask(run.CreateNewTask("step", step_ns))
    for priority, module in enumerate(reversed(modules)):
        run.AddModelToTask("step", module, priority)
    run.InitializeSimulation()
    return run


def _build_rate_correction(suite: Suite, states: Floats) -> Callable[[Floats], Floats]:
    x = {name: states[None, i : i + 3] for name, i in suite.get_first_indices(suite.gyro).items()}
    errors = SimpleNamespace(**x)

    def correct_rate(reported: Floats) -> Floats:
        rate: Floats = suite.gyro.correct_measurement(errors, reported[None])[0]
        return rate

    return correct_rate


def _build_satellite(
    scenario: Scenario,
    inputs: SimulationInputs,
    vehicle: Vehicle | MagnetorquerVehicle,
    environment: Environment,
    messages: EnvironmentMessages,
) -> Any:
    satellite = spacecraft.Spacecraft()
    satellite.ModelTag = "satellite"
    satellite.hub.IHubPntBc_B = vehicle.inertia.tolist()
    satellite.hub.sigma_BNInit = Rotation.from_matrix(inputs.attitude).inv().as_mrp().tolist()
    satellite.hub.omega_BN_BInit = inputs.rate.tolist()
    satellite.hub.r_CN_NInit = environment.position[0].tolist()
    satellite.hub.v_CN_NInit = environment.velocity[0].tolist()
    satellite.gravField.gravBodies = build_central_body(messages)
    orbit = scenario.orbit
    if not (isinstance(orbit, Orbit) and orbit.propagator == "two-body"):
        satellite.transRefInMsg.subscribeTo(messages.satellite_state)
    return satellite


def _compose_rotations(rotations: Floats) -> Floats:
    """Compose the rotation vectors within each step into one rotation vector per step.

    The second axis of the given array contains the rotation vectors of a step.
    """
    vectors: Floats = reduce(mul, map(Rotation.from_rotvec, rotations.swapaxes(0, 1))).as_rotvec()
    return vectors
