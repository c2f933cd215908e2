"""Simulate healthy satellites and count the calibrations that find them consistent.

``python -m tests.benchmarks.healthy_flights > docs/validation/data/healthy.csv`` writes the data of
docs/validation/independent-simulator.md. Names of classes restrict the flights to these classes.
The reasons of inconsistent verdicts and errors are written to stderr.

Each class is simulated by `mgeo_calibration.simulate_telemetry` and by the independent simulation
of the tests, which shares only the models of the environment with the estimator. Durations, rates
and axes differ from flight to flight.
"""

from __future__ import annotations

import argparse
import csv
import re
import sys
import warnings
import zlib
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.scenario.validity import OutsideValidity
from mgeo_calibration import Telemetry, TelemetryMapping, calibrate, simulate_telemetry
from mgeo_calibration.telemetry.mapping import GyroChannels
from scipy.spatial.transform import Rotation

from ..calibration.calibration import independent_simulator
from ..calibration.calibration.runs import normalize_error

SIMULATORS = ("fly", "independent")
VERDICTS = ("consistent", "inconsistent", "refused", "not converged")
#: Columns of the results. The largest error is in 1-sigmas, and NEES is per state.
COLUMNS = ("class", "simulator", "flights", *VERDICTS, "largest error", "nees")
DURATIONS = (1500.0, 3000.0, 6000.0, 9000.0)
#: Duration of the constant rates that approximate the orbital rate [s].
_SEGMENT_DURATION = 60.0

Plan = np.ndarray
Motion = Callable[[Scenario, np.random.Generator], Plan]


