"""Simulate tumbling satellites, and Sun sensors that report unit vectors, with Basilisk, and
calibrate.

``OMP_NUM_THREADS=1 python -m tests.benchmarks.basilisk_tumbles 50`` simulates 50 flights of each
kind. A flight that is already in docs/validation/data/basilisk_tumbles.jsonl is not repeated.
"""

from __future__ import annotations

import dataclasses
import sys
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

from .basilisk import PLANS, compute_errors
from .pages import VALIDATION_DATA, add_result, read_results

RESULTS = VALIDATION_DATA / "basilisk_tumbles.jsonl"
DURATION = 3000.0
FIRST_SEED = 48000
#: Initial rates of the tumbling satellites [deg/s].
TUMBLES = {"paper": (0.8, -0.6, 1.1), "cubesat_6u": (3.0, -2.0, 3.0)}
#: For each kind: whether the satellite tumbles, and whether its Sun sensor reports unit vectors.
KINDS = {
    "tumbles": (True, False),
    "flies a plan, unit vectors": (False, True),
    "tumbles, unit vectors": (True, True),
}


@cache
def build_scenario(name: str, kind: str) -> tuple[Scenario, Environment]:
    tumbles, normalized = KINDS[kind]
    preset = Scenario.from_dict({"preset": name})
    sun, mag = preset.sensors
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
    if tumbles:  # Magnetorquers that are off give free rotation by Euler's equations.
        inertia = Vehicle.from_scenario(preset).wheels.inertia
        changes["magnetorquers"] = Magnetorquers(max_dipole=(0.2, 0.2, 0.2), inertia=inertia)
        changes["initial"] = InitialConditions(
            rate_deg_s=TUMBLES[name], attitude_deg=preset.initial.attitude_deg
        )
    scenario = dataclasses.replace(
        preset, duration=DURATION, convergence=Convergence(window=DURATION), **changes
    )
    return scenario, Environment.from_scenario(scenario)


def run_case(case: tuple[str, str, int]) -> dict[str, Any]:
    """Simulate and calibrate one flight, and return its result as a dict that becomes JSON."""
    name, kind, number = case
    scenario, environment = build_scenario(name, kind)
    design = [] if KINDS[kind][0] else PLANS[name][1]["design"]
    row: dict[str, Any] = {"key": list(case)}
    seed = FIRST_SEED + 1000 * list(KINDS).index(kind) + number  # The seeds of all flights differ.
    telemetry = simulate_telemetry(scenario, design, seed, environment=environment)
    try:
        calibration = calibrate(scenario, telemetry)
    except ValueError as error:
        return row | {"refused": str(error)}
    assert telemetry.truth is not None
    e, P = compute_errors(calibration, telemetry.truth), calibration.covariance
    z = e / np.sqrt(np.diag(P))
    return row | {
        "nees": round(float(e @ np.linalg.solve(P, e)) / len(e), 4),
        "greatest": round(float(np.abs(z).max()), 2),
        "rms": [round(float(each), 3) for each in np.sqrt((z.reshape(-1, 3) ** 2).mean(axis=1))],
        "consistent": bool(calibration.is_consistent),
    }


def main(n_flights: int) -> None:
    stored = {tuple(row["key"]) for row in read_results(RESULTS)}
    cases = [(name, kind, n) for n, kind, name in product(range(n_flights), KINDS, TUMBLES)]
    with ProcessPoolExecutor(1) as pool:
        for row in pool.map(run_case, [case for case in cases if case not in stored]):
            add_result(RESULTS, row)


if __name__ == "__main__":
    main(int(sys.argv[1]))
