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

from mgeo_calibration.flight.basilisk.control import (
    Guidance,
    Reference,
    coil_control,
    control_loop,
    reaction_wheels,
)
from mgeo_calibration.flight.basilisk.instruments import INSTRUMENTS, Log, Sources, rate_gyro
from mgeo_calibration.flight.basilisk.surroundings import (
    Surroundings,
    central_body,
    field_coefficients,
    field_model,
    middle,
    shadow_model,
)
from mgeo_calibration.flight.basilisk.vehicle import Coiled, Vehicle
from mgeo_calibration.flight.flight import coning

#: Longest simulation step [s]; the scenario's step is divided into equal parts.
LONGEST_STEP = 1.0


@dataclass(frozen=True)
class Drawn:
    """Initial conditions and true errors of a run of n steps.

    Attributes
    ----------
    start : array, shape (3, 3)
        Initial rotation matrix from GCRS to body.
    rate : array, shape (3,)
        Initial body rate [rad/s].
    believed : array, shape (n_states,)
        Estimated gyro and sensor states on board; zero before a calibration.
    errors : array, shape (n_states,)
        True gyro and sensor states at the start.
    bias : array, shape (n, 3)
        Mean gyro bias in each step [rad/s].
    """

    start: Floats
    rate: Floats
    believed: Floats
    errors: Floats
    bias: Floats


@dataclass(frozen=True)
class Seen:
    """Logged results of Basilisk at n + 1 samples.

    Attributes
    ----------
    attitude : array, shape (n + 1, 3, 3)
        Rotation matrices from GCRS to body.
    position : array, shape (n + 1, 3)
        Position in GCRS [m].
    field : array, shape (n + 1, 3)
        Magnetic field in GCRS [nT]; empty without a field model.
    gyro : array, shape (n, 3)
        Mean reported rate in each step [rad/s].
    sensors : tuple of arrays, shape (n + 1, k, 3)
        Readings as in `Readings`.
    wheels : array, shape (n + 1, k)
        Momentum of each wheel [N m s]; k = 0 for a satellite with magnetorquers.
    """

    attitude: Floats
    position: Floats
    field: Floats
    gyro: Floats
    sensors: tuple[Floats, ...]
    wheels: Floats


def simulate(
    scenario: Scenario,
    motion: Motion,
    drawn: Drawn,
    vehicle: Vehicle | Coiled,
    environment: Environment,
    generator: np.random.Generator,
) -> Seen:
    """Run Basilisk and return the logged results; see `fly`.

    Magnetorquers ignore `motion`. The generator provides only the seeds of the noise.
    """
    bskLogging.setDefaultLogLevel(bskLogging.BSK_ERROR)
    suite, n = scenario.suite, scenario.n_steps
    parts = math.ceil(scenario.step / LONGEST_STEP)
    h = scenario.step / parts
    nanoseconds = round(h * 1e9)

    def errors_of(owner: Any) -> dict[str, Floats]:
        places = suite.get_first_indices(owner).items()
        return {name: drawn.errors[i : i + 3] for name, i in places if name in owner.states()}

    def seed() -> int:
        return int(generator.integers(1, 2**31 - 1))

    surroundings = Surroundings(environment, scenario.epoch, parts * nanoseconds)
    satellite = _build_satellite(scenario, drawn, vehicle, environment, surroundings)
    modules: list[Any] = [surroundings, satellite]
    field = shadow = spins = None
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(vehicle, Coiled) or any(
            isinstance(sensor, Magnetometer) for sensor in suite.sensors
        ):
            coefficients = Path(folder, "igrf.COF")
            coefficients.write_text(field_coefficients(middle(environment, scenario.epoch)))
            modules.append(field := field_model(satellite, surroundings, coefficients))
        if scenario.eclipse:
            modules.append(shadow := shadow_model(satellite, surroundings))
        sources = Sources(satellite, surroundings, field, shadow)
        of_gyro = errors_of(suite.gyro)
        imu = rate_gyro(suite.gyro, of_gyro, h, sources, seed())
        instruments = [
            INSTRUMENTS[type(sensor)](sensor, errors_of(sensor), sources, seed)
            for sensor in suite.sensors
        ]
        bias = np.repeat(drawn.bias / (1.0 + of_gyro.get("scale_factor", 0.0)), parts, axis=0)
        corrected = _build_rate_correction(suite, drawn.believed)
        loop: Sequence[Any]
        if isinstance(vehicle, Coiled):
            timing = nanoseconds, parts, drawn.rate
            effector, loop = coil_control(vehicle, satellite, field, imu, corrected, bias, timing)
        else:
            effector, configuration = reaction_wheels(vehicle, satellite, drawn.rate)
            reference = Reference.of(motion, drawn.rate, scenario.step, parts)
            guidance = Guidance(imu, reference, drawn.rate, corrected, bias, nanoseconds)
            loop = [guidance, *control_loop(vehicle, guidance, effector, configuration)]
            spins = effector.rwSpeedOutMsg.recorder()
        modules.insert(1, effector)
        modules += [imu, *(each.module for each in instruments), *loop]
        log = Log(
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
        each.vectors(own, log)[::parts] for each, own in zip(instruments, reported, strict=True)
    ]
    for each in vectors:
        each[0] = np.nan  # There are no readings at the start.
    rates = log.state.omega_BN_B[::parts]
    turned = _compose_rotations(turns.DRFramePlatform[1:].reshape(-1, parts, 3))
    return Seen(
        attitude=Rotation.from_mrp(log.state.sigma_BN[::parts]).inv().as_matrix(),
        position=log.state.r_BN_N[::parts],
        field=np.zeros((0, 3)) if around is None else 1e9 * around.magField_N[::parts],
        gyro=turned / scenario.step + coning(rates[:-1], rates[1:], scenario.step),
        sensors=tuple(vectors),
        wheels=wheels,
    )


def _initialize_simulation(modules: list[Any], nanoseconds: int) -> Any:
    run = SimulationBaseClass.SimBaseClass()
    run.SetProgressBar(False)
    run.CreateNewProcess("flight").addTask(run.CreateNewTask("step", nanoseconds))
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
    drawn: Drawn,
    vehicle: Vehicle | Coiled,
    environment: Environment,
    surroundings: Surroundings,
) -> Any:
    satellite = spacecraft.Spacecraft()
    satellite.ModelTag = "satellite"
    satellite.hub.IHubPntBc_B = vehicle.inertia.tolist()
    satellite.hub.sigma_BNInit = Rotation.from_matrix(drawn.start).inv().as_mrp().tolist()
    satellite.hub.omega_BN_BInit = drawn.rate.tolist()
    satellite.hub.r_CN_NInit = environment.position[0].tolist()
    satellite.hub.v_CN_NInit = environment.velocity[0].tolist()
    satellite.gravField.gravBodies = central_body(surroundings)
    orbit = scenario.orbit
    if not (isinstance(orbit, Orbit) and orbit.propagator == "two-body"):
        satellite.transRefInMsg.subscribeTo(surroundings.place)
    return satellite


def _compose_rotations(turns: Floats) -> Floats:
    """Compose successive rotation vectors, shape (n, m, 3), into one per step, shape (n, 3)."""
    vectors: Floats = reduce(mul, map(Rotation.from_rotvec, turns.swapaxes(0, 1))).as_rotvec()
    return vectors
