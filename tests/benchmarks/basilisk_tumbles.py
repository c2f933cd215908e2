"""Fly tumbling satellites and Sun sensors of unit vectors by Basilisk, and calibrate.

    OMP_NUM_THREADS=1 python -m tests.benchmarks.basilisk_tumbles 50  # flights of each kind

A flight that docs/basilisk_tumbles.jsonl has already is not repeated. The script prints the table
that docs/basilisk.md sums up.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.scenario import Convergence, InitialConditions, Magnetorquers
from mgeo_attitude.sensors import TwoAxisSunSensor
from mgeo_calibration.calibration.calibrate import calibrate
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry
from mgeo_calibration.simulators.basilisk.vehicle import Vehicle

from .basilisk import PLANS, band, errors
from .pages import DOCS, add_result, read_results

RESULTS = DOCS / "basilisk_tumbles.jsonl"
DURATION = 3000.0
FIRST_SEED = 48000
#: Rates [deg/s] of satellites that nothing turns.
TUMBLES = {"paper": (0.8, -0.6, 1.1), "cubesat_6u": (3.0, -2.0, 3.0)}
#: Whether it tumbles, and whether its Sun sensor reports unit vectors.
KINDS = {
    "tumbles": (True, False),
    "flies a plan, unit vectors": (False, True),
    "tumbles, unit vectors": (True, True),
}


@cache
def scenario(name: str, kind: str) -> tuple[Scenario, Environment]:
    """Of a preset, with its environment."""
    tumbles, normalized = KINDS[kind]
    given = Scenario.from_dict({"preset": name})
    sun, mag = given.sensors
    changes: dict[str, Any] = {}
    if normalized:
        changes["sensors"] = (
            TwoAxisSunSensor(
                name="sun",
                noise_deg=sun.noise_deg,
                initial_misalignment_deg=sun.initial_misalignment_deg,
            ),
            mag,
        )
    if tumbles:  # coils that are off: Euler's equations without torque
        body = Vehicle.from_scenario(given).wheels.inertia
        changes["magnetorquers"] = Magnetorquers(max_dipole=(0.2, 0.2, 0.2), inertia=body)
        changes["initial"] = InitialConditions(
            rate_deg_s=TUMBLES[name], attitude_deg=given.initial.attitude_deg
        )
    made = dataclasses.replace(
        given, duration=DURATION, convergence=Convergence(window=DURATION), **changes
    )
    return made, Environment.from_scenario(made)


def run(case: tuple[str, str, int]) -> dict[str, Any]:
    """One flight, and its calibration."""
    name, kind, number = case
    of, environment = scenario(name, kind)
    design = [] if KINDS[kind][0] else PLANS[name][1]["design"]
    row: dict[str, Any] = {"key": list(case)}
    seed = FIRST_SEED + 1000 * list(KINDS).index(kind) + number  # no draw twice
    telemetry = simulate_telemetry(of, design, seed, environment=environment)
    try:
        found = calibrate(of, telemetry)
    except ValueError as error:
        return row | {"refused": str(error)}
    assert telemetry.truth is not None
    e, P = errors(found, telemetry.truth), found.covariance
    z = e / np.sqrt(np.diag(P))
    return row | {
        "nees": round(float(e @ np.linalg.solve(P, e)) / len(e), 4),
        "greatest": round(float(np.abs(z).max()), 2),
        "rms": [round(float(each), 3) for each in np.sqrt((z.reshape(-1, 3) ** 2).mean(axis=1))],
        "supported": bool(found.is_consistent),
    }


def table(rows: list[dict[str, Any]]) -> Iterator[str]:
    """A row for each kind: NEES per state, where 99 % of perfect ones are, and how many hold."""
    yield "| | " + " | ".join(TUMBLES) + " |"
    yield "| --- |" + " ---: |" * len(TUMBLES)
    for kind in KINDS:
        cells = []
        for name in TUMBLES:
            found = [row for row in rows if row["key"][:2] == [name, kind] and "nees" in row]
            low, high = band(max(len(found), 1) * scenario(name, kind)[0].suite.n_states)
            nees = np.mean([row["nees"] for row in found])
            held = sum(row["consistent"] for row in found)
            cells.append(f"{nees:.2f} ({low:.2f} to {high:.2f}), {held} of {len(found)}")
        yield f"| {kind} | " + " | ".join(cells) + " |"


def main(n_flights: int) -> None:
    known = {tuple(row["key"]) for row in read_results(RESULTS)}
    cases = [(name, kind, n) for n, kind, name in product(range(n_flights), KINDS, TUMBLES)]
    with ProcessPoolExecutor(1) as pool:
        for row in pool.map(run, [case for case in cases if case not in known]):
            add_result(RESULTS, row)
    print(*table(read_results(RESULTS)), sep="\n")


if __name__ == "__main__":
    main(int(sys.argv[1]))
