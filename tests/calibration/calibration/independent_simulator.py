"""Independent simulator: exact integration of any motion, with its own sensor errors and noise.

It shares with `mgeo_calibration.simulate_telemetry` only orbit, Sun and field. The body rotates
while the gyro averages. Gyro and sensors can be quantized, have latencies, and report implausible
values.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.sensors.error_models import get_initial_sigma
from mgeo_calibration import Telemetry
from mgeo_calibration.telemetry.telemetry import Truth
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from .independent_sensors import (
    FIELD_UNIT,
    SENSORS,
    SensorEnvironment,
    build_symmetric_matrix,
    displace_environment,
    draw_environment_errors,
    gauss_markov,
    gibbs_vector,
    normalized,
)

#: Number of parts of a step in which the rate is linear.
PARTS = 10
_GAUSS = 0.5 + np.array([-1.0, 1.0]) * np.sqrt(3.0) / 6.0

Rate = Callable[[np.ndarray], np.ndarray]


def constant_rates(plan) -> Rate:
    """Return the rate function of a plan with constant rates [deg/s] and durations [s], followed by
    rest.
    """
    rows = np.reshape(plan, (-1, 4))
    rates = np.radians(np.vstack([rows[:, :3], np.zeros(3)]))
    return lambda t: rates[np.searchsorted(np.cumsum(rows[:, 3]), t, side="right")]


def coning_motion(deg_s, frequency, about=(0.3, -0.2, 0.5)) -> Rate:
    """Return the rate function of a constant rate plus a rate vector [deg/s] that rotates about z
    with a frequency [rad/s].
    """

    def rate(t):
        turning = np.stack([np.cos(frequency * t), np.sin(frequency * t), 0.0 * t], axis=-1)
        return np.radians(deg_s * turning + np.array(about))

    return rate


def tumbling_motion(inertia, start_deg_s, duration) -> Rate:
    """Return the rate function of a free rigid body. Euler's equations are solved at the first
    call.
    """
    J = np.asarray(inertia)

    @cache
    def solution():
        return solve_ivp(
            lambda _, w: np.cross(J * w, w) / J,
            (-1.0, duration + 1.0),
            np.radians(start_deg_s),
            method="DOP853",
            rtol=1e-12,
            atol=1e-12,
            dense_output=True,
        ).sol

    return lambda t: solution()(np.ravel(t)).T.reshape(*np.shape(t), 3)


def integrate_motion(rate: Rate, times) -> tuple[np.ndarray, Rotation]:
    """Return the integral of the rate over each step, and the rotation from the body to its initial
    axes at all times.

    Magnus's series of fourth order, R' = R [w x], in parts of the steps.
    """
    h = np.diff(times)[:, None] / PARTS
    angle, step = np.zeros((len(h), 3)), Rotation.identity(len(h))
    for part in range(PARTS):
        a, b = (rate(times[:-1] + (part + node) * h[:, 0]) for node in _GAUSS)
        mean = 0.5 * h * (a + b)
        angle += mean
        step = step * Rotation.from_rotvec(mean + np.sqrt(3.0) / 12.0 * h**2 * np.cross(a, b))
    R = np.concatenate([np.eye(3)[None], step.as_matrix()])
    reach = 1
    while reach < len(R):
        R[reach:] = R[:-reach] @ R[reach:]
        reach *= 2
    return angle, Rotation.from_matrix(R)


@dataclass(frozen=True, kw_only=True)
class TrueErrors:
    """True errors of a satellite. Errors that are not given are drawn from the scenario.

    Attributes
    ----------
    gyro_bias_deg_s, sun_bias, mag_bias_nt : array, shape (3,)
    sun_turn_deg, mag_turn_deg : array, shape (3,)
        Rotation vectors of misalignments.
    decay, walk : float
        Decay [1/s] and random walk [rad/s^1.5] of the gyro bias.
    gyro_step_deg_s, mag_step_nt : float
        Quantization steps; zero for no quantization.
    unit_vectors : bool
        True if the Sun sensor normalizes its vectors.
    instantaneous : bool
        True if the gyro reports the rate at the sample.
    late : mapping of str to float
        Latency of sensors [s].
    behind : float
        Time by which the satellite is behind its orbit along the track [s].
    spikes : mapping of (str, int) to float or array
        Values that replace a sample of ``gyro`` or a sensor.
    """

    gyro_bias_deg_s: np.ndarray | None = None
    sun_bias: np.ndarray | None = None
    mag_bias_nt: np.ndarray | None = None
    sun_turn_deg: np.ndarray | None = None
    mag_turn_deg: np.ndarray | None = None
    decay: float | None = None
    walk: float | None = None
    gyro_step_deg_s: float = 0.0
    mag_step_nt: float = 0.0
    unit_vectors: bool = False
    instantaneous: bool = False
    late: dict[str, float] = field(default_factory=dict)
    behind: float = 0.0
    spikes: dict[tuple[str, int], float] = field(default_factory=dict)

    @property
    def gyro(self) -> dict[str, np.ndarray]:
        """Given gyro errors in the units of the filter."""
        return scale_values(bias=(self.gyro_bias_deg_s, np.pi / 180.0))

    def of(self, sensor) -> dict[str, np.ndarray]:
        """Return the given errors of a sensor in the units of the filter."""
        turn, bias, unit = {
            "sun-sensor": (self.sun_turn_deg, self.sun_bias, 1.0),
            "magnetometer": (self.mag_turn_deg, self.mag_bias_nt, 1.0 / FIELD_UNIT),
        }.get(sensor.kind, (None, None, 1.0))
        late = np.full(3, self.late.get(sensor.name, 0.0))
        return scale_values(
            misalignment=(turn, np.pi / 180.0), bias=(bias, unit), latency=(late, 1.0)
        )


def scale_values(**given) -> dict[str, np.ndarray]:
    """Return the given values in the units of the filter, as a dict by state; None is omitted."""
    return {
        state: unit * np.asarray(value, dtype=float)
        for state, (value, unit) in given.items()
        if value is not None
    }


@cache
def build_environment(scenario: Scenario, n: int, step: float, late: float, behind: float):
    times = np.arange(1, n + 1) * step - late
    if not behind:
        return Environment.from_times(scenario, times)
    position, _ = scenario.orbit.propagate(scenario.epoch, times - behind)
    return Environment.from_times(scenario, times, position)


def draw_errors(part, rng, given) -> dict:
    """Return the errors of a gyro or sensor: given, or else drawn.

    ``turn`` is the misalignment as a rotation, ``misalignment`` the vector that a truth contains.
    """
    own = dict(given)
    for state, sigma in part.states().items():
        drawn = get_initial_sigma(sigma) * rng.standard_normal(3)
        own.setdefault(state, drawn)
    own["turn"] = Rotation.from_rotvec(own.get("misalignment", np.zeros(3)))
    return own | {"misalignment": gibbs_vector(own["turn"])}


def simulate_readings(
    scenario: Scenario, rate: Rate, seed, craft=None, duration=3000.0, step=1.0, start=None
) -> Telemetry:
    """Simulate the telemetry of the scenario's gyro and sensors, with its truth.

    Parameters
    ----------
    start : Rotation, optional
        Body to GCRS at the epoch. Default: random.
    """
    craft, suite = craft or TrueErrors(), scenario.suite
    rng, gyro = np.random.default_rng(seed), scenario.gyro
    n = round(duration / step)
    times = np.arange(n + 1) * step
    angle, relative = integrate_motion(rate, times)
    anywhere = Rotation.random(rng=rng)
    attitude = (start or anywhere) * relative

    own = draw_errors(gyro, rng, craft.gyro)
    decay = gyro.bias_decay if craft.decay is None else craft.decay
    walk = gyro.rate_random_walk if craft.walk is None else craft.walk
    kicks = np.array(walk) * np.sqrt(step) * rng.standard_normal((n, 3))
    biases = np.empty((n + 1, 3))
    biases[0] = own["bias"]
    for k in range(n):
        biases[k + 1] = np.exp(-decay * step) * biases[k] + kicks[k]
    density = np.radians(gyro.angle_random_walk_deg_per_sqrt_h) / 60.0
    noise = density / np.sqrt(step) * rng.standard_normal((n, 3))
    true, drift = angle / step, 0.5 * (biases[1:] + biases[:-1])
    if craft.instantaneous:
        true, drift = rate(times[1:]), biases[1:]
    rates = own["turn"].apply(true @ build_symmetric_matrix(own).T) + drift + noise
    rates = quantize(np.degrees(rates), craft.gyro_step_deg_s)

    world = draw_environment_errors(scenario.environment_errors, n, step, rng)
    readings, truth = {}, {f"gyro.{state}": own[state] for state in gyro.states()}
    truth |= {"gyro.bias": biases[1:]} | {
        f"environment_errors.{state}": e for state, e in world.items()
    }
    for sensor in scenario.sensors:
        own = draw_errors(sensor, rng, craft.of(sensor))
        late = craft.late.get(sensor.name, 0.0)
        around = build_environment(scenario, n, step, late, craft.behind)
        if "orbit_error" in world:
            around = displace_environment(scenario, around, world["orbit_error"])
        at = SensorEnvironment(around, world, scenario.environment_errors.earth_albedo)
        then = attitude[1:]
        if late:
            _, early = integrate_motion(lambda t, late=late: rate(t - late), times)
            back = integrate_motion(rate, np.array([-late, 0.0]))[1][1].inv()
            then = (attitude[0] * back * early)[1:]
        y = SENSORS[sensor.kind](sensor, own, at, then.inv(), rng)
        if sensor.kind == "sun-sensor" and craft.unit_vectors:
            y = normalized(y)
        if sensor.kind == "magnetometer":
            y = quantize(y, craft.mag_step_nt)
        if max_rate := getattr(sensor, "max_rate_deg_s", None):
            y[np.linalg.norm(angle, axis=1) / step > np.radians(max_rate)] = np.nan
        readings[sensor.name] = y
        truth |= {f"{sensor.name}.{state}": own[state] for state in sensor.states()}
    readings["gyro"] = rates
    for (name, k), value in craft.spikes.items():
        readings[name][k] = value
    states = np.zeros((n, suite.n_states))
    for block, values in truth.items():
        first = 3 * suite.blocks.index(block)
        states[:, first : first + 3] = values
    return Telemetry(
        times=times[1:],
        gyro_deg_s=readings.pop("gyro"),
        sensors=readings,
        truth=Truth(attitude=attitude[1:].as_matrix().swapaxes(1, 2), states=states),
    )


def simulate_attitude_hold(
    scenario: Scenario, axes, mounting: Rotation, error, seed, step
) -> Telemetry:
    """Simulate telemetry of a satellite without a gyro that deviates from its reference axes, with
    its truth.

    Parameters
    ----------
    axes : str
        ``lvlh`` or ``inertial``.
    mounting : Rotation
        Rotation of coordinates from the axes to the body.
    error : (float, float)
        1-sigma [rad] and correlation time [s] of the pointing error, a Gauss-Markov process that is
        integrated in parts of the steps.
    """
    rng, n = np.random.default_rng(seed), round(scenario.duration / step)
    around = build_environment(scenario, n, step, 0.0, 0.0)
    held = Rotation.identity(n)
    if axes == "lvlh":
        z = -normalized(around.position)
        y = -normalized(np.cross(around.position, around.velocity))
        held = Rotation.from_matrix(np.stack([np.cross(y, z), y, z], axis=-1))
    off = gauss_markov(*error, n * PARTS, step / PARTS, rng)[::PARTS]
    attitude = held * mounting.inv() * Rotation.from_rotvec(off)
    readings, states = {}, np.zeros((n, scenario.suite.n_states))
    for sensor in scenario.sensors:
        own = draw_errors(sensor, rng, {})
        at = SensorEnvironment(around, {}, scenario.environment_errors.earth_albedo)
        readings[sensor.name] = SENSORS[sensor.kind](sensor, own, at, attitude.inv(), rng)
        for state in sensor.states():
            states[:, scenario.suite.block_slices[f"{sensor.name}.{state}"]] = own[state]
    return Telemetry(
        times=np.arange(1, n + 1) * step,
        gyro_deg_s=np.full((n, 3), np.nan),
        sensors=readings,
        truth=Truth(attitude=attitude.as_matrix().swapaxes(1, 2), states=states),
    )


def quantize(values, step):
    """Round values to multiples of a step; a step of zero changes nothing."""
    return step * np.round(values / step) if step else values
