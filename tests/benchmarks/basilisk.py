"""Flies plans by Basilisk and calibrates from the telemetry, for the table of docs/basilisk.md.

    OMP_NUM_THREADS=1 python -m tests.benchmarks.basilisk 50  # flights of each plan
    python -m tests.benchmarks.basilisk_document

A flight that is in docs/basilisk.jsonl already is not flown again. Flights of all plans take turns,
so that the file is balanced whenever it is stopped.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem, reference_run
from mgeo_attitude.geometry.rotation import matrix, rotation_vector
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.from_telemetry import calibrate
from mgeo_calibration.flight.basilisk.fly import fly
from mgeo_calibration.telemetry.telemetry import Truth

from ..three import three

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "docs" / "basilisk.jsonl"
PLANS = json.loads(
    (ROOT / "tests/calibration/flight/basilisk/plans.json").read_text(encoding="utf-8")
)["scenarios"]
FIRST_SEED = 9000


@cache
def problem(name: str) -> AttitudeManeuverProblem:
    return AttitudeManeuverProblem(three(name))


@cache
def promised(name: str, number: int) -> dict[str, Any]:
    """1-sigma of every state by the linear covariance, when it has converged and at the end."""
    model, plan = problem(name).model, PLANS[name][number]
    endless = dataclasses.replace(model, window_steps=model.n_steps + 1)
    history, whole = (reference_run(one, plan["design"]) for one in (model, endless))
    return {"t_end": history.t_end, "at t_end": history.sigma[-1], "at the end": whole.sigma[-1]}


def errors(found: Calibration, truth: Truth) -> np.ndarray:
    """Truth less estimate at the last sample, of rotations the vectors of what remains."""
    suite, e = found.suite, truth.states[-1] - found.states
    assert found.history is not None
    for first in suite.rotations[1:]:
        block = slice(first, first + 3)
        remains = matrix(found.states[block]).T @ matrix(truth.states[-1, block])
        e[block] = rotation_vector(remains)
    e[:3] = rotation_vector(found.history.smoothed[-1] @ truth.attitude[-1].T)
    return e


def run(case: tuple[str, int, int]) -> list[dict[str, Any]]:
    """One flight of a plan, calibrated from all of it and from what the plan asks for."""
    name, number, seed = case
    p, promise, start = problem(name), promised(name, number), time.perf_counter()
    telemetry = fly(p.scenario, PLANS[name][number]["design"], seed, environment=p.environment)
    flown, rows = time.perf_counter() - start, []
    for when, end in (("at t_end", promise["t_end"]), ("at the end", p.scenario.duration)):
        part, start = telemetry.until(end), time.perf_counter()
        row: dict[str, Any] = {"key": [name, number, seed, when], "t": end, "flight s": flown}
        try:
            found = calibrate(p.scenario, part)
        except ValueError as error:
            rows.append(row | {"refused": str(error)})
            continue
        assert part.truth is not None
        e, P = errors(found, part.truth), found.covariance
        rows.append(
            row
            | {
                "calibration s": time.perf_counter() - start,
                "errors": e.tolist(),
                "sigma": np.sqrt(np.diag(P)).tolist(),
                "promised": promise[when].tolist(),
                "nees": float(e @ np.linalg.solve(P, e)),
                "nis": {test.sensor: test.nis for test in found.tests},
                "supported": bool(found.supported),
                "rejected": len(found.rejected),
            }
        )
    return rows


def stored() -> list[dict[str, Any]]:
    text = RESULTS.read_text(encoding="utf-8") if RESULTS.exists() else ""
    return [json.loads(line) for line in text.splitlines()]


def main(n_flights: int) -> None:
    known = {tuple(row["key"][:3]) for row in stored()}
    cases = [
        (name, number, FIRST_SEED + 1000 * number + flight)  # plans are pooled: no draw twice
        for flight, number, name in product(range(n_flights), range(4), PLANS)
    ]
    with (
        ProcessPoolExecutor(2) as pool,
        RESULTS.open("a", encoding="utf-8") as file,
    ):
        for rows in pool.map(run, [case for case in cases if case not in known]):
            file.writelines(json.dumps(row) + "\n" for row in rows)
            file.flush()
            print(rows[-1]["key"], [round(row.get("nees", np.nan), 1) for row in rows], flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]))
