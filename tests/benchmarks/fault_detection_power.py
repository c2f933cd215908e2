"""Detection of faults that are just large enough to matter, and false alarms on healthy flights.

``python -m tests.benchmarks.fault_detection_power`` prints how many faults of each kind `calibrate`
reports, and writes docs/validation/data/detection.csv. With names of kinds, of which one is
``healthy``, only these kinds are simulated and nothing is written.

The size of a fault is chosen independently of the tests: it moves the worst estimate of a flight by
a given number of 1-sigmas (`SIGMAS`). The faults are then added to flights with other noise. The
results are compared with the power of the most powerful test, which knows everything about the
fault except its size (Neyman and Pearson). No test detects the part of a fault that the estimates
absorb.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
import pandas as pd
from mgeo_attitude import Scenario
from mgeo_attitude.sensors.base import scale_noise
from mgeo_calibration import Telemetry, calibrate
from mgeo_calibration.calibration.calibrate import compute_final_estimate
from mgeo_calibration.calibration.consistency_tests import SIGNIFICANCE
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.estimation.fit import fit
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.smoother import solve
from mgeo_calibration.estimation.trajectory import Trajectory
from scipy.stats import norm

from tests.benchmarks.pages import VALIDATION_DATA
from tests.calibration.calibration.faults import (
    add_drift,
    add_nonorthogonality,
    add_random_walk,
    add_scale_error,
    add_step,
    add_temperature_bias,
    change_gyro,
    change_sensor,
    names_cause,
    random_axis,
    temperature,
)
from tests.calibration.calibration.faulty_runs import DURATION, PLAN, SCENARIO
from tests.calibration.calibration.independent_simulator import (
    TrueErrors,
    constant_rates,
    simulate_readings,
)
from tests.calibration.calibration.runs import short

SIGMAS, SEEDS = (3.0, 5.0), (1, 2, 3)
#: Number of tests that `calibrate` makes of these flights, and power from which a fault counts as
#: detectable.
N_TESTS, DETECTABLE_POWER = 29, 0.9
NOISE_FACTOR = 1e-4
MOTION = constant_rates(PLAN)
HEALTHY = {"cubesat_6u": 100, "paper": 100}

Spoil = Callable[[Telemetry, np.random.Generator], Telemetry]


@dataclass(frozen=True)
class Kind:
    """Kind of fault: its cause, its effect for a given size, and an initial guess of the size."""

    cause: str
    first: float
    errors: Callable[[float, np.random.Generator], TrueErrors] = lambda size, rng: TrueErrors()
    spoil: Callable[[float], Spoil] = lambda size: lambda telemetry, rng: telemetry
    scenario: Scenario = SCENARIO

    def simulate(self, size: float, seed: int, noise: int) -> Telemetry:
        """Return the telemetry of a flight with the fault drawn from `seed` and the noise drawn
        from `noise`.
        """
        rng = np.random.default_rng([seed, 480])
        telemetry = simulate_readings(
            self.scenario, MOTION, noise, self.errors(size, rng), DURATION
        )
        return self.spoil(size)(add_temperature(telemetry), rng)

    def compute_power(self, size: float, seed: int) -> float:
        """Return the power of the most powerful test of the fault at the significance level of
        `calibrate`.

        The effect of the fault on the readings of a satellite without noise and errors is the mean
        of normal variables. The smallest sum of squares that remains after an estimate is the
        non-centrality.
        """
        noise_free, prior = remove_noise(self.scenario), PriorEstimate.from_scenario(self.scenario)
        rng = np.random.default_rng([seed, 480])
        errors = self.errors(size, rng)
        healthy_errors = TrueErrors(gyro_bias_deg_s=errors.gyro_bias_deg_s)
        base, healthy, faulty = (
            simulate_readings(noise_free, MOTION, 100 + seed, each, DURATION)
            for each in (
                remove_random_errors(TrueErrors()),
                remove_random_errors(healthy_errors),
                remove_random_errors(errors),
            )
        )
        faulty = self.spoil(size)(faulty, rng)
        telemetry = dataclasses.replace(
            base,
            gyro_deg_s=base.gyro_deg_s + faulty.gyro_deg_s - healthy.gyro_deg_s,
            sensors={
                name: rows + faulty.sensors[name] - healthy.sensors[name]
                for name, rows in base.sensors.items()
            },
        )
        assert base.truth is not None
        attitude = np.ascontiguousarray(base.truth.attitude.swapaxes(1, 2))
        trajectory = Trajectory(attitude, np.tile(prior.states, (len(base.times), 1)))
        solution = solve(build_batch(self.scenario, telemetry), prior, trajectory, 30)
        assert solution.is_converged()
        level = norm.isf(0.5 * SIGNIFICANCE / N_TESTS)
        return float(norm.sf(level - np.sqrt(solution.cost)))

    def compute_shift(self, size: float, seed: int) -> float:
        """Return the largest change of an estimate by the fault, in 1-sigmas."""
        error, sigma = compute_errors(self.scenario, self.simulate(size, seed, seed))
        return float(np.abs((error - compute_healthy_errors(self.scenario, seed)) / sigma).max())

    def compute_sizes(self, seed: int) -> tuple[float, ...]:
        """Return the sizes that change the worst estimate by `SIGMAS`.

        The change is taken as proportional to a size near the smallest of these sizes.
        """
        size = self.first * SIGMAS[0] / self.compute_shift(self.first, seed)
        slope = self.compute_shift(size, seed) / size
        return tuple(sigmas / slope for sigmas in SIGMAS)


def remove_noise(scenario: Scenario) -> Scenario:
    """Return the scenario with nearly noise-free gyro and sensors."""
    gyro = scenario.gyro
    return dataclasses.replace(
        scenario,
        gyro=dataclasses.replace(
            gyro,
            angle_random_walk_deg_per_sqrt_h=NOISE_FACTOR * gyro.angle_random_walk_deg_per_sqrt_h,
            rate_random_walk=NOISE_FACTOR * gyro.rate_random_walk,
        ),
        sensors=tuple(scale_noise(sensor, NOISE_FACTOR) for sensor in scenario.sensors),
    )


def remove_random_errors(errors: TrueErrors) -> TrueErrors:
    """Return the errors with zero in place of the errors that would be drawn at random."""
    names = ("gyro_bias_deg_s", "sun_bias", "mag_bias_nt", "sun_turn_deg", "mag_turn_deg")
    zeros = {name: np.zeros(3) for name in names if getattr(errors, name) is None}
    return dataclasses.replace(errors, **zeros)


def compute_errors(scenario: Scenario, telemetry: Telemetry) -> tuple[np.ndarray, np.ndarray]:
    """Return truth minus estimate of gyro and sensor states at the last sample, and 1-sigmas."""
    prior = PriorEstimate.from_scenario(scenario)
    states, P = compute_final_estimate(prior, fit(build_batch(scenario, telemetry), prior, 1e-5))
    assert telemetry.truth is not None
    return (telemetry.truth.states[-1] - states)[3:], np.sqrt(np.diag(P))[3:]


@cache
def compute_healthy_errors(scenario: Scenario, seed: int) -> np.ndarray:
    """Return the estimation errors of the flight with the same noise and without fault."""
    return compute_errors(
        scenario, add_temperature(simulate_readings(scenario, MOTION, seed, duration=DURATION))
    )[0]


def add_temperature(telemetry: Telemetry) -> Telemetry:
    return dataclasses.replace(
        telemetry, housekeeping={"temperature": temperature(telemetry.times)}
    )


def build_latency_errors(name: str) -> Callable[[float, np.random.Generator], TrueErrors]:
    return lambda size, rng: TrueErrors(late={name: size})


def vary_size(apply: Callable, change: Callable) -> Callable[[float], Spoil]:
    """Return a function that builds the change of readings for a fault size."""
    return lambda size: apply(change(size))


MAG, SUN = partial(change_sensor, "mag"), partial(change_sensor, "sun")
LARGE_BIAS_SCENARIO = dataclasses.replace(
    SCENARIO, gyro=dataclasses.replace(SCENARIO.gyro, initial_bias_deg_s=1.0, bias_decay=1e-5)
)
DRIFTS, CHANGES = r"gyro\.bias (drifts|decays|changes) by ", r"\.bias changes by "
KINDS = {
    "magnetometer late": Kind("mag readings lag", 0.1, build_latency_errors("mag")),
    "magnetometer early": Kind("mag readings precede", -0.1, build_latency_errors("mag")),
    "Sun sensor late": Kind("sun readings lag", 0.1, build_latency_errors("sun")),
    "Sun sensor early": Kind("sun readings precede", -0.1, build_latency_errors("sun")),
    "magnetometer's scale": Kind(
        r"mag\.scale_factor is ", 2e-3, spoil=vary_size(MAG, add_scale_error)
    ),
    "soft iron": Kind(
        r"mag\.nonorthogonality is ", 0.1, spoil=vary_size(MAG, add_nonorthogonality)
    ),
    "gyro's scale": Kind(
        r"gyro\.scale_factor is ", 2e-3, spoil=vary_size(change_gyro, add_scale_error)
    ),
    "gyro's axes": Kind(
        r"gyro\.nonorthogonality is ", 0.1, spoil=vary_size(change_gyro, add_nonorthogonality)
    ),
    "step of the magnetometer": Kind("mag" + CHANGES, 100.0, spoil=vary_size(MAG, add_step)),
    "step of the Sun sensor": Kind("sun" + CHANGES, 5e-3, spoil=vary_size(SUN, add_step)),
    "step of the gyro": Kind(DRIFTS, 2e-3, spoil=vary_size(change_gyro, add_step)),
    "drift of the magnetometer": Kind("mag" + CHANGES, 100.0, spoil=vary_size(MAG, add_drift)),
    "drift of the Sun sensor": Kind("sun" + CHANGES, 5e-3, spoil=vary_size(SUN, add_drift)),
    "drift of the gyro": Kind(DRIFTS, 2e-3, spoil=vary_size(change_gyro, add_drift)),
    "walk of the gyro": Kind(DRIFTS, 2e-3, spoil=vary_size(change_gyro, add_random_walk)),
    "orbit": Kind(
        "the satellite is .* the declared orbit", 2.0, lambda size, rng: TrueErrors(behind=size)
    ),
    "magnetometer and temperature": Kind(
        r"mag\.bias (depends on temperature|changes) by ",
        100.0,
        spoil=vary_size(MAG, add_temperature_bias),
    ),
    "Sun sensor and temperature": Kind(
        r"sun\.bias (depends on temperature|changes) by ",
        5e-3,
        spoil=vary_size(SUN, add_temperature_bias),
    ),
    "gyro and temperature": Kind(
        r"gyro\.bias (depends on temperature|drifts|changes) by ",
        2e-3,
        spoil=vary_size(change_gyro, add_temperature_bias),
    ),
    "decay of the gyro's bias": Kind(
        r"gyro\.bias (decays|drifts|changes) by ",
        0.02,
        lambda size, rng: TrueErrors(gyro_bias_deg_s=size * random_axis(rng), decay=0.0),
        scenario=LARGE_BIAS_SCENARIO,
    ),
}


def get_failure(scenario: Scenario, telemetry: Telemetry) -> str:
    """Return why a calibration fails or is inconsistent; empty if it is consistent."""
    try:
        calibration = calibrate(scenario, telemetry)
    except ValueError as error:
        return str(error)
    return str(calibration.failures[0]) if calibration.failures else ""


def run_kind(kind: Kind) -> list[tuple[float, float, bool]]:
    """Print what `calibrate` reports of flights with a fault; return sigmas, power and success of
    each.
    """
    sizes, results = {seed: kind.compute_sizes(seed) for seed in SEEDS}, []
    for i, sigmas in enumerate(SIGMAS):
        for seed in SEEDS:
            size = sizes[seed][i]
            failure = get_failure(kind.scenario, kind.simulate(size, seed, 100 + seed))
            power, is_right = kind.compute_power(size, seed), names_cause(kind.cause, failure)
            results.append((sigmas, power, is_right))
            words = "right" if is_right else failure[:90] or "nothing"
            print(f"  {sigmas:g} sigma, size {size:.2g}, power {power:.2f}: {words}", flush=True)
    return results


def print_summary(results: list[tuple[float, float, bool]]) -> None:
    """Print how many faults are reported, and how many the most powerful tests would detect."""
    for sigmas in SIGMAS:
        selected = [(power, is_right) for each, power, is_right in results if each == sigmas]
        detectable = [is_right for power, is_right in selected if power >= DETECTABLE_POWER]
        print(
            f"{sigmas:g} sigma: {sum(is_right for _, is_right in selected)} of {len(selected)} "
            "faults are reported, where the most powerful tests detect "
            f"{sum(power for power, _ in selected):.1f}. Of {len(detectable)} faults with a "
            f"power of {DETECTABLE_POWER:.0%} or more, {sum(detectable)} are reported"
        )


def run_healthy_flights() -> None:
    """Print the number of flights without a fault whose calibration fails or is inconsistent."""
    for name, count in HEALTHY.items():
        scenario = short(getattr(Scenario, name)(), DURATION)
        failures = []
        for seed in range(count):
            telemetry = simulate_readings(scenario, MOTION, 7000 + seed, duration=DURATION)
            if failure := get_failure(scenario, add_temperature(telemetry)):
                failures.append(failure)
        print(
            f"  {name}: {len(failures)} of {count} {[failure[:90] for failure in failures]}",
            flush=True,
        )


if __name__ == "__main__":
    rows = []
    for kind in sys.argv[1:] or [*KINDS, "healthy"]:
        print(kind, flush=True)
        if kind == "healthy":
            run_healthy_flights()
        else:
            rows += [(kind, *result) for result in run_kind(KINDS[kind])]
    print_summary([row[1:] for row in rows])
    if not sys.argv[1:]:
        table = pd.DataFrame(rows, columns=["kind", "sigmas", "power", "is_reported"])
        table.to_csv(VALIDATION_DATA / "detection.csv", index=False, lineterminator="\n")
