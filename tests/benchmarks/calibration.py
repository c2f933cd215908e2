"""Calibrate many simulated flights from any attitude, for docs/calibration.md.

python -m tests.benchmarks.calibration 200  # flights of each case
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

FIRST = 1000  # seed, which no test has
SECOND = (-0.4, 0.2, 0.5, 300.0, 0.6, 0.5, -0.3, 300.0, 0.1, -0.6, -0.4, 300.0)

Spoil = Callable[[Telemetry, np.random.Generator], Telemetry]


def spoiled(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
    """A fifth of all samples lost, and one in a hundred turned anywhere."""
    return add_outliers(remove_samples(telemetry, 0.2, rng), 0.01, rng)[0]


@dataclass(frozen=True)
class Case:
    """Flights of a preset, how they are spoiled, and whether they are second ones."""

    preset: str
    step: float = 1.0
    spoil: Spoil = lambda telemetry, rng: telemetry
    second: bool = False


CASES: dict[str, Case] = {
    "paper": Case("paper"),
    "cubesat_6u": Case("cubesat_6u"),
    "paper, 20 % lost, 1 % outliers": Case("paper", spoil=spoiled),
    "cubesat_6u, 20 % lost, 1 % outliers": Case("cubesat_6u", spoil=spoiled),
    "paper, second flight": Case("paper", second=True),
    "cubesat_6u, second flight": Case("cubesat_6u", second=True),
    "paper, gyro at 4 Hz, magnetometer at 0.2 Hz": Case(
        "paper", 0.25, lambda telemetry, rng: thin_samples(telemetry, "mag", 20)
    ),
}


@cache
def scenario(name: str) -> tuple[Scenario, Environment]:
    case = CASES[name]
    found = short(getattr(Scenario, case.preset)(), 3000.0, step=case.step)
    return found, Environment.from_scenario(found)


def one(name: str, seed: int) -> tuple[float, np.ndarray, bool]:
    """NEES per state of a flight, all errors over their 1-sigma, and the conclusion."""
    case, (of, environment) = CASES[name], scenario(name)
    telemetry = simulate_from_any_attitude(of, seed, environment)
    found = calibrate(of, case.spoil(telemetry, np.random.default_rng(seed)))
    if case.second:
        after = found.build_followup_scenario({"duration": 900.0})
        telemetry = simulate_telemetry(after, SECOND, seed, initial_truth=telemetry.truth)
        found = calibrate(after, telemetry)
    return *normalize_error(found, telemetry), found.is_consistent


def row(name: str, flights: int, pool: Executor) -> str:
    """A row of the table."""
    seeds = range(FIRST, FIRST + flights)
    nees, x, supported = zip(*pool.map(partial(one, name), seeds), strict=True)
    rms = np.sqrt(np.mean(np.square(x), axis=0))
    return (
        f"| {name} | {np.mean(nees):.3f} "
        f"| {rms.min():.2f} to {rms.max():.2f} | {100.0 * sum(supported) / flights:.0f} % |"
    )


def main() -> None:
    """Print the table."""
    flights = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    print("| | NEES per state | rms error / 1-sigma, by state | supported |")
    print("| --- | ---: | --- | ---: |")
    with ProcessPoolExecutor(2) as pool:
        for name in CASES:
            print(row(name, flights, pool), flush=True)
    low, high = chi2.ppf([0.005, 0.995], 18 * flights) / (18 * flights)
    print(f"NEES of a perfect filter, 99 %: {low:.3f} to {high:.3f}")


if __name__ == "__main__":
    main()