def three_axis(scenario: Scenario, rng: np.random.Generator) -> Plan:
    """Return a plan with rates about all axes [deg/s], each for some minutes, until the end."""
    n = int(scenario.duration // 400.0) + 1
    return np.column_stack([rng.uniform(-0.7, 0.7, (n, 3)), rng.uniform(300.0, 700.0, n)])


def nadir(scenario: Scenario, rng: np.random.Generator) -> Plan:
    """Return a plan that follows the orbital frame, with one rate per minute."""
    times = np.arange(
        0.5 * _SEGMENT_DURATION, scenario.duration + _SEGMENT_DURATION, _SEGMENT_DURATION
    )
    r, v = scenario.orbit.propagate(scenario.epoch, times)
    rate = np.degrees(np.linalg.norm(np.cross(r, v), axis=1) / (r * r).sum(axis=1))
    rest = np.zeros_like(rate)
    return np.column_stack([rest, -rate, rest, np.full_like(rate, _SEGMENT_DURATION)])


def inertial_hold(scenario: Scenario, rng: np.random.Generator) -> Plan:
    return np.array([[0.0, 0.0, 0.0, scenario.duration]])


def one_axis_spin(scenario: Scenario, rng: np.random.Generator) -> Plan:
    """Return a plan with a random rate of 0.05 to 1 deg/s about one body axis."""
    rate = np.exp(rng.uniform(np.log(0.05), np.log(1.0))) * np.eye(3)[rng.integers(3)]
    return np.array([[*rate, scenario.duration]])


def tumble(scenario: Scenario, rng: np.random.Generator) -> Plan:
    """Return a plan with the rates of a tumbling satellite, one rate for each ten seconds."""
    times = np.arange(5.0, scenario.duration + 10.0, 10.0)
    rates = np.degrees(draw_tumble_rate(scenario, rng)(times))
    return np.column_stack([rates, np.full(len(times), 10.0)])


def draw_tumble_rate(scenario: Scenario, rng: np.random.Generator) -> independent_simulator.Rate:
    """Return the rate of a tumbling satellite with a random initial rate, by Euler's equations."""
    start = rng.uniform(-1.0, 1.0, 3)
    return independent_simulator.tumbling_motion([0.13, 0.10, 0.05], start, scenario.duration)


@dataclass(frozen=True)
class HealthyClass:
    """Class of healthy satellites: motion, preset, and differences between true and declared
    scenario.

    Attributes
    ----------
    motion : function
        Function from the true scenario and a random generator to the plan.
    preset : str
        Preset of the scenario.
    changes : dict
        Keys of the true scenario in addition to the preset.
    declared : dict
        Keys of the estimator's scenario that differ from the true scenario.
    with_gyro : bool
        If False, the telemetry has no gyro rates, the satellite holds the orbital frame, and the
        gyro errors become the pointing error.
    """

    motion: Motion = three_axis
    preset: str = "cubesat_6u"
    changes: dict[str, Any] = field(default_factory=dict)
    declared: dict[str, Any] = field(default_factory=dict)
    with_gyro: bool = True

    def scenarios(self, duration: float) -> tuple[Scenario, Scenario]:
        """Return the true scenario, and the scenario that is declared to the estimator."""
        keys = {"preset": self.preset, "duration": duration, "convergence": {"window": 300.0}}
        if self.motion is nadir:
            keys["initial"] = {"pointing": "nadir"}
        true = keys | self.changes
        return Scenario.from_dict(true), Scenario.from_dict(true | self.declared)


SUN = {"kind": "sun-sensor", "noise_deg": 0.5, "initial_misalignment_deg": 0.5}
SUN |= {"initial_bias": 0.003}
MAG = {"kind": "magnetometer", "noise_nt": 100.0, "initial_misalignment_deg": 1.0}
MAG |= {"initial_bias_nt": 500.0}
TWO_AXIS = SUN | {"kind": "two-axis-sun-sensor"}
HORIZON = {"kind": "horizon-sensor", "initial_misalignment_deg": 0.5}
TRACKER = {"kind": "star-tracker", "boresight": [-1.0, -1.0, 1.0], "max_rate_deg_s": 1.0}
TRACKER |= {"sun_exclusion_deg": 40.0, "earth_exclusion_deg": 20.0}
FACES = {"px": (1, 0, 0), "mx": (-1, 0, 0), "py": (0, 1, 0), "my": (0, -1, 0)}
FACES |= {"pz": (0, 0, 1), "mz": (0, 0, -1)}
DIODES = [
    {"kind": "photodiode", "name": name, "normal": [*map(float, n)]} for name, n in FACES.items()
]


def declared_larger(key: str, size: float, factor: float) -> HealthyClass:
    """Return a class in which one environment model error is declared larger than it is."""
    return HealthyClass(
        changes={"environment_errors": {key: size}},
        declared={"environment_errors": {key: factor * size}},
    )


def larger_priors(factor: float) -> dict[str, Any]:
    """Return scenario keys in which the initial 1-sigmas of all constants are multiplied by a
    factor.
    """
    sensors = [
        {
            key: factor * value if key.startswith("initial_") else value
            for key, value in each.items()
        }
        for each in (SUN, MAG)
    ]
    return {"sensors": sensors, "gyro": {"initial_bias_deg_s": factor / 360.0}}


def two_axis_with_albedo(factor: float) -> HealthyClass:
    """Return a class with albedo whose error is declared larger than it is by a factor."""
    sizes = (0.03 / factor, 0.03)
    true, declared = (
        {"environment_errors": {"albedo": size, "earth_albedo": 0.3}} for size in sizes
    )
    return HealthyClass(changes={"sensors": [TWO_AXIS, MAG]} | true, declared=declared)


CLASSES = {
    "three-axis": HealthyClass(),
    "nadir": HealthyClass(nadir),
    "inertial hold": HealthyClass(inertial_hold),
    "one-axis spin": HealthyClass(one_axis_spin),
    "tumble": HealthyClass(tumble),
    "without gyro": HealthyClass(nadir, with_gyro=False),
    "paper": HealthyClass(preset="paper"),
    "cubesat_6u_full": HealthyClass(preset="cubesat_6u_full"),
    "cubesat_1u": HealthyClass(preset="cubesat_1u"),
    "microsatellite": HealthyClass(preset="microsatellite"),
    "field error x1": declared_larger("field_error_nt", 100.0, 1.0),
    "field error x3": declared_larger("field_error_nt", 100.0, 3.0),
    "field error x10": declared_larger("field_error_nt", 30.0, 10.0),
    "albedo x1": declared_larger("albedo", 0.03, 1.0),
    "albedo x3": declared_larger("albedo", 0.01, 3.0),
    "albedo x10": declared_larger("albedo", 0.003, 10.0),
    "priors x3": HealthyClass(changes={"sensors": [SUN, MAG]}, declared=larger_priors(3.0)),
    "priors x10": HealthyClass(changes={"sensors": [SUN, MAG]}, declared=larger_priors(10.0)),
    "two-axis": HealthyClass(changes={"sensors": [TWO_AXIS, MAG]}),
    "two-axis albedo": two_axis_with_albedo(1.0),
    "two-axis albedo x3": two_axis_with_albedo(3.0),
    "two-axis albedo x10": two_axis_with_albedo(10.0),
    "large walk": HealthyClass(
        changes={"gyro": {"rate_random_walk": 2e-5, "initial_bias_deg_s": 0.05}}
    ),
    "horizon": HealthyClass(changes={"sensors": [SUN, HORIZON]}),
    "star tracker": HealthyClass(changes={"sensors": [TRACKER, MAG]}),
    "photodiodes albedo": HealthyClass(
        changes={
            "sensors": [*DIODES, MAG],
            "environment_errors": {"albedo": 0.03, "earth_albedo": 0.3},
        }
    ),
}


@dataclass(frozen=True)
class Outcome:
    """Result of one flight and its calibration.

    Attributes
    ----------
    verdict : str
        ``consistent``, ``inconsistent``, ``not converged`` or ``refused``.
    reason : str
        First words of the conclusion or of the error message, without numbers.
    worst, nees : float
        Largest error over its 1-sigma, and NEES per state; NaN without an estimate.
    """

    verdict: str
    reason: str = ""
    worst: float = np.nan
    nees: float = np.nan


def orbital_frame(scenario: Scenario) -> Rotation:
    """Return the rotation from the orbital frame (z down, x forward) to GCRS at the epoch."""
    (r,), (v,) = scenario.orbit.propagate(scenario.epoch, np.zeros(1))
    z, y = -r / np.linalg.norm(r), -np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    return Rotation.from_matrix(np.column_stack([np.cross(y, z), y, z]))


def simulate_with_package(
    healthy_class: HealthyClass, true: Scenario, declared: Scenario, rng: np.random.Generator
) -> Telemetry:
    """Return telemetry from `mgeo_calibration.simulate_telemetry`.

    Without a gyro, the satellite holds the orbital frame exactly.
    """
    environment = Environment.from_scenario(declared)
    plan = healthy_class.motion(true, rng)
    telemetry = simulate_telemetry(declared, plan.ravel(), rng, truth=true, environment=environment)
    if not healthy_class.with_gyro:
        telemetry.truth.states[:, 3:6] = 0.0
    return telemetry


def simulate_independently(
    healthy_class: HealthyClass, true: Scenario, rng: np.random.Generator
) -> Telemetry:
    """Return telemetry from the independent simulation, with a random initial attitude or along the
    orbital frame.
    """
    drift = None
    if healthy_class.motion is tumble:
        rate = draw_tumble_rate(true, rng)
    else:
        rate = independent_simulator.constant_rates(healthy_class.motion(true, rng))
    if not healthy_class.with_gyro:
        rate, drift = add_gyro_errors(true, rate, rng)
    telemetry = independent_simulator.simulate_readings(
        true,
        rate,
        rng,
        duration=true.duration,
        step=true.step,
        start=orbital_frame(true) if healthy_class.motion is nadir else None,
    )
    if drift is not None:
        telemetry.truth.states[:, 3:6] = drift
    return telemetry


def add_gyro_errors(
    scenario: Scenario, rate: independent_simulator.Rate, rng: np.random.Generator
) -> tuple[independent_simulator.Rate, np.ndarray]:
    """Return a rate with random gyro errors, and the gyro bias at the samples [rad/s]."""
    gyro, step = scenario.gyro, scenario.step
    n = round(scenario.duration / step)
    drift = np.radians(gyro.initial_bias_deg_s) * rng.standard_normal(3) + np.cumsum(
        gyro.rate_random_walk * np.sqrt(step) * rng.standard_normal((n, 3)), axis=0
    )
    walk = np.radians(gyro.angle_random_walk_deg_per_sqrt_h) / 60.0
    errors = drift + walk / np.sqrt(step) * rng.standard_normal((n, 3))

    def disturbed_rate(t: np.ndarray) -> np.ndarray:
        return rate(t) - errors[np.clip(np.asarray(t) // step, 0, n - 1).astype(int)]

    return disturbed_rate, drift


def run_flight(name: str, simulator: str, number: int) -> Outcome:
    """Simulate and calibrate one flight of a class, and return the outcome."""
    healthy_class = CLASSES[name]
    true, declared = healthy_class.scenarios(DURATIONS[number % len(DURATIONS)])
    rng = np.random.default_rng([zlib.crc32(f"{name}, {simulator}".encode()), number])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutsideValidity)
        if simulator == "fly":
            telemetry = simulate_with_package(healthy_class, true, declared, rng)
        else:
            telemetry = simulate_independently(healthy_class, true, rng)
        source: Any = telemetry
        mapping = None
        if not healthy_class.with_gyro:
            source = telemetry.to_frame().drop(columns=["gyro_x", "gyro_y", "gyro_z"])
            mapping = TelemetryMapping(gyro=GyroChannels(reference_axes="lvlh"))
        try:
            calibration = calibrate(declared, source, mapping)
        except ValueError as error:
            is_divergent = "settle" in str(error) or "converge" in str(error)
            verdict = "not converged" if is_divergent else "refused"
            return Outcome(verdict, shorten_message(str(error)))
    nees, x = normalize_error(calibration, telemetry)
    reason = "" if calibration.is_consistent else shorten_message(str(calibration.failures[0]))
    verdict = "consistent" if calibration.is_consistent else "inconsistent"
    return Outcome(verdict, reason, float(np.abs(x).max()), float(nees))


def shorten_message(message: str) -> str:
    """Return the first words of a message, with # in place of numbers."""
    return re.sub(r"[-+]?\d[\d.e+-]*", "#", message)[:44]


def summarize(name: str, simulator: str, outcomes: Sequence[Outcome]) -> list[object]:
    """Return the values of `COLUMNS` for the flights of one class and simulator."""
    verdicts = Counter(each.verdict for each in outcomes)
    estimated = [each for each in outcomes if np.isfinite(each.nees)]
    worst = max((each.worst for each in estimated), default=np.nan)
    nees = np.mean([each.nees for each in estimated]) if estimated else np.nan
    counts = [len(outcomes), *(verdicts[verdict] for verdict in VERDICTS)]
    return [name, simulator, *counts, f"{worst:.1f}", f"{nees:.2f}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("classes", nargs="*", metavar="class", help=", ".join(CLASSES))
    parser.add_argument(
        "--flights", type=int, default=50, help="number of flights of each class and simulator"
    )
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--simulators", nargs="+", choices=SIMULATORS, default=SIMULATORS)
    arguments = parser.parse_args()
    output = csv.writer(sys.stdout)
    output.writerow(COLUMNS)
    with Parallel(n_jobs=arguments.jobs) as parallel:
        for name in arguments.classes or CLASSES:
            for simulator in arguments.simulators:
                flights = (
                    delayed(run_flight)(name, simulator, k) for k in range(arguments.flights)
                )
                outcomes = parallel(flights)
                output.writerow(summarize(name, simulator, outcomes))
                sys.stdout.flush()
                for each in outcomes:
                    if each.reason:
                        print(f"{name}, {simulator}: {each.reason}", file=sys.stderr)


if __name__ == "__main__":
    main()
