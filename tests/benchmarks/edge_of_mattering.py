"""Faults as large as just matter: which of them `calibrate` names, and what of healthy flights.

    python -m tests.benchmarks.edge_of_mattering [kinds...]   # healthy is one

The size of a fault is not chosen by what is named: it is that which moves the worst estimate of a
flight by so many of its 1-sigmas (`SIGMAS`). What is named is asked of flights with other noise.

Beside it is the power of the best test there is, that of a fault whose every number is known but
its size (Neyman and Pearson): what estimates absorb no test sees.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
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
#: How many tests `calibrate` makes of these flights, and from which power on one should succeed.
TESTS, ABLE = 29, 0.9
QUIET = 1e-4
MOTION = constant_rates(PLAN)
HEALTHY = {"cubesat_6u": 100, "paper": 100}

Spoil = Callable[[Telemetry, np.random.Generator], Telemetry]


@dataclass(frozen=True)
class Kind:
    """A fault of any size: its cause, what is true or sent down, and the size to begin with."""

    cause: str
    first: float
    craft: Callable[[float, np.random.Generator], TrueErrors] = lambda size, rng: TrueErrors()
    spoil: Callable[[float], Spoil] = lambda size: lambda telemetry, rng: telemetry
    scenario: Scenario = SCENARIO

    def fly(self, size: float, seed: int, noise: int) -> Telemetry:
        """A flight with the fault of a seed and the noise of another."""
        rng = np.random.default_rng([seed, 480])
        flown = simulate_readings(self.scenario, MOTION, noise, self.craft(size, rng), DURATION)
        return self.spoil(size)(with_temperature(flown), rng)

    def power(self, size: float, seed: int) -> float:
        """Of the best test of the fault of a seed, at the level that `calibrate` has.

        What it does to readings, that of a satellite without noise or errors, is a mean of normal
        numbers. The least sum of squares that any estimate leaves of it is the non-centrality.
        """
        quiet, belief = quiet_scenario(self.scenario), PriorEstimate.from_scenario(self.scenario)
        rng = np.random.default_rng([seed, 480])
        craft = self.craft(size, rng)
        without = TrueErrors(gyro_bias_deg_s=craft.gyro_bias_deg_s)
        base, healthy, spoiled = (
            simulate_readings(quiet, MOTION, 100 + seed, each, DURATION)
            for each in (exact(TrueErrors()), exact(without), exact(craft))
        )
        spoiled = self.spoil(size)(spoiled, rng)
        told = dataclasses.replace(
            base,
            gyro_deg_s=base.gyro_deg_s + spoiled.gyro_deg_s - healthy.gyro_deg_s,
            sensors={
                name: rows + spoiled.sensors[name] - healthy.sensors[name]
                for name, rows in base.sensors.items()
            },
        )
        assert base.truth is not None
        attitude = np.ascontiguousarray(base.truth.attitude.swapaxes(1, 2))
        at = Trajectory(attitude, np.tile(belief.states, (len(base.times), 1)))
        solution = solve(build_batch(self.scenario, told), belief, at, 30)
        assert solution.is_converged()
        level = norm.isf(0.5 * SIGNIFICANCE / TESTS)
        return float(norm.sf(level - np.sqrt(solution.cost)))

    def off(self, size: float, seed: int) -> float:
        """By how many 1-sigmas the fault moves the worst estimate away from the truth."""
        error, sigma = errors(self.scenario, self.fly(size, seed, seed))
        return float(np.abs((error - healthy_errors(self.scenario, seed)) / sigma).max())

    def sizes(self, seed: int) -> tuple[float, ...]:
        """That are off by `SIGMAS`, nearly in proportion to one near the first."""
        near = self.first * SIGMAS[0] / self.off(self.first, seed)
        slope = self.off(near, seed) / near
        return tuple(sigmas / slope for sigmas in SIGMAS)


def quiet_scenario(scenario: Scenario) -> Scenario:
    """With hardly any noise."""
    gyro = scenario.gyro
    return dataclasses.replace(
        scenario,
        gyro=dataclasses.replace(
            gyro,
            angle_random_walk_deg_per_sqrt_h=QUIET * gyro.angle_random_walk_deg_per_sqrt_h,
            rate_random_walk=QUIET * gyro.rate_random_walk,
        ),
        sensors=tuple(scale_noise(sensor, QUIET) for sensor in scenario.sensors),
    )


def exact(craft: TrueErrors) -> TrueErrors:
    """Without the errors that would be drawn."""
    names = ("gyro_bias_deg_s", "sun_bias", "mag_bias_nt", "sun_turn_deg", "mag_turn_deg")
    none = {name: np.zeros(3) for name in names if getattr(craft, name) is None}
    return dataclasses.replace(craft, **none)


def errors(scenario: Scenario, telemetry: Telemetry) -> tuple[np.ndarray, np.ndarray]:
    """Truth less estimate of gyro and sensors at the last sample, and 1-sigmas."""
    belief = PriorEstimate.from_scenario(scenario)
    states, P = compute_final_estimate(belief, fit(build_batch(scenario, telemetry), belief, 1e-5))
    assert telemetry.truth is not None
    return (telemetry.truth.states[-1] - states)[3:], np.sqrt(np.diag(P))[3:]


@cache
def healthy_errors(scenario: Scenario, seed: int) -> np.ndarray:
    """With the same noise and no fault."""
    return errors(
        scenario, with_temperature(simulate_readings(scenario, MOTION, seed, duration=DURATION))
    )[0]


def with_temperature(flown: Telemetry) -> Telemetry:
    return dataclasses.replace(flown, housekeeping={"temperature": temperature(flown.times)})


def late(name: str) -> Callable[[float, np.random.Generator], TrueErrors]:
    return lambda size, rng: TrueErrors(late={name: size})


def of(where: Callable, change: Callable) -> Callable[[float], Spoil]:
    """A change of readings, of any size."""
    return lambda size: where(change(size))


MAG, SUN = partial(change_sensor, "mag"), partial(change_sensor, "sun")
UNSURE = dataclasses.replace(
    SCENARIO, gyro=dataclasses.replace(SCENARIO.gyro, initial_bias_deg_s=1.0, bias_decay=1e-5)
)
DRIFTS, CHANGES = r"gyro\.bias (drifts|decays|changes) by ", r"\.bias changes by "
KINDS = {
    "magnetometer late": Kind("mag is .* s late", 0.1, late("mag")),
    "magnetometer early": Kind("mag is .* s early", -0.1, late("mag")),
    "Sun sensor late": Kind("sun is .* s late", 0.1, late("sun")),
    "Sun sensor early": Kind("sun is .* s early", -0.1, late("sun")),
    "magnetometer's scale": Kind(r"mag\.scale_factor is ", 2e-3, spoil=of(MAG, add_scale_error)),
    "soft iron": Kind(r"mag\.nonorthogonality is ", 0.1, spoil=of(MAG, add_nonorthogonality)),
    "gyro's scale": Kind(r"gyro\.scale_factor is ", 2e-3, spoil=of(change_gyro, add_scale_error)),
    "gyro's axes": Kind(
        r"gyro\.nonorthogonality is ", 0.1, spoil=of(change_gyro, add_nonorthogonality)
    ),
    "step of the magnetometer": Kind("mag" + CHANGES, 100.0, spoil=of(MAG, add_step)),
    "step of the Sun sensor": Kind("sun" + CHANGES, 5e-3, spoil=of(SUN, add_step)),
    "step of the gyro": Kind(DRIFTS, 2e-3, spoil=of(change_gyro, add_step)),
    "drift of the magnetometer": Kind("mag" + CHANGES, 100.0, spoil=of(MAG, add_drift)),
    "drift of the Sun sensor": Kind("sun" + CHANGES, 5e-3, spoil=of(SUN, add_drift)),
    "drift of the gyro": Kind(DRIFTS, 2e-3, spoil=of(change_gyro, add_drift)),
    "walk of the gyro": Kind(DRIFTS, 2e-3, spoil=of(change_gyro, add_random_walk)),
    "orbit": Kind(
        "the satellite is .* its orbit", 2.0, lambda size, rng: TrueErrors(behind=size)
    ),
    "magnetometer and temperature": Kind(
        r"mag\.bias (follows temperature|changes) by ", 100.0, spoil=of(MAG, add_temperature_bias)
    ),
    "Sun sensor and temperature": Kind(
        r"sun\.bias (follows temperature|changes) by ", 5e-3, spoil=of(SUN, add_temperature_bias)
    ),
    "gyro and temperature": Kind(
        r"gyro\.bias (follows temperature|drifts|changes) by ",
        2e-3,
        spoil=of(change_gyro, add_temperature_bias),
    ),
    "decay of the gyro's bias": Kind(
        r"gyro\.bias (decays|drifts|changes) by ",
        0.02,
        lambda size, rng: TrueErrors(gyro_bias_deg_s=size * random_axis(rng), decay=0.0),
        scenario=UNSURE,
    ),
}  # fmt: skip


def first_line(scenario: Scenario, telemetry: Telemetry) -> str:
    """Why a calibration is not supported; empty where it is."""
    try:
        found = calibrate(scenario, telemetry)
    except ValueError as error:
        return str(error)
    return found.failures[0] if found.failures else ""


def named(kind: Kind) -> list[tuple[float, float, bool]]:
    """Print what is said of flights with a fault; sigmas, power and whether it is right of each."""
    sizes, found = {seed: kind.sizes(seed) for seed in SEEDS}, []
    for i, sigmas in enumerate(SIGMAS):
        for seed in SEEDS:
            size = sizes[seed][i]
            said = first_line(kind.scenario, kind.fly(size, seed, 100 + seed))
            power, right = kind.power(size, seed), names_cause(kind.cause, said)
            found.append((sigmas, power, right))
            words = "right" if right else said[:90] or "nothing"
            print(f"  {sigmas:g} sigma, size {size:.2g}, power {power:.2f}: {words}", flush=True)
    return found


def summary(found: list[tuple[float, float, bool]]) -> None:
    """Print how many are named beside what the best tests would see."""
    for sigmas in SIGMAS:
        of = [(power, right) for each, power, right in found if each == sigmas]
        able = [right for power, right in of if power >= ABLE]
        print(
            f"{sigmas:g} sigma: {sum(right for _, right in of)} of {len(of)} are named, "
            f"{sum(power for power, _ in of):.1f} are what the best tests see; of the {len(able)} "
            f"that these see in {ABLE:.0%} of flights {sum(able)}"
        )


def healthy() -> None:
    """Print how many flights without a fault have one named, or are not supported otherwise."""
    for name, count in HEALTHY.items():
        scenario = short(getattr(Scenario, name)(), DURATION)
        said = []
        for seed in range(count):
            flown = simulate_readings(scenario, MOTION, 7000 + seed, duration=DURATION)
            if line := first_line(scenario, with_temperature(flown)):
                said.append(line)
        print(f"  {name}: {len(said)} of {count} {[line[:90] for line in said]}", flush=True)


if __name__ == "__main__":
    results = []
    for kind in sys.argv[1:] or [*KINDS, "healthy"]:
        print(kind, flush=True)
        if kind == "healthy":
            healthy()
        else:
            results += named(KINDS[kind])
    summary(results)
