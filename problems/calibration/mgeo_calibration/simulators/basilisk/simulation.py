"""Assembly and execution of a Basilisk simulation."""

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
    """Initial conditions and true errors of a run of n steps.

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
    """Logged results of Basilisk at n + 1 samples.

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
    """Run Basilisk and return the logged results; see `fly`.

    Magnetorquers ignore `motion`. The generator provides only the seeds of the noise.
    """
    bskLogging.setDefaultLogLevel(bskLogging.BSK_ERROR)
    suite, n = scenario.suite, scenario.n_steps
    parts = math.ceil(scenario.step / MAX_STEP)
    h = scenario.step / parts
    nanoseconds = round(h * 1e9)

    def errors_of(owner: Any) -> dict[str, Floats]:
        places = suite.get_first_indices(owner).items()
        return {name: inputs.true_states[i : i + 3] for name, i in places if name in owner.states()}

    def seed() -> int:
        return int(generator.integers(1, 2**31 - 1))

    surroundings = EnvironmentMessages(environment, scenario.epoch, parts * nanoseconds)
    satellite = _build_satellite(scenario, inputs, vehicle, environment, surroundings)
    modules: list[Any] = [surroundings, satellite]
    field = shadow = spins = None
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(vehicle, MagnetorquerVehicle) or any(
            isinstance(sensor, Magnetometer) for sensor in suite.sensors
        ):
            coefficients = Path(folder, "igrf.COF")
            coefficients.write_text(
                format_field_coefficients(compute_middle_time(environment, scenario.epoch))
            )
            modules.append(field := build_field_model(satellite, surroundings, coefficients))
        if scenario.eclipse:
            modules.append(shadow := build_eclipse_model(satellite, surroundings))
        sources = SensorInputs(satellite, surroundings, field, shadow)
        of_gyro = errors_of(suite.gyro)
        imu = build_gyro(suite.gyro, of_gyro, h, sources, seed())
        instruments = [
            SENSOR_BUILDERS[type(sensor)](sensor, errors_of(sensor), sources, seed)
            for sensor in suite.sensors
        ]
        bias = np.repeat(inputs.mean_bias / (1.0 + of_gyro.get("scale_factor", 0.0)), parts, axis=0)
        corrected = _build_rate_correction(suite, inputs.estimates)
        loop: Sequence[Any]
        if isinstance(vehicle, MagnetorquerVehicle):
            timing = nanoseconds, parts, inputs.rate
            effector, loop = build_magnetorquer_control(
                vehicle, satellite, field, imu, corrected, bias, timing
            )
        else:
            effector, configuration = add_reaction_wheels(vehicle, satellite, inputs.rate)
            reference = Reference.from_motion(motion, inputs.rate, scenario.step, parts)
            guidance = Guidance(imu, reference, inputs.rate, corrected, bias, nanoseconds)
            loop = [guidance, *build_control_loop(vehicle, guidance, effector, configuration)]
            spins = effector.rwSpeedOutMsg.recorder()
        modules.insert(1, effector)
        modules += [imu, *(each.module for each in instruments), *loop]
        log = Recorders(
            satellite.scStateOutMsg.recorder(),
            surroundings.unit_sun.recorder(),
            shadow and shadow.eclipseOutMsgs[0].recorder(),
        )
        turns, around = imu.sensorOutMsg.recorder(), field and field.envOutMsgs[0].recorder()
        reported = [each.message.recorder() for each in instruments]
        recorders = [each for each in (*log, turns, around, spins, *reported) if each is not None]
        run = _initialize_simulation([*modules, *recorders], nanoseconds)
    run.ConfigureStopTime(n * parts * nanoseconds)
    run.ExecuteSimulation()
    wheels = np.zeros((n + 1, 0))
    if isinstance(vehicle, Vehicle) and spins is not None:
        count = len(vehicle.wheels.axes)
        wheels = spins.wheelSpeeds[::parts, :count] * configuration.read().JsList[:count]
    vectors = [
        each.convert(own, log)[::parts] for each, own in zip(instruments, reported, strict=True)
    ]
    for each in vectors:
        each[0] = np.nan  # There are no readings at the start.
    rates = log.state.omega_BN_B[::parts]
    turned = _compose_rotations(turns.DRFramePlatform[1:].reshape(-1, parts, 3))
    return SimulationResult(
        attitude=Rotation.from_mrp(log.state.sigma_BN[::parts]).inv().as_matrix(),
        position=log.state.r_BN_N[::parts],
        field=np.zeros((0, 3)) if around is None else 1e9 * around.magField_N[::parts],
        mean_rates=turned / scenario.step
        + compute_coning_correction(rates[:-1], rates[1:], scenario.step),
        sensors=tuple(vectors),
        wheel_momentum=wheels,
    )


def _initialize_simulation(modules: list[Any], nanoseconds: int) -> Any:
    run = SimulationBaseClass.SimBaseClass()
    run.SetProgressBar(False)
    run.CreateNewProcess("monte_carlo").addTask(run.CreateNewTask("step", nanoseconds))
    for priority, module in enumerate(reversed(modules)):
        run.AddModelToTask("step", module, priority)
    run.InitializeSimulation()
    return run


def _build_rate_correction(suite: Suite, states: Floats) -> Callable[[Floats], Floats]:
    """Return a function that corrects a rate, shape (3,), by the estimated gyro errors."""
    x = {name: states[None, i : i + 3] for name, i in suite.get_first_indices(suite.gyro).items()}
    errors = SimpleNamespace(**x)

    def corrected(reported: Floats) -> Floats:
        rate: Floats = suite.gyro.correct_measurement(errors, reported[None])[0]
        return rate

    return corrected


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
    """Compose successive rotation vectors, shape (n, m, 3), into one per step, shape (n, 3)."""
    vectors: Floats = reduce(mul, map(Rotation.from_rotvec, rotations.swapaxes(0, 1))).as_rotvec()
    return vectors
