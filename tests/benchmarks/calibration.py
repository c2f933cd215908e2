"""Calibrate many simulated flights with an arbitrary initial attitude.

docs/validation/how-it-is-tested.md has the results.

``python -m tests.benchmarks.calibration 200`` calibrates 200 flights of each case.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from mgeo_attitude import Environment, Scenario
from mgeo_calibration import Telemetry, calibrate, simulate_telemetry
from scipy.stats import chi2

from tests.calibration.calibration.runs import (
    add_outliers,
    normalize_error,
    remove_samples,
    short,
    simulate_from_any_attitude,
    thin_samples,
)

FIRST_SEED = 1000  # no test uses seeds from here on
SECOND_DESIGN = (-0.4, 0.2, 0.5, 300.0, 0.6, 0.5, -0.3, 300.0, 0.1, -0.6, -0.4, 300.0)

Spoil = Callable[[Telemetry, np.random.Generator], Telemetry]


def degrade(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
    """Return telemetry in which 20 % of all samples are missing and 1 % of the readings are
    outliers.
    """
    return add_outliers(remove_samples(telemetry, 0.2, rng), 0.01, rng)[0]


@dataclass(frozen=True)
class Case:
    """Flights of a preset, with a function that degrades the telemetry.

    If `second` is true, a second flight is calibrated with the result of the first as its prior.
    """

    preset: str
    step: float = 1.0
    spoil: Spoil = lambda telemetry, rng: telemetry
    second: bool = False


CASES: dict[str, Case] = {
    "paper": Case("paper"),
    "cubesat_6u": Case("cubesat_6u"),
    "paper, 20 % lost, 1 % outliers": Case("paper", spoil=degrade),
    "cubesat_6u, 20 % lost, 1 % outliers": Case("cubesat_6u", spoil=degrade),
    "paper, second flight": Case("paper", second=True),
    "cubesat_6u, second flight": Case("cubesat_6u", second=True),
    "paper, gyro at 4 Hz, magnetometer at 0.2 Hz": Case(
        "paper", 0.25, lambda telemetry, rng: thin_samples(telemetry, "mag", 20)
    ),
}


@cache
def build_scenario(name: str) -> tuple[Scenario, Environment]:
    case = CASES[name]
    scenario = short(getattr(Scenario, case.preset)(), 3000.0, step=case.step)
    return scenario, Environment.from_scenario(scenario)


def calibrate_flight(name: str, seed: int) -> tuple[float, np.ndarray, bool]:
    """Return NEES per state, all errors over their 1-sigma, and whether the calibration is
    consistent.
    """
    case, (scenario, environment) = CASES[name], build_scenario(name)
    telemetry = simulate_from_any_attitude(scenario, seed, environment)
    calibration = calibrate(scenario, case.spoil(telemetry, np.random.default_rng(seed)))
    if case.second:
        followup = calibration.build_followup_scenario({"duration": 900.0})
        telemetry = simulate_telemetry(followup, SECOND_DESIGN, seed, initial_truth=telemetry.truth)
        calibration = calibrate(followup, telemetry)
    return *normalize_error(calibration, telemetry), calibration.is_consistent


def format_row(name: str, n_flights: int, pool: Executor) -> str:
    """Calibrate all flights of a case and return the row of the table."""
    seeds = range(FIRST_SEED, FIRST_SEED + n_flights)
    nees, errors, is_consistent = zip(
        *pool.map(partial(calibrate_flight, name), seeds), strict=True
    )
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    return (
        f"| {name} | {np.mean(nees):.3f} "
        f"| {rms.min():.2f} to {rms.max():.2f} | {100.0 * sum(is_consistent) / n_flights:.0f} % |"
    )


def main() -> None:
    n_flights = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    print("| | NEES per state | rms error / 1-sigma, by state | consistent |")
    print("| --- | ---: | --- | ---: |")
    with ProcessPoolExecutor(2) as pool:
        for name in CASES:
            print(format_row(name, n_flights, pool), flush=True)
    low, high = chi2.ppf([0.005, 0.995], 18 * n_flights) / (18 * n_flights)
    print(f"NEES of a consistent filter, 99 % bounds: {low:.3f} to {high:.3f}")


if __name__ == "__main__":
    main()
