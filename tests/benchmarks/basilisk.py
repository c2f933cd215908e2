"""Simulate flights of plans with Basilisk and calibrate, for docs/validation/basilisk.md.

``OMP_NUM_THREADS=1 python -m tests.benchmarks.basilisk 50`` simulates 50 flights of each plan. A
flight that is already in docs/validation/data/basilisk.jsonl is not repeated. Flights of all plans
alternate, so that all plans have the same number of flights whenever the script is stopped.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem, run_reference_filter
from mgeo_attitude.geometry.rotation import rotation_matrix, rotation_vector
from mgeo_calibration.calibration.calibrate import calibrate
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry
from mgeo_calibration.telemetry.telemetry import Truth

from ..three import three
from .pages import ROOT, VALIDATION_DATA, add_result, read_results

RESULTS = VALIDATION_DATA / "basilisk.jsonl"
PLANS = json.loads(
    (ROOT / "tests/calibration/simulators/basilisk/plans.json").read_text(encoding="utf-8")
)["scenarios"]
FIRST_SEED = 9000
ENDS = ("at t_end", "at the end")


@cache
def build_problem(name: str) -> AttitudeManeuverProblem:
    return AttitudeManeuverProblem(three(name))


@cache
def predict_sigma(name: str, number: int) -> dict[str, Any]:
    """Return t_end of a plan and the 1-sigma of all states by the linear covariance, at t_end and
    at the end.
    """
    model, plan = build_problem(name).model, PLANS[name][number]
    full_duration_model = dataclasses.replace(model, window_steps=model.n_steps + 1)
    history, full_history = (
        run_reference_filter(each_model, plan["design"])
        for each_model in (model, full_duration_model)
    )
    return {
        "t_end": history.t_end,
        "at t_end": history.sigma[-1],
        "at the end": full_history.sigma[-1],
    }


def compute_errors(calibration: Calibration, truth: Truth) -> np.ndarray:
    """Return truth minus estimate at the last sample; errors of rotations are rotation vectors."""
    suite, e = calibration.suite, truth.states[-1] - calibration.states
    assert calibration.history is not None
    for first in suite.rotation_indices[1:]:
        block = slice(first, first + 3)
        rotation_error = rotation_matrix(calibration.states[block]).T @ rotation_matrix(
            truth.states[-1, block]
        )
        e[block] = rotation_vector(rotation_error)
    e[:3] = rotation_vector(calibration.history.smoothed_attitude[-1] @ truth.attitude[-1].T)
    return e


def run_case(case: tuple[str, int, int]) -> list[dict[str, Any]]:
    """Simulate one flight of a plan, and calibrate with its telemetry until t_end and with all of
    its telemetry.
    """
    name, number, seed = case
    problem, predicted, start = (
        build_problem(name),
        predict_sigma(name, number),
        time.perf_counter(),
    )
    telemetry = simulate_telemetry(
        problem.scenario, PLANS[name][number]["design"], seed, environment=problem.environment
    )
    flight_seconds, rows = time.perf_counter() - start, []
    for end_name, end in (
        ("at t_end", predicted["t_end"]),
        ("at the end", problem.scenario.duration),
    ):
        truncated, start = telemetry.truncate(end), time.perf_counter()
        row: dict[str, Any] = {
            "key": [name, number, seed, end_name],
            "t": end,
            "flight s": flight_seconds,
        }
        try:
            calibration = calibrate(problem.scenario, truncated)
        except ValueError as error:
            rows.append(row | {"refused": str(error)})
            continue
        assert truncated.truth is not None
        e, P = compute_errors(calibration, truncated.truth), calibration.covariance
        rows.append(
            row
            | {
                "calibration s": time.perf_counter() - start,
                "errors": e.tolist(),
                "sigma": np.sqrt(np.diag(P)).tolist(),
                "predicted": predicted[end_name].tolist(),
                "nees": float(e @ np.linalg.solve(P, e)),
                "nis": {test.sensor: test.nis for test in calibration.tests},
                "consistent": bool(calibration.is_consistent),
                "rejected": len(calibration.outliers),
            }
        )
    return rows


def main(n_flights: int) -> None:
    stored = {tuple(row["key"][:3]) for row in read_results(RESULTS)}
    cases = [
        (name, number, FIRST_SEED + 1000 * number + flight)  # The seeds of pooled plans differ.
        for flight, number, name in product(range(n_flights), range(4), PLANS)
    ]
    with ProcessPoolExecutor(2) as pool:
        for rows in pool.map(run_case, [case for case in cases if case not in stored]):
            for row in rows:
                add_result(RESULTS, row)


if __name__ == "__main__":
    main(int(sys.argv[1]))
