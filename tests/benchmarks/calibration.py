"""``python -m tests.benchmarks.calibration FLIGHTS``: the table of docs/calibration.md.

Many flights from any attitude, calibrated, beside the time that a calibration takes.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mgeo_attitude import Environment, Scenario, StarTracker, Telemetry, calibrate
from scipy.stats import chi2

from tests.attitude.calibration.flights import (
    PLAN,
    flown,
    normalized,
    short,
    thinned,
    with_holes,
    with_outliers,
)

from .consistency_document import with_table

PAGE = Path(__file__).parents[2] / "docs" / "calibration.md"
FIRST = 1000  # seed, which no test has

Spoil = Callable[[Telemetry, np.random.Generator], Telemetry]


def spoiled(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
    """A fifth of all samples lost, and one in a hundred turned anywhere."""
    return with_outliers(with_holes(telemetry, 0.2, rng), 0.01, rng)[0]


CASES: dict[str, tuple[str, float, Spoil]] = {
    "paper": ("paper", 1.0, lambda t, rng: t),
    "cubesat_6u": ("cubesat_6u", 1.0, lambda t, rng: t),
    "paper, 20 % lost, 1 % outliers": ("paper", 1.0, spoiled),
    "cubesat_6u, 20 % lost, 1 % outliers": ("cubesat_6u", 1.0, spoiled),
    "paper, gyro at 4 Hz, magnetometer at 0.2 Hz": (
        "paper",
        0.25,
        lambda t, rng: thinned(t, "mag", 20),
    ),
}


def row(name: str, flights: int) -> str:
    """A row of the table."""
    preset, step, spoil = CASES[name]
    scenario = short(getattr(Scenario, preset)(), 3000.0, step=step)
    environment = Environment.from_scenario(scenario)
    nees, x, supported = [], [], 0
    for seed in range(FIRST, FIRST + flights):
        telemetry = flown(scenario, seed, environment)
        found = calibrate(scenario, spoil(telemetry, np.random.default_rng(seed)))
        one = normalized(found, telemetry)
        nees.append(one[0])
        x.append(one[1])
        supported += found.supported
    rms = np.sqrt(np.mean(np.square(x), axis=0))
    low, high = chi2.ppf([0.005, 0.995], 18 * flights) / (18 * flights)
    return (
        f"| {name} | {flights} | {np.mean(nees):.3f} | {low:.3f} to {high:.3f} "
        f"| {rms.min():.2f} to {rms.max():.2f} | {100.0 * supported / flights:.0f} % |"
    )


def seconds() -> tuple[int, float]:
    """Samples of three sensors over two orbits, and the time of a process that calibrates them."""
    table = Scenario.paper().to_dict()
    scenario = Scenario.from_dict(
        table | {"sensors": [*table["sensors"], {"kind": StarTracker.kind}]}
    )
    with tempfile.TemporaryDirectory() as folder:
        scenario.save(Path(folder, "s.toml"))
        telemetry = flown(scenario, FIRST, plan=PLAN)
        telemetry.to_csv(Path(folder, "t.csv"))
        code = "from mgeo_attitude import *; calibrate(Scenario.from_toml('s.toml'), 't.csv')"
        spent = []
        for _ in range(3):
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", code], cwd=folder, check=True)
            spent.append(time.perf_counter() - start)
    return len(telemetry.times), min(spent)


def main() -> None:
    """Write the table into the page."""
    flights = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    samples, spent = seconds()
    print(samples, spent)
    lines = [
        "| | flights | NEES per state | of a perfect filter, 99 % | rms error / 1-sigma, by state "
        "| supported |",
        "| --- | ---: | ---: | --- | --- | ---: |",
    ]
    for name in CASES:
        lines.append(row(name, flights))
        print(lines[-1], flush=True)
    text = with_table(PAGE.read_text(encoding="utf-8"), "flights", "\n".join(lines))
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
